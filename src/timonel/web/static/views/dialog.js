// @ts-check
/** A box over the page that leaves uncovered, and in working order, what steers: Escape or a touch beside it closes it. */

import {html, icon} from "../dom.js";
import {t} from "../i18n.js";

/**
 * @param {string} kind
 * @param {string} title
 * @param {...(Node | string)} content
 */
export function dialog(kind, title, ...content) {
  const heading = html("h2", {id: `${kind}-title`}, title);
  const close = html("button", {class: "key close", type: "button", "aria-label": t("dialog.close"), click: () => node.close()}, icon("close-google"));
  const node = html("dialog", {class: `dialog ${kind}`, "aria-labelledby": `${kind}-title`}, html("header", {}, heading, close), ...content);
  node.addEventListener("keydown", (event) => event.key === "Escape" && node.close());
  return node;
}

/** Opens one and closes the others; not modal, so that STANDBY and STOP stay within reach. @param {HTMLDialogElement} node */
export function open(node) {
  const opener = document.activeElement;
  for (const other of document.querySelectorAll("dialog")) other.close();
  node.show();
  const watch = new AbortController();
  node.addEventListener("close", () => {
    watch.abort();
    if (opener instanceof HTMLElement) opener.focus();
  }, {once: true});
  document.addEventListener("pointerdown", (event) => {
    if (!node.contains(/** @type {Node} */ (event.target))) node.close();
  }, {signal: watch.signal, capture: true});
}

/** Whether the keyboard belongs to a dialog now. */
export const inDialog = () => document.activeElement?.closest("dialog") != null;
