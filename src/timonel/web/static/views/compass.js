// @ts-check
/** The rose: heading up, with the set point's bug, the course over ground, the rate of turn and where the wind is from. */

import {html, set, setText, show, svg} from "../dom.js";
import {t} from "../i18n.js";
import {valid} from "../store.js";
import {course, degrees, digits, rateOfTurn, referenceLetter, signed} from "../units.js";

/** @typedef {import("../store.js").State} State */

const RING = 236; // radius of the card
const INNER = 180;
const TURN_RING = 254;
const TURN_SPAN = 50; // degrees of arc to each side
const TURN_SCALE = 90; // degrees a minute at the end of the arc
const POINTS = {0: "N", 90: "E", 180: "S", 270: "W"};

/** @param {number} angle degrees clockwise from the top @param {number} radius */
function place(angle, radius) {
  const radians = (angle * Math.PI) / 180;
  return `${(radius * Math.sin(radians)).toFixed(2)} ${(-radius * Math.cos(radians)).toFixed(2)}`;
}

/** The arc of a circle from the top to an angle, degrees. @param {number} radius @param {number} from @param {number} to */
function arc(radius, from, to) {
  const [start, end] = from < to ? [from, to] : [to, from];
  return `M${place(start, radius)}A${radius} ${radius} 0 ${end - start > 180 ? 1 : 0} 1 ${place(end, radius)}`;
}

function card() {
  const group = svg("g", {class: "card"});
  const ticks = {minor: "", major: ""};
  for (let angle = 0; angle < 360; angle += 5) {
    const major = angle % 10 === 0;
    ticks[major ? "major" : "minor"] += `M${place(angle, RING)}L${place(angle, RING - (major ? 16 : 9))}`;
  }
  group.append(svg("path", {class: "tick minor", d: ticks.minor}), svg("path", {class: "tick", d: ticks.major}));
  for (let angle = 0; angle < 360; angle += 30) {
    const point = /** @type {Record<number, string>} */ (POINTS)[angle];
    const text = point ?? String(angle).padStart(3, "0");
    const label = svg("text", {class: point ? "point" : "number", y: -RING + (point ? 43 : 39), transform: `rotate(${angle})`}, text);
    group.append(label);
  }
  return group;
}

function turnScale() {
  let marks = "";
  for (const share of [-1, -2 / 3, -1 / 3, 0, 1 / 3, 2 / 3, 1]) {
    marks += `M${place(share * TURN_SPAN, TURN_RING - 6)}L${place(share * TURN_SPAN, TURN_RING + 6)}`;
  }
  return svg("g", {class: "turn"}, svg("path", {class: "turn-track", d: arc(TURN_RING, -TURN_SPAN, TURN_SPAN)}), svg("path", {class: "turn-marks", d: marks}));
}

/** @param {string} kind @param {string} letter */
function windMark(kind, letter) {
  return svg("g", {class: `wind ${kind}`},
    svg("path", {d: "M0 -112L-15 -146Q0 -139 15 -146Z"}), svg("text", {y: -159}, letter));
}

export function compass() {
  const disc = card();
  const turn = svg("path", {class: "turn-bar"});
  const error = svg("path", {class: "error"});
  const bug = svg("path", {class: "bug", d: `M-17 ${-RING - 19}H17V${-RING - 7}L0 ${-RING + 16}L-17 ${-RING - 7}Z`});
  const cog = svg("path", {class: "cog", d: "M0 -176L19 -132Q0 -144 -19 -132Z"});
  const heading = svg("path", {class: "heading", d: "M0 -180L24 -126Q0 -140 -24 -126Z"});
  const apparent = windMark("apparent", "A");
  const true_ = windMark("true", "T");
  const boat = svg("path", {class: "boat", d: "M0 -92C30 -54 38 4 25 84Q0 92 -25 84C-38 4 -30 -54 0 -92Z"});
  const rose = svg("svg", {class: "rose", viewBox: "-268 -268 536 536", "aria-hidden": "true"},
    turnScale(), turn,
    svg("circle", {class: "ring", r: RING}), svg("circle", {class: "well", r: INNER}),
    disc, error, boat, apparent, true_, cog, heading, bug,
    svg("path", {class: "lubber", d: `M-9 ${-RING - 2}H9L0 ${-RING + 15}Z`}));
  const rate = html("output", {class: "value"});
  const over = html("output", {class: "value"});
  const overUnit = html("span", {class: "unit"});
  const spoken = html("p", {class: "spoken"});
  const node = html("section", {class: "panel compass", "aria-label": t("compass.title")}, rose, spoken,
    html("div", {class: "corner left"}, html("span", {class: "label"}, t("value.rot")), html("span", {}, rate, html("span", {class: "unit"}, "°/min"))),
    html("div", {class: "corner right"}, html("span", {class: "label"}, t("value.cog")), html("span", {}, over, overUnit)));
  new ResizeObserver(() => {
    const flat = node.clientHeight < 0.62 * node.clientWidth; // then the upper part of a larger rose says more
    set(rose, "preserveAspectRatio", flat ? "xMidYMin slice" : "xMidYMid meet");
    set(node, "data-flat", flat);
  }).observe(node);

  /** @param {SVGElement} mark @param {number | null} angle degrees */
  function turnTo(mark, angle) {
    show(mark, angle !== null);
    if (angle === null) return;
    set(mark, "transform", `rotate(${angle.toFixed(1)})`);
    const letter = mark.querySelector("text"); // stays upright
    if (letter !== null) set(letter, "transform", `rotate(${(-angle).toFixed(1)} 0 -159)`);
  }

  /** @param {number | null} rateRadians */
  function drawTurn(rateRadians) {
    const perMinute = rateRadians === null ? 0 : degrees(rateRadians) * 60;
    const share = Math.max(-1, Math.min(1, perMinute / TURN_SCALE));
    set(turn, "d", Math.abs(share) < 0.01 ? "" : arc(TURN_RING, 0, share * TURN_SPAN));
    set(turn, "data-side", share < 0 ? "port" : "starboard");
  }

  /** @param {number | null} angle degrees from the bow */
  function drawError(angle) {
    set(error, "d", angle === null || Math.abs(angle) < 0.3 ? "" : arc(INNER + 4, 0, angle));
  }

  /** @param {State} state */
  function draw(state) {
    const {topics} = state;
    const ahead = valid(state, topics.heading);
    const track = valid(state, topics.cog);
    const wanted = state.live ? (topics.pilot?.setpoint ?? null) : null;
    const relative = (/** @type {number | null} */ angle) => (angle === null || ahead === null ? null : signed(degrees(angle - ahead)));
    set(node, "data-absent", ahead === null);
    set(disc, "transform", `rotate(${(-degrees(ahead ?? 0)).toFixed(1)})`);
    show(heading, ahead !== null);
    turnTo(bug, relative(wanted));
    drawError(relative(wanted));
    turnTo(cog, relative(track));
    for (const [mark, wind] of /** @type {const} */ ([[apparent, topics.wind_apparent], [true_, topics.wind_true]])) {
      const from = state.live && wind?.quality === "fresh" ? wind.angle : null;
      turnTo(mark, from === null ? null : signed(degrees(from)));
    }
    const turning = valid(state, topics.rate_of_turn);
    drawTurn(turning);
    setText(rate, rateOfTurn(turning).text);
    setText(over, course(track, 0));
    setText(overUnit, `°${referenceLetter(topics.cog?.reference ?? "true")}`);
    setText(spoken, t("compass.spoken", {heading: course(ahead, 0), turn: digits(turning === null ? null : degrees(turning) * 60, 1, 0)}));
  }

  return {node, draw};
}
