// @ts-check
/** What who drives must see while the wheels are on another page: both sides, the battery, the hottest, the strongest. */

import {html, set, setText} from "../dom.js";
import {t} from "../i18n.js";
import {digits, temperature} from "../units.js";

/** @typedef {import("../store.js").State} State */
/** @typedef {import("../messages.d.ts").WheelState} WheelState */

/** @param {(number | null | undefined)[]} values */
const most = (values) => values.reduce((/** @type {number | null} */ high, one) => (one == null ? high : Math.max(high ?? one, one)), null);

/** @param {WheelState[]} wheels @param {"left" | "right"} side */
function mean(wheels, side) {
  const speeds = wheels.filter((one) => one.side === side && one.quality === "fresh" && one.rpm !== null).map((one) => one.rpm ?? 0);
  return speeds.length === 0 ? null : speeds.reduce((sum, one) => sum + one, 0) / speeds.length;
}

/** @param {string} key @param {string} unit */
function tile(key, unit) {
  const value = html("output", {class: "value"});
  const node = html("div", {class: "figure"}, html("span", {class: "label", title: t(`summary.${key}_long`)}, t(`summary.${key}`)), value, html("span", {class: "unit"}, unit));
  /** @param {string} text @param {boolean} known */
  function write(text, known) {
    setText(value, text);
    set(node, "data-absent", !known);
  }
  return {node, write};
}

export function summary() {
  const left = tile("left", "rpm");
  const right = tile("right", "rpm");
  const battery = tile("battery", "V");
  const current = tile("current", "A");
  const heat = tile("heat", "°C");
  const node = html("section", {class: "panel summary", "aria-label": t("summary.title")}, left.node, right.node, battery.node, current.node, heat.node);

  /** @param {State} state */
  function draw(state) {
    const wheels = state.live ? (state.topics.wheels ?? []) : [];
    for (const [one, side] of /** @type {const} */ ([[left, "left"], [right, "right"]])) {
      const speed = mean(wheels, side);
      one.write(digits(speed, 4, 0), speed !== null);
    }
    const cells = state.live && state.topics.battery?.quality === "fresh" ? state.topics.battery : undefined;
    battery.write(digits(cells?.voltage ?? null, 2, 1), cells?.voltage != null);
    const strongest = most(wheels.map((one) => (one.current === null ? null : Math.abs(one.current))));
    current.write(digits(strongest, 2, 0), strongest !== null);
    const hottest = most(wheels.map((one) => one.temperature));
    heat.write(digits(hottest === null ? null : Number(temperature(hottest).text), 2, 0), hottest !== null);
  }

  return {node, draw};
}
