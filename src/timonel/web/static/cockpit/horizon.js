// @ts-check
/** The horizon as the IMU feels it, with roll and pitch in degrees. */

import {html, set, setText, svg} from "../dom.js";
import {t} from "../i18n.js";
import {course, degrees, digits} from "../units.js";
import {attitude} from "./attitude.js";

/** @typedef {import("../store.js").State} State */

const PER_DEGREE = 2.2; // of the drawing
const RADIUS = 96;

function ladder() {
  const group = svg("g", {class: "ladder"});
  for (let angle = -60; angle <= 60; angle += 10) {
    if (angle === 0) continue;
    const y = -angle * PER_DEGREE;
    const half = angle % 20 === 0 ? 26 : 14;
    group.append(svg("path", {d: `M${-half} ${y}H${half}`}));
    if (angle % 20 === 0) group.append(svg("text", {x: 38, y: y + 4}, String(Math.abs(angle))));
  }
  return group;
}

/** Marks of roll at the rim. */
function rim() {
  let marks = "";
  for (const angle of [-60, -45, -30, -20, -10, 0, 10, 20, 30, 45, 60]) {
    const turn = (angle * Math.PI) / 180;
    const [x, y] = [Math.sin(turn), -Math.cos(turn)];
    const inner = angle % 30 === 0 ? 84 : 89;
    marks += `M${(x * inner).toFixed(1)} ${(y * inner).toFixed(1)}L${(x * RADIUS).toFixed(1)} ${(y * RADIUS).toFixed(1)}`;
  }
  return svg("path", {class: "rim", d: marks});
}

export function horizon() {
  const pitched = svg("g", {}, svg("rect", {class: "sky", x: -300, y: -400, width: 600, height: 400}), svg("rect", {class: "ground", x: -300, y: 0, width: 600, height: 400}),
    svg("path", {class: "line", d: "M-300 0H300"}), ladder());
  const rolled = svg("g", {}, pitched);
  const pointer = svg("path", {class: "pointer", d: "M0 -82l7 13h-14z"});
  const clip = svg("clipPath", {id: "horizon-clip"}, svg("circle", {r: RADIUS}));
  const drawing = svg("svg", {viewBox: "-100 -100 200 200", "aria-hidden": "true"}, svg("defs", {}, clip),
    svg("circle", {class: "blank", r: RADIUS}), svg("g", {class: "moving", "clip-path": "url(#horizon-clip)"}, rolled),
    rim(), pointer, svg("path", {class: "wings", d: "M-58 0H-24L-12 12M58 0H24L12 12M-2.5 0a2.5 2.5 0 1 0 5 0a2.5 2.5 0 1 0 -5 0"}), svg("circle", {class: "frame", r: RADIUS}));
  /** @param {string} key @param {string} unit */
  function number(key, unit) {
    const value = html("output", {class: "value"});
    return {value, node: html("div", {class: "line"}, html("span", {class: "label"}, t(key)), value, html("span", {class: "unit"}, unit))};
  }
  const roll = number("imu.roll", "°");
  const pitch = number("imu.pitch", "°");
  const heading = number("imu.heading", "°M");
  const node = html("section", {class: "panel horizon", "aria-label": t("imu.title")}, drawing, html("div", {class: "numbers"}, pitch.node, roll.node, heading.node));
  /** @type {import("./attitude.js").Attitude | null} */
  let lies = null;

  /** @param {State} state */
  function draw(state) {
    const imu = state.live ? state.topics.imu : undefined;
    if (imu === undefined || imu.at !== lies?.at || imu.quality !== "fresh") lies = attitude(lies, imu);
    set(node, "data-absent", lies === null);
    set(rolled, "transform", `rotate(${(-degrees(lies?.roll ?? 0)).toFixed(1)})`);
    set(pitched, "transform", `translate(0 ${(degrees(lies?.pitch ?? 0) * PER_DEGREE).toFixed(1)})`);
    set(pointer, "transform", `rotate(${(-degrees(lies?.roll ?? 0)).toFixed(1)})`);
    setText(roll.value, digits(lies === null ? null : degrees(lies.roll), 3, 0));
    setText(pitch.value, digits(lies === null ? null : degrees(lies.pitch), 3, 0));
    const compass = state.live ? state.topics.magnetometer : undefined;
    setText(heading.value, course(compass?.quality === "fresh" ? compass.heading : null, 0));
  }

  return {node, draw};
}
