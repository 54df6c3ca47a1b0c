// @ts-check
/** Ten minutes of heading, set point and rudder. */

import {html} from "../dom.js";
import {t} from "../i18n.js";
import {past} from "../session.js";
import {now, valid} from "../store.js";
import {degrees, signed, turned} from "../units.js";

/** @typedef {import("../store.js").State} State */
/** @typedef {{times: number[], heading: (number | null)[], setpoint: (number | null)[], rudder: (number | null)[]}} Samples */

const SPAN = 600; // s
const STEP = 1; // s
const RUDDER_END = 40; // degrees

/** A direction without its jump at north: the one nearest to the last one. @param {number | null} course degrees @param {number | null} last */
export function unwrapped(course, last) {
  return course === null || last === null ? course : last + signed(course - last);
}

/** @param {number | null} radians */
const angle = (radians) => (radians === null ? null : degrees(radians));

/** @param {string} name */
const colour = (name) => () => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

/** @param {AbortSignal} signal ends it */
export function trend(signal) {
  const plot = html("div", {class: "plot"});
  const legend = html("p", {class: "legend"},
    html("span", {class: "line of-heading"}, t("value.heading")), html("span", {class: "line of-setpoint"}, t("value.setpoint")), html("span", {class: "line of-rudder"}, t("value.rudder")));
  const node = html("section", {class: "panel trend", "aria-label": t("trend.title")}, legend, plot);
  /** @type {Samples} */
  const samples = {times: [], heading: [], setpoint: [], rudder: []};
  /** @type {import("uplot") | null} */
  let chart = null;
  let starting = false;

  async function start() {
    starting = true;
    const {default: UPlot} = await import("../vendor/uplot.js");
    const axis = {stroke: colour("--quiet"), grid: {stroke: colour("--line"), width: 1}, ticks: {stroke: colour("--line"), width: 1}, font: '12px "Noto Sans"'};
    const points = {show: false};
    chart = new UPlot({
      width: 300, height: 150, legend: {show: false}, cursor: {show: false}, pxAlign: 0, padding: [8, 4, 0, 0],
      scales: {x: {time: false, range: () => [-SPAN / 60, 0]}, y: {range: around}, rudder: {range: [-RUDDER_END, RUDDER_END]}},
      axes: [
        {...axis, size: 26, values: (_, splits) => splits.map((value) => (value === 0 ? "0" : `${value.toFixed(0).replace("-", "−")}`) + (value === 0 ? " min" : ""))},
        {...axis, size: 44, values: (_, splits) => splits.map((value) => turned(Math.round(value)).toFixed(0).padStart(3, "0"))},
        {...axis, size: 36, scale: "rudder", side: 1, grid: {show: false}, splits: [-30, 0, 30], values: (_, splits) => splits.map((value) => (value === 0 ? "0" : `${Math.abs(value)}${t(value < 0 ? "side.port" : "side.starboard")}`))},
      ],
      series: [
        {},
        {stroke: colour("--faint"), width: 1.5, scale: "rudder", points},
        {stroke: colour("--setpoint"), width: 2, dash: [8, 5], points},
        {stroke: colour("--text"), width: 2, points},
      ],
    }, [[], [], [], []], plot);
    new ResizeObserver(fit).observe(plot);
    fit();
    await recall();
  }

  /** What was before we came. */
  async function recall() {
    const before = await past(["heading", "setpoint", "rudder"], SPAN);
    if (before === null) return;
    const since = {...samples};
    Object.assign(samples, {times: [], heading: [], setpoint: [], rudder: []});
    const {heading, setpoint, rudder} = before.series;
    const first = since.times[0] ?? Infinity;
    heading.forEach((_, place) => {
      const time = before.ended - (heading.length - 1 - place) * before.step;
      if (time < first) add(time, angle(heading[place]), angle(setpoint[place]), angle(rudder[place]));
    });
    since.times.forEach((time, place) => add(time, since.heading[place], since.setpoint[place], since.rudder[place]));
    redraw();
  }

  function fit() {
    if (plot.clientWidth > 0 && plot.clientHeight > 0) chart?.setSize({width: plot.clientWidth, height: plot.clientHeight});
  }

  /** At least twenty degrees, so that a quiet sea does not look wild. @param {unknown} _ @param {number | null} low @param {number | null} high @returns {[number, number]} */
  function around(_, low, high) {
    if (low == null || high == null) return [0, 360];
    const middle = (low + high) / 2;
    const half = Math.max(10, ((high - low) / 2) * 1.15);
    return [middle - half, middle + half];
  }

  function redraw() {
    const {times, heading, setpoint, rudder} = samples;
    const end = times.at(-1) ?? 0;
    chart?.setData([times.map((time) => (time - end) / 60), rudder, setpoint, heading]);
  }

  /** @param {(number | null)[]} column */
  const last = (column) => column.findLast((value) => value !== null) ?? null;

  /** @param {number} time @param {number | null} heading @param {number | null} setpoint @param {number | null} rudder all degrees */
  function add(time, heading, setpoint, rudder) {
    samples.times.push(time);
    samples.heading.push(unwrapped(heading, last(samples.heading)));
    samples.setpoint.push(unwrapped(setpoint, last(samples.heading) ?? last(samples.setpoint)));
    samples.rudder.push(rudder);
    while (samples.times.length > 0 && samples.times[0] < time - SPAN) {
      for (const column of [samples.times, samples.heading, samples.setpoint, samples.rudder]) column.shift();
    }
  }

  /** @param {State} state @param {number} local */
  function draw(state, local) {
    if (!starting && state.live) start();
    const time = now(state, local);
    if (!state.live || time - (samples.times.at(-1) ?? -Infinity) < STEP) return;
    add(time, angle(valid(state, state.topics.heading)), angle(state.topics.pilot?.setpoint ?? null), angle(valid(state, state.topics.rudder)));
    redraw();
  }

  document.addEventListener("timonel-palette", () => chart?.redraw(false), {signal});
  return {node, draw};
}
