// Makes src/timonel/web/static/vendor/ of what npm holds, so that neither a wheel nor a checkout needs Node.
//
// OpenBridge gives its palettes and its icons. Its components would need `unsafe-inline` in the style policy and cannot show
// a heading that is not known, so the instruments are drawn in its language by our own modules.
// Versions stand in package.json; vendor.json says what came from where, under which licence, with which hash.

import {createHash} from "node:crypto";
import {mkdir, readFile, rm, writeFile} from "node:fs/promises";
import {createRequire} from "node:module";
import {fileURLToPath} from "node:url";
import esbuild from "esbuild";
import subsetFont from "subset-font";

const ROOT = new URL("../", import.meta.url);
const MODULES = new URL("node_modules/", ROOT);
const TARGET = new URL("src/timonel/web/static/vendor/", ROOT);
const OPENBRIDGE = "@oicl/openbridge-webcomponents";
const THEMES = ["bright", "day", "dusk", "night"];
const FAMILIES = /^--(element|container|border|instrument|alert|on|normal|raised|selected|amplified|flat|indent)-/;
const DIGITS = " !\"#%&'()*+,-./0123456789:;<=>?ABCDEFGHIJKLMNOPQRSTUVWXYZ_abcdefghijklmnopqrstuvwxyz°·×′″–—−";
const LATIN_EXTENDED_A = String.fromCodePoint(...Array.from({length: 0x80}, (_, index) => 0x100 + index));
const ICONS = [
  "alarm-acknowledged-iec", "alarm-rectified-iec", "alarm-silenced-iec", "alarm-unacknowledged-iec",
  "warning-acknowledged-iec", "warning-rectified-iec", "warning-silenced-iec", "warning-unacknowledged-iec",
  "caution-color-iec", "alerts", "silence-iec", "sound", "sound-muted",
  "command-autopilot", "command-available", "command-in", "command-locked", "command-no", "command-request", "command-take",
  "palette-day-bright", "palette-day", "palette-dusk", "palette-night", "palette-dimming",
  "check-google", "close-google", "settings-iec", "standby-iec", "dashboard", "heading-h-up-proposal", "route", "trend",
  "own-ship-iec", "user", "sensor-gps-full",
];

/** @type {{file: string, package: string, version: string, licence: string, sha256: string, bytes: number}[]} */
const manifest = [];

async function describe(name) {
  const {version, license} = JSON.parse(await readFile(new URL(`${name}/package.json`, MODULES), "utf8"));
  return {package: name, version, licence: license};
}

async function keep(file, content, name) {
  const bytes = Buffer.from(content);
  await writeFile(new URL(file, TARGET), bytes);
  const sha256 = createHash("sha256").update(bytes).digest("hex");
  manifest.push({file, ...(await describe(name)), sha256, bytes: bytes.length});
}

function banner({package: name, version, licence}) {
  return `/*! ${name} ${version}, ${licence} */`;
}

async function bundle(file, contents, name) {
  const built = await esbuild.build({
    stdin: {contents, resolveDir: fileURLToPath(ROOT), loader: file.endsWith(".css") ? "css" : "js"},
    bundle: true, minify: true, format: "esm", target: "es2022", write: false, legalComments: "none",
    loader: {".png": "empty"}, banner: {[file.endsWith(".css") ? "css" : "js"]: banner(await describe(name))},
  });
  await keep(file, built.outputFiles[0].contents, name);
}

/** The variables of one palette, without pictures and what the console has no use for. */
function palette(css, theme) {
  const block = css.match(new RegExp(`:root\\[data-obc-theme="${theme}"\\] \\{([^}]*)\\}`))[1];
  const lines = block.split("\n").map((line) => line.trim().replace(/\d\.\d{6,}/, (long) => String(Number(Number(long).toFixed(3)))));
  const kept = lines.filter((line) => FAMILIES.test(line) && line.includes("rgb("));
  return `:root[data-obc-theme="${theme}"]{\n${kept.join("\n")}\n}`;
}

async function palettes() {
  const css = await readFile(new URL(`${OPENBRIDGE}/dist/openbridge.css`, MODULES), "utf8");
  const text = [banner(await describe(OPENBRIDGE)), ...THEMES.map((theme) => palette(css, theme))].join("\n");
  await keep("openbridge.css", text.replaceAll(": ", ":").replaceAll(", ", ",") + "\n", OPENBRIDGE);
}

/** What is drawn inside an icon's 24 x 24 box; two-coloured icons keep their colours as variables. */
async function drawing(icon) {
  const source = await readFile(new URL(`${OPENBRIDGE}/dist/icons/icon-${icon}.js`, MODULES), "utf8");
  const coloured = /^(alarm|warning|caution)-/.test(icon);
  const [, body] = source.match(new RegExp(`this\\.${coloured ? "iconCss" : "icon"} = svg\`<svg[^>]*>([\\s\\S]*?)</svg>`));
  const drawn = body.trim().replace(/style="(fill|stroke): ([^"]*)"/g, '$1="$2"').replace(/\n/g, "");
  return coloured ? `<g fill="none">${drawn}</g>` : drawn;
}

async function icons() {
  const entries = await Promise.all(ICONS.map(async (icon) => [icon, await drawing(icon)]));
  const table = JSON.stringify(Object.fromEntries(entries), null, 0).replaceAll('","', '",\n"');
  const text = `${banner(await describe(OPENBRIDGE))}\n/** @type {Record<string, string>} */\nexport const ICONS = ${table};\n`;
  await keep("icons.js", text, OPENBRIDGE);
}

async function font(file, name, source, characters) {
  const whole = await readFile(new URL(`${name}/files/${source}`, MODULES));
  await keep(file, await subsetFont(whole, characters, {targetFormat: "woff2"}), name);
}

async function fonts() {
  const [digits, text] = ["@fontsource/b612", "@fontsource/noto-sans"];
  await font("b612-700.woff2", digits, "b612-latin-700-normal.woff2", DIGITS);
  for (const weight of [400, 700]) {
    const latin = await readFile(new URL(`${text}/files/noto-sans-latin-${weight}-normal.woff2`, MODULES));
    await keep(`noto-sans-${weight}.woff2`, latin, text);
    await font(`noto-sans-ext-${weight}.woff2`, text, `noto-sans-latin-ext-${weight}-normal.woff2`, LATIN_EXTENDED_A);
  }
}

/** The licences' own words, as they demand; OpenBridge's package has none but its name. */
async function licences() {
  const names = [...new Set(manifest.map((entry) => entry.package))];
  const texts = await Promise.all(names.map(async (name) => {
    const {version, licence} = await describe(name);
    const text = await readFile(new URL(`${name}/LICENSE`, MODULES), "utf8").catch(() => `${licence}, see LICENSE of timonel\n`);
    return `${name} ${version} (${licence})\n\n${text.trim()}\n`;
  }));
  await writeFile(new URL("LICENSES.txt", TARGET), texts.join(`\n${"-".repeat(80)}\n\n`));
}

await rm(TARGET, {recursive: true, force: true});
await mkdir(TARGET, {recursive: true});
await palettes();
await icons();
await fonts();
await bundle("uplot.js", 'export {default} from "uplot";', "uplot");
await bundle("uplot.css", '@import "uplot/dist/uPlot.min.css";', "uplot");
await bundle("leaflet.js", 'export * from "leaflet/dist/leaflet-src.esm.js";', "leaflet");
await bundle("leaflet.css", '@import "leaflet/dist/leaflet.css";', "leaflet");
for (const [name, types] of Object.entries({uplot: 'export {default} from "uplot";', leaflet: 'export * from "leaflet";'})) {
  await writeFile(new URL(`${name}.d.ts`, TARGET), types + "\n"); // for tsc alone
}
await licences();
await writeFile(new URL("vendor.json", TARGET), JSON.stringify(manifest, null, 2) + "\n");
console.log(manifest.map(({file, bytes}) => `${String(bytes).padStart(8)}  ${file}`).join("\n"));
