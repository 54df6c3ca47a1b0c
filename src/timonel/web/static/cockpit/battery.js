// @ts-check
/** The battery: four cells as columns with their voltages, and the temperatures of the six modules. */

import {html, set, setText, svg} from "../dom.js";
import {t, translated} from "../i18n.js";
import {digits, temperature} from "../units.js";

/** @typedef {import("../store.js").State} State */

const EMPTY = 3.0; // V of a lithium cell
const FULL = 4.2;
const LOW = 3.3;
const HOT = 328; // K: 55 °C; the modules themselves end at 60

/** @param {number} number */
function cell(number) {
  const level = svg("rect", {class: "level", x: 3, width: 34});
  const drawing = svg("svg", {viewBox: "0 0 40 84", preserveAspectRatio: "none", "aria-hidden": "true"},
    svg("path", {class: "case", d: "M13 1H27V5H38V83H2V5H13Z"}), level, svg("path", {class: "case outline", d: "M13 1H27V5H38V83H2V5H13Z"}));
  const value = html("output", {class: "value"});
  const node = html("div", {class: "cell", role: "group", "aria-label": t("battery.cell", {number})}, drawing,
    html("div", {class: "line"}, value, html("span", {class: "unit"}, "V")));
  /** @param {number | null} voltage */
  function draw(voltage) {
    setText(value, digits(voltage, 1, 2));
    const share = voltage === null ? 0 : Math.max(0, Math.min(1, (voltage - EMPTY) / (FULL - EMPTY)));
    set(level, "y", (82 - 75 * share).toFixed(1));
    set(level, "height", (75 * share).toFixed(1));
    set(node, "data-absent", voltage === null);
    set(node, "data-low", voltage !== null && voltage < LOW);
  }
  return {node, draw};
}

export function battery() {
  const cells = [1, 2, 3, 4].map(cell);
  const modules = [1, 2, 3, 4, 5, 6].map((number) => {
    const value = html("output", {class: "value"});
    return {value, node: html("div", {class: "module", role: "group", "aria-label": t("battery.module", {number})}, html("span", {class: "label"}, String(number)), value)};
  });
  const whole = html("output", {class: "value"});
  const word = html("strong", {class: "word"});
  const node = html("section", {class: "panel battery", "aria-label": t("battery.title")},
    html("header", {}, html("span", {class: "label"}, t("battery.title")), word, html("div", {class: "line whole"}, whole, html("span", {class: "unit"}, "V"))),
    html("div", {class: "cells"}, ...cells.map((one) => one.node)),
    html("div", {class: "modules"}, ...modules.map((one) => one.node), html("span", {class: "unit"}, "°C")));

  /** @param {State} state */
  function draw(state) {
    const told = state.live ? state.topics.battery : undefined;
    const fresh = told?.quality === "fresh" ? told : undefined;
    setText(whole, digits(fresh?.voltage ?? null, 2, 1));
    cells.forEach((one, place) => one.draw(fresh?.cells[place] ?? null));
    modules.forEach(({value, node: one}, place) => {
      const kelvin = told?.modules[place] ?? null;
      setText(value, temperature(kelvin).text);
      set(one, "data-hot", kelvin !== null && kelvin > HOT);
      set(one, "data-absent", kelvin === null);
    });
    set(node, "data-state", told?.state == null ? "unknown" : told.state.replace(" ", "-"));
    setText(word, told?.state == null ? "" : translated("battery", told.state));
  }

  return {node, draw};
}
