// @ts-check
/** What belongs to this screen alone: palette, brightness, language, sound. */

import {html, icon, set, setIcon, setText} from "../dom.js";
import {LANGUAGES, language, loadLanguage, t} from "../i18n.js";
import {dialog, open} from "./dialog.js";

/** @typedef {import("../app.js").Console} Console */
/** @typedef {import("../i18n.js").Language} Language */

const PALETTES = {bright: "palette-day-bright", day: "palette-day", dusk: "palette-dusk", night: "palette-night"};
const DIM = {bright: 0, day: 0, dusk: 0, night: 0.52}; // how much darker a palette is until somebody says otherwise
const DIMMEST = 0.85;
const STORED = {palette: "timonel.palette", dim: "timonel.dim"};

/** @typedef {keyof typeof PALETTES} Palette */

export const palette = () => /** @type {Palette} */ (document.documentElement.dataset.obcTheme ?? "day");

/** @param {Palette} name */
function usePalette(name) {
  document.documentElement.dataset.obcTheme = name;
  localStorage.setItem(STORED.palette, name);
  useDim(dim());
  document.dispatchEvent(new Event("timonel-palette"));
}

/** @returns {number} of the palette in use, 0 to DIMMEST */
function dim() {
  const stored = localStorage.getItem(`${STORED.dim}.${palette()}`);
  return stored === null ? DIM[palette()] : Math.min(DIMMEST, Math.max(0, Number(stored)));
}

/** @param {number} share */
function useDim(share) {
  document.documentElement.style.setProperty("--dim", String(share));
}

/** @param {Console} console */
export function settings({sound, rebuild}) {
  const palettes = Object.entries(PALETTES).map(([name, picture]) => html("button",
    {class: "key choice", type: "button", "data-palette": name, click: () => usePalette(/** @type {Palette} */ (name))}, icon(picture), t(`palette.${name}`)));
  const darker = html("button", {class: "key", type: "button", "aria-label": t("settings.darker"), click: () => change(0.1)}, "−");
  const lighter = html("button", {class: "key", type: "button", "aria-label": t("settings.lighter"), click: () => change(-0.1)}, "+");
  const level = html("output", {class: "level"});
  const languages = Object.entries(LANGUAGES).map(([tag, name]) => html("button", {
    class: "key choice", type: "button", lang: tag, "aria-pressed": String(tag === language()),
    click: async () => {
      await loadLanguage(/** @type {Language} */ (tag));
      rebuild();
    },
  }, name));
  const soundIcon = icon("sound");
  const soundText = html("span");
  const soundKey = html("button", {class: "key choice", type: "button", click: () => sound.turn(!sound.on)}, soundIcon, soundText);
  /** @param {string} title @param {...HTMLElement} keys */
  const setting = (title, ...keys) => html("div", {class: "setting"}, html("h3", {}, title), html("div", {class: "choices"}, ...keys));
  const box = dialog("settings", t("settings.title"), html("div", {},
    setting(t("settings.palette"), ...palettes), setting(t("settings.language"), ...languages),
    setting(t("settings.brightness"), darker, level, lighter), setting(t("settings.sound"), soundKey)));
  const picture = icon("palette-day");
  const button = html("button", {class: "key bar-key", type: "button", "aria-haspopup": "dialog", "aria-label": t("settings.title"), click: () => open(box)}, picture);

  /** @param {number} by */
  function change(by) {
    const share = Math.min(DIMMEST, Math.max(0, dim() + by));
    localStorage.setItem(`${STORED.dim}.${palette()}`, share.toFixed(2));
    useDim(share);
  }

  function draw() {
    setIcon(picture, PALETTES[palette()]);
    for (const one of palettes) set(one, "aria-pressed", String(one.dataset.palette === palette()));
    setText(level, `${Math.round((1 - dim()) * 100)} %`);
    setIcon(soundIcon, sound.on ? "sound" : "sound-muted");
    setText(soundText, t(sound.on ? (sound.ready ? "sound.on" : "sound.waiting") : "sound.off"));
    set(soundKey, "aria-pressed", String(sound.on));
  }

  useDim(dim());
  return {button, box, draw};
}
