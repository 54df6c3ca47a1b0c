// @ts-check
/** Making and changing the page. Whatever changes many times a second is written only where it differs. */

import {ICONS} from "./vendor/icons.js";

const SVG = "http://www.w3.org/2000/svg";

/** @typedef {Node | string} Child */
/** @typedef {Record<string, string | number | boolean | null | undefined | ((event: any) => void)>} Attributes */

/**
 * Sets attributes; a function is a listener, `true` an empty attribute, null, undefined and false none.
 *
 * @template {Element} E
 * @param {E} node
 * @param {Attributes} attributes
 * @returns {E}
 */
function furnish(node, attributes) {
  for (const [name, value] of Object.entries(attributes)) {
    if (typeof value === "function") node.addEventListener(name, value);
    else if (value !== null && value !== undefined && value !== false) node.setAttribute(name, value === true ? "" : String(value));
  }
  return node;
}

/**
 * An element of HTML.
 *
 * @template {keyof HTMLElementTagNameMap} T
 * @param {T} tag
 * @param {Attributes} [attributes]
 * @param {...Child} children
 * @returns {HTMLElementTagNameMap[T]}
 */
export function html(tag, attributes = {}, ...children) {
  const node = furnish(document.createElement(tag), attributes);
  node.append(...children);
  return node;
}

/**
 * An element of SVG.
 *
 * @template {keyof SVGElementTagNameMap} T
 * @param {T} tag
 * @param {Attributes} [attributes]
 * @param {...Child} children
 * @returns {SVGElementTagNameMap[T]}
 */
export function svg(tag, attributes = {}, ...children) {
  const node = /** @type {SVGElementTagNameMap[T]} */ (document.createElementNS(SVG, tag));
  furnish(node, attributes);
  node.append(...children);
  return node;
}

/**
 * An icon of OpenBridge, by its name there. It says nothing to a screen reader: the text beside it does.
 *
 * @param {string} name
 * @returns {SVGSVGElement}
 */
export function icon(name) {
  const node = svg("svg", {class: "icon", viewBox: "0 0 24 24", fill: "currentColor", "aria-hidden": "true"});
  setIcon(node, name);
  return node;
}

/** @param {SVGSVGElement} node @param {string} name */
export function setIcon(node, name) {
  if (node.dataset.icon === name) return;
  node.dataset.icon = name;
  node.innerHTML = ICONS[name] ?? "";
}

/** @param {Node} node @param {string} text */
export function setText(node, text) {
  if (node.textContent !== text) node.textContent = text;
}

/** @param {Element} node @param {string} name @param {string | number | boolean | null} value */
export function set(node, name, value) {
  if (value === null || value === false) {
    if (node.hasAttribute(name)) node.removeAttribute(name);
    return;
  }
  const text = value === true ? "" : String(value);
  if (node.getAttribute(name) !== text) node.setAttribute(name, text);
}

/** @param {Element} node @param {boolean} shown */
export function show(node, shown) {
  set(node, "hidden", !shown);
}
