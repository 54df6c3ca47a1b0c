// @ts-check
/** The six wheels as they stand, front at the top: what each is told, and what it does. */

import {html, set, setText, svg} from "../dom.js";
import {t, translated} from "../i18n.js";
import {digits, temperature} from "../units.js";

/** @typedef {import("../store.js").State} State */
/** @typedef {import("../messages.d.ts").WheelState} WheelState */

const HALF = 46; // of a wheel's drawing, from the middle to full speed
const RPM = 100; // of a drawing's end, until a wheel was faster
const MORE = 20; // rpm that it then grows by
const HOT = 353; // K: 80 °C

/** @param {number} value @param {number} most */
const length = (value, most) => Math.max(-1, Math.min(1, value / most)) * HALF;

/** A bar from the middle. @param {number} width @param {number} height upwards */
const bar = (width, height) => `M${-width / 2} 0H${width / 2}V${(-height).toFixed(1)}H${-width / 2}Z`;

/** @param {"left" | "right"} side @param {"front" | "middle" | "rear"} place */
function wheel(side, place) {
  const speed = svg("path", {class: "speed"});
  const wanted = svg("path", {class: "wanted", d: "M-20 0H20M-20 0l-6 -5v10zM20 0l6 -5v10z"});
  const drawing = svg("svg", {class: "tyre", viewBox: "-27 -54 54 108", "aria-hidden": "true"},
    svg("rect", {class: "rubber", x: -17, y: -50, width: 34, height: 100, rx: 8}),
    svg("path", {class: "tread", d: "M-17 -36H17M-17 -24H17M-17 -12H17M-17 12H17M-17 24H17M-17 36H17"}),
    speed, svg("path", {class: "middle", d: "M-17 0H17"}), wanted);
  const rpm = html("output", {class: "value rpm"});
  const setpoint = html("output", {class: "value"});
  const current = html("output", {class: "value"});
  const heat = html("output", {class: "value"});
  /** @param {string} kind @param {HTMLElement} value @param {string} unit */
  const line = (kind, value, unit) => html("div", {class: `line ${kind}`}, value, html("span", {class: "unit"}, unit));
  const node = html("div", {class: "wheel", "data-side": side, "data-place": place, role: "group", "aria-label": t(`wheel.${side}_${place}`)},
    html("div", {class: "numbers"}, line("speed", rpm, "rpm"), line("set", setpoint, "%"), line("current", current, "A"), line("heat", heat, "°C")), drawing);

  /** @param {State} state @param {WheelState | undefined} told @param {number} most rpm */
  function draw(state, told, most) {
    const fresh = state.live && told?.quality === "fresh" ? told : null;
    const known = state.live && told !== undefined ? told : null;
    set(node, "data-absent", fresh === null);
    setText(rpm, digits(fresh?.rpm ?? null, 4, 0));
    setText(setpoint, digits(known === null ? null : known.setpoint * 100, 4, 0));
    setText(current, digits(known?.current ?? null, 4, 1));
    setText(heat, temperature(known?.temperature ?? null).text);
    set(node, "data-hot", (known?.temperature ?? 0) > HOT);
    set(speed, "d", fresh?.rpm == null ? "" : bar(26, length(fresh.rpm, most)));
    set(speed, "data-way", (fresh?.rpm ?? 0) < 0 ? "astern" : "ahead");
    set(wanted, "transform", `translate(0 ${(-length(known?.setpoint ?? 0, 1)).toFixed(1)})`);
    set(wanted, "data-still", known === null || known.setpoint === 0);
  }

  return {node, draw};
}

/** A side's motor driver, in a word and a mark. @param {"left" | "right"} side */
function driver(side) {
  const word = html("strong");
  const node = html("div", {class: "driver", "data-side": side, role: "group", "aria-label": t(`wheel.driver_${side}`)}, html("span", {class: "mark", "aria-hidden": "true"}), word);
  /** @param {State} state @param {WheelState | undefined} told */
  function draw(state, told) {
    const word_ = state.live ? (told?.state ?? null) : null;
    set(node, "data-state", word_ === null ? "unknown" : word_.replace(" ", "-"));
    setText(word, word_ === null ? "-----" : translated("driver", word_));
  }
  return {node, draw};
}

export function wheels() {
  const sides = /** @type {const} */ (["left", "right"]);
  const places = /** @type {const} */ (["front", "middle", "rear"]);
  const all = sides.flatMap((side) => places.map((place) => wheel(side, place)));
  const drivers = sides.map(driver);
  const body = svg("svg", {class: "body", viewBox: "-50 -180 100 360", preserveAspectRatio: "none", "aria-hidden": "true"},
    svg("path", {class: "axles", d: "M-50 -120H50M-50 0H50M-50 120H50"}),
    svg("path", {class: "hull", d: "M-30 -150Q0 -168 30 -150V150Q0 160 -30 150Z"}));
  const front = svg("svg", {class: "front", viewBox: "-20 -20 40 40", "aria-hidden": "true"}, svg("path", {d: "M0 -16L14 12Q0 4 -14 12Z"}));
  const node = html("section", {class: "panel wheels", "aria-label": t("wheel.title")},
    html("div", {class: "chassis"}, ...all.map((one) => one.node), body, front, ...drivers.map((one) => one.node)));
  let most = RPM;

  /** @param {State} state */
  function draw(state) {
    const told = state.topics.wheels ?? [];
    for (const one of told) most = Math.max(most, MORE * Math.ceil(Math.abs(one.rpm ?? 0) / MORE));
    all.forEach((one, place) => one.draw(state, told[place], most));
    drivers.forEach((one, place) => one.draw(state, told[place * 3]));
  }

  return {node, draw};
}
