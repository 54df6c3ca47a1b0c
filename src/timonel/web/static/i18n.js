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

/** The words for what the gateway says in English, if there are any. @param {string} prefix @param {string} text */
export function translated(prefix, text) {
  return words[`${prefix}.${text}`] ?? text;
}
