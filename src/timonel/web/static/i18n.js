// @ts-check
/** The words of the page: one JSON file a language, the keys the same in all (a test sees to it). */

export const LANGUAGES = {en: "English", es: "Español", pl: "Polski"};

/** @typedef {keyof typeof LANGUAGES} Language */

const STORED = "timonel.language";

/** @type {Record<string, string>} */
let words = {};

/** @returns {Language} the one that was chosen here, else the browser's first that there is */
export function language() {
  const wanted = [localStorage.getItem(STORED), ...navigator.languages.map((tag) => tag.slice(0, 2))];
  return /** @type {Language} */ (wanted.find((tag) => tag !== null && tag in LANGUAGES) ?? "en");
}

/** Loads the words. @param {Language} [chosen] remembered from now on */
export async function loadLanguage(chosen) {
  if (chosen) localStorage.setItem(STORED, chosen);
  const tag = chosen ?? language();
  words = await (await fetch(`languages/${tag}.json`)).json();
  document.documentElement.lang = tag;
}

/**
 * The words for a key; `{name}` in them is replaced.
 *
 * @param {string} key
 * @param {Record<string, string | number>} [values]
 */
export function t(key, values = {}) {
  return (words[key] ?? key).replace(/\{(\w+)\}/g, (whole, name) => String(values[name] ?? whole));
}

/** @typedef {{key: string, shape: RegExp, literal: number}} Shape */

/** What the keys with places look like in the gateway's words, by what they begin with. @type {Map<string, Shape[]>} */
const shapes = new Map();

/** The keys with places, the most particular first. @param {string} prefix @returns {Shape[]} */
function shaped(prefix) {
  const begin = `${prefix}.`;
  const found = shapes.get(prefix) ?? Object.keys(words).filter((key) => key.startsWith(begin) && key.includes("{")).map((key) => {
    const plain = key.slice(begin.length).replace(/[.*+?^$|()[\]\\]/g, "\\$&");
    const shape = plain.replace(/\{(\w+)\}/g, (_, name) => (name === "number" ? "(?<number>\\d+)" : `(?<${name}>.+?)`));
    return {key, shape: new RegExp(`^${shape}$`), literal: plain.replace(/\{\w+\}/g, "").length};
  }).sort((one, other) => other.literal - one.literal);
  shapes.set(prefix, found);
  return found;
}

/**
 * The words for what the gateway says in English, if there are any. A key may have places for what changes, which is
 * translated too: "station {number}" is what "station 2" is looked up by.
 *
 * @param {string} prefix
 * @param {string} text
 * @returns {string}
 */
export function translated(prefix, text) {
  const exact = words[`${prefix}.${text}`];
  if (exact !== undefined) return exact;
  for (const {key, shape} of shaped(prefix)) {
    const places = shape.exec(text)?.groups;
    if (places !== undefined) return t(key, Object.fromEntries(Object.entries(places).map(([name, value]) => [name, translated(prefix, value)])));
  }
  return text;
}
