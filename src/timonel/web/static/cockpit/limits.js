// @ts-check
/** The limits of frames 119, 115 and 120 as steppers: speed, power and current, in shares of the most. */

import {html, set, setText} from "../dom.js";
import {t} from "../i18n.js";
import {inCommand} from "../store.js";
import {digits} from "../units.js";

/** @typedef {import("../store.js").State} State */
/** @typedef {import("../app.js").Console} Console */
/** @typedef {import("../messages.d.ts").WhichLimit} WhichLimit */

/** @type {Record<WhichLimit, {most: number, step: number, frame: number}>} */
const LIMITS = {
  speed: {most: 20, step: 1, frame: 119},
  power: {most: 20, step: 1, frame: 115},
  current: {most: 200, step: 10, frame: 120},
};
const ANSWERED = 600; // ms in which the gateway says what it made of a press

/** The next step of a limit; nobody said one: it is the most. @param {WhichLimit} which @param {number | null} now @param {1 | -1} way */
export function next(which, now, way) {
  const {most, step} = LIMITS[which];
  const on = Math.round((now ?? most) / step) + way;
  return Math.max(which === "current" ? step : 1, Math.min(most, on * step));
}

/** @param {Console} console @param {WhichLimit} which */
function stepper({store, socket}, which) {
  const {most, frame} = LIMITS[which];
  const value = html("output", {class: "value"});
  const fill = html("span", {class: "level"});
  const less = html("button", {class: "key", type: "button", "aria-label": t(`limit.${which}_less`), click: () => press(-1)}, "−");
  const more = html("button", {class: "key", type: "button", "aria-label": t(`limit.${which}_more`), click: () => press(1)}, "+");
  const node = html("div", {class: "stepper", "data-which": which, role: "group", "aria-label": t(`limit.${which}`)},
    html("span", {class: "label"}, t(`limit.${which}`), html("small", {}, ` ${frame}`)), less,
    html("div", {class: "reading"}, html("div", {class: "line"}, value, html("span", {class: "unit"}, "%")), html("div", {class: "gauge", "aria-hidden": "true"}, fill)), more);
  /** @type {{value: number, until: number} | null} what was pressed and is not yet told back */
  let asked = null;

  /** @param {1 | -1} way */
  function press(way) {
    const told = store.state.topics.limits?.[which] ?? null;
    const from = asked !== null && performance.now() < asked.until ? asked.value : told;
    const wanted = next(which, from, way);
    asked = {value: wanted, until: performance.now() + ANSWERED};
    socket.ask({type: "limit", which, value: wanted}, `limit_${which}`);
  }

  /** @param {State} state */
  function draw(state) {
    const told = state.topics.limits?.[which] ?? null;
    const known = state.live && state.topics.limits !== undefined;
    const share = (told ?? most) / most;
    setText(value, digits(known ? share * 100 : null, 3, 0));
    set(node, "data-untold", told === null);
    fill.style.setProperty("--share", known ? share.toFixed(3) : "0");
    const may = inCommand(state);
    less.disabled = !may || (told !== null && next(which, told, -1) === told);
    more.disabled = !may || (told ?? most) >= most;
  }

  return {node, draw};
}

/** @param {Console} console @param {WhichLimit[]} which @param {string} title */
export function limits(console, which, title) {
  const all = which.map((one) => stepper(console, one));
  const node = html("section", {class: "panel limits", "aria-label": title}, ...all.map((one) => one.node));
  /** @param {State} state */
  function draw(state) {
    for (const one of all) one.draw(state);
  }
  return {node, draw};
}
