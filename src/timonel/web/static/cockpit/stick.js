// @ts-check
/** The stick on the screen: wherever the thumb is laid down is its middle, and lifting it lets go. */

import {html, set, setText, svg} from "../dom.js";
import {t} from "../i18n.js";
import {inCommand} from "../store.js";
import {FREE} from "./deadman.js";
import {shaped} from "./shaping.js";

/** @typedef {import("../store.js").State} State */
/** @typedef {import("./driving.js").Driving} Driving */

const REACH = 62; // of the knob, in the drawing's units
const SHORTEST = 56; // px of a thumb's way to full speed, however small the drawing is
const STILL = 0.04; // of the reach: a thumb that was only laid down

/** @param {Driving} driving */
export function stick(driving) {
  const knob = svg("circle", {class: "knob", r: 30});
  const obeyed = svg("circle", {class: "obeyed", r: 8});
  const drawing = svg("svg", {viewBox: "-100 -100 200 200", "aria-hidden": "true"},
    svg("circle", {class: "well", r: 96}), svg("circle", {class: "reach", r: REACH}),
    svg("path", {class: "cross", d: "M0 -92V92M-92 0H92"}),
    svg("path", {class: "points", d: "M0 -90l9 13h-18zM0 90l9 -13h-18zM-90 0l13 9v-18zM90 0l-13 9v-18z"}),
    obeyed, knob);
  const word = html("strong");
  const hint = html("span", {class: "hint"});
  const surface = html("div", {class: "surface", role: "img", "aria-label": t("stick.long")}, drawing);
  const node = html("section", {class: "panel stick", "aria-label": t("stick.title")}, surface, html("p", {class: "word", role: "status"}, word, hint));
  /** @type {number | null} */
  let finger = null;
  let from = {x: 0, y: 0};

  /** @param {PointerEvent} event */
  function lay(event) {
    if (finger !== null || event.button !== 0) return;
    finger = event.pointerId;
    from = {x: event.clientX, y: event.clientY};
    surface.setPointerCapture(finger);
    driving.touch({held: true, x: 0, y: 0});
    event.preventDefault();
  }

  /** @param {PointerEvent} event */
  function move(event) {
    if (event.pointerId !== finger) return;
    const reach = Math.max(SHORTEST, (REACH / 200) * Math.min(surface.clientWidth, surface.clientHeight));
    driving.touch({held: true, ...shaped((event.clientX - from.x) / reach, (from.y - event.clientY) / reach, STILL)});
  }

  /** @param {PointerEvent} event */
  function lift(event) {
    if (event.pointerId !== finger) return;
    finger = null;
    driving.touch(FREE);
  }

  for (const [name, listener] of /** @type {const} */ ([["pointerdown", lay], ["pointermove", move], ["pointerup", lift], ["pointercancel", lift], ["lostpointercapture", lift]])) {
    surface.addEventListener(name, listener);
  }
  surface.addEventListener("contextmenu", (event) => event.preventDefault()); // of a long touch

  /** @param {State} state */
  function draw(state) {
    const {deadman} = driving;
    const drive = state.topics.drive;
    const ready = inCommand(state) && drive?.permitted === true;
    const {x, y} = deadman.stick;
    set(node, "data-state", deadman.driver !== null ? "held" : ready ? "ready" : "locked");
    set(knob, "transform", `translate(${(x * REACH).toFixed(1)} ${(-y * REACH).toFixed(1)})`);
    const told = state.live && drive !== undefined ? drive.stick : {x: 0, y: 0};
    set(obeyed, "transform", `translate(${(told.x * REACH).toFixed(1)} ${(-told.y * REACH).toFixed(1)})`);
    setText(word, words(state, driving, ready));
    setText(hint, deadman.driver === null && ready ? t(driving.pad ? "stick.how_pad" : "stick.how") : "");
  }

  return {node, draw};
}

/** @param {State} state @param {Driving} driving @param {boolean} ready */
function words(state, {deadman}, ready) {
  if (deadman.driver !== null) return t(`stick.by_${deadman.driver}`);
  if (["hidden", "blur", "unplugged", "socket"].includes(deadman.reason)) return t(`stick.lost_${deadman.reason}`);
  return ready ? t("stick.ready") : t(state.live ? "stick.locked" : "link.lost");
}
