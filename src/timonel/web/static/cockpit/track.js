// @ts-check
/** Where the rover was, from above: north up, with a scale of metres and a grid. */

import {html, set, setText, svg} from "../dom.js";
import {t} from "../i18n.js";
import {degrees, digits, latitude, longitude} from "../units.js";
import {createWay, nice, view} from "./way.js";

/** @typedef {import("../store.js").State} State */

const SIDE = 200; // of the drawing

export function track() {
  const way = createWay();
  const grid = svg("path", {class: "grid"});
  const line = svg("path", {class: "way"});
  const start = svg("circle", {class: "start", r: 7});
  const own = svg("path", {class: "own", d: "M0 -19L13 16Q0 8 -13 16Z"});
  const drawing = svg("svg", {viewBox: `${-SIDE / 2} ${-SIDE / 2} ${SIDE} ${SIDE}`, preserveAspectRatio: "xMidYMid meet", "aria-hidden": "true"}, grid, line, start, own);
  const bar = html("div", {class: "scale-line"});
  const scale = html("span");
  const legend = html("div", {class: "scale"}, bar, scale);
  const place = html("output", {class: "value place"});
  const driven = html("output", {class: "value driven"});
  const clear = html("button", {class: "key clear", type: "button", click: () => {
    way.clear();
    drawn = "";
  }}, t("way.clear"));
  const map = html("div", {class: "map"}, drawing, html("span", {class: "north", "aria-hidden": "true"}, "N"), legend);
  const node = html("section", {class: "panel way", "aria-label": t("way.title")}, map,
    html("footer", {}, place, html("div", {class: "line"}, html("span", {class: "label"}, t("way.driven")), driven, html("span", {class: "unit"}, "m")), clear));
  let drawn = "";
  let asked = false;

  /** Where it was in the last hour, as far as the gateway has it. */
  async function past() {
    asked = true;
    const answer = await fetch("/api/v1/history?series=latitude,longitude&seconds=3600").catch(() => null);
    if (answer === null || !answer.ok) return;
    /** @type {{series: Record<string, (number | null)[]>}} */
    const {series: {latitude: north, longitude: east}} = await answer.json();
    way.clear();
    north.forEach((one, place) => {
      const other = east[place];
      if (one !== null && other !== null) way.add(one, other);
    });
  }

  /** @param {import("./way.js").Place | null} here */
  function drawMap(here) {
    const seen = view(here === null ? way.places : [...way.places, here]);
    const factor = SIDE / seen.span;
    /** @param {import("./way.js").Place} one @returns {[number, number]} */
    const at = (one) => [(one.east - seen.east) * factor, (seen.north - one.north) * factor];
    const step = nice(seen.span / 8);
    let lines = "";
    for (let east = Math.ceil((seen.east - 2 * seen.span) / step) * step; east < seen.east + 2 * seen.span; east += step) {
      lines += `M${((east - seen.east) * factor).toFixed(1)} -400V400`;
    }
    for (let north = Math.ceil((seen.north - 2 * seen.span) / step) * step; north < seen.north + 2 * seen.span; north += step) {
      lines += `M-400 ${((seen.north - north) * factor).toFixed(1)}H400`;
    }
    set(grid, "d", lines);
    const points = way.places.map((one) => at(one).map((each) => each.toFixed(1)).join(" "));
    set(line, "d", points.length > 1 ? `M${points.join("L")}` : "");
    set(start, "transform", points.length > 0 ? `translate(${points[0]}) ${enlarged()}` : null);
    const shown = nice(seen.span / 5.1);
    const pixels = (shown * factor * Math.min(map.clientWidth, map.clientHeight)) / SIDE
    bar.style.setProperty("width", `${pixels.toFixed(0)}px`);
    setText(scale, `${shown} m`);
    return at;
  }

  /** Drawn as large on any screen. */
  const enlarged = () => `scale(${(SIDE / Math.min(map.clientWidth, map.clientHeight)).toFixed(3)})`;

  /** @param {State} state */
  function draw(state) {
    if (state.live && !asked) past();
    const gps = state.live ? state.topics.gps : undefined;
    const held = gps?.quality === "fresh" && gps.latitude !== null && gps.longitude !== null ? gps : null;
    set(node, "data-absent", held === null);
    setText(place, `${latitude(held?.latitude ?? null)} ${longitude(held?.longitude ?? null)}`);
    const here = held === null ? null : way.add(/** @type {number} */ (held.latitude), /** @type {number} */ (held.longitude));
    setText(driven, digits(way.places.length === 0 ? null : way.length, 5, 0));
    const compass = state.live ? state.topics.magnetometer : undefined;
    const heading = compass?.quality === "fresh" ? compass.heading : null;
    const wanted = `${held?.at} ${heading?.toFixed(2)} ${map.clientWidth} ${map.clientHeight}`;
    if (wanted === drawn || map.clientWidth === 0) return;
    drawn = wanted;
    const at = drawMap(here);
    const [x, y] = here === null ? [0, 0] : at(here);
    set(own, "transform", `translate(${x.toFixed(1)} ${y.toFixed(1)}) rotate(${heading === null ? 0 : degrees(heading).toFixed(0)}) ${enlarged()}`);
    set(own, "data-turned", heading !== null);
  }

  return {node, draw};
}
