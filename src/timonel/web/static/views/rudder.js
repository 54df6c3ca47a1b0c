// @ts-check
/** The rudder: a bar that grows red to port and green to starboard, and the angle in digits. */

import {html, set, setText, show} from "../dom.js";
import {t} from "../i18n.js";
import {valid} from "../store.js";
import {degrees, sided} from "../units.js";

/** @typedef {import("../store.js").State} State */

const END = 35; // degrees, hard over

/** How far from the left, in percent. @param {number} angle degrees */
const along = (angle) => ((Math.max(-END, Math.min(END, angle)) + END) / (2 * END)) * 100;

/** @param {number} angle degrees */
function mark(angle) {
  const node = html("span", {class: angle % 10 === 0 ? "tick major" : "tick"}, angle % 10 === 0 ? String(Math.abs(angle)) : "");
  node.style.left = `${along(angle)}%`;
  return node;
}

export function rudder() {
  const fill = html("div", {class: "fill"});
  const needle = html("div", {class: "needle"});
  const marks = Array.from({length: 15}, (_, index) => mark(index * 5 - END));
  const bar = html("div", {class: "rudder-bar", "aria-hidden": "true"}, html("div", {class: "trough"}, fill), ...marks, needle);
  const value = html("output", {class: "value"});
  const side = html("span", {class: "unit"});
  const node = html("section", {class: "panel rudder", "aria-label": t("value.rudder_long")},
    html("span", {class: "label"}, t("value.rudder")), bar, html("div", {class: "reading"}, value, side));

  /** @param {State} state */
  function draw(state) {
    const angle = valid(state, state.topics.rudder);
    const reading = sided(angle);
    setText(value, reading.text);
    setText(side, reading.side === "" ? "°" : `°${t(`side.${reading.side}`)}`);
    set(node, "data-absent", angle === null);
    show(needle, angle !== null);
    const to = along(degrees(angle ?? 0));
    needle.style.left = `${to.toFixed(1)}%`;
    fill.style.left = `${Math.min(50, to).toFixed(1)}%`;
    fill.style.width = `${Math.abs(to - 50).toFixed(1)}%`;
    set(fill, "data-side", to < 50 ? "port" : "starboard");
  }

  return {node, draw};
}
