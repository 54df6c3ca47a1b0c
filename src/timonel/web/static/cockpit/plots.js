// @ts-check
/** Up to four signals against time, chosen from all there are; what was before the page was opened comes from the gateway. */

import {html, set} from "../dom.js";
import {t} from "../i18n.js";
import {now} from "../store.js";
import {createRecorder} from "./recorder.js";
import {builtIn, ownSignals} from "./signals.js";

/** @typedef {import("../store.js").State} State */
/** @typedef {import("./signals.js").Signal} Signal */

const PERIOD = 0.2; // s between two samples
const REDRAW = 0.5; // s
const HOUR = 3600; // s that are kept
const SPANS = [60, 600, 3600]; // s
const COLOURS = ["--text", "--setpoint", "--starboard", "--port"];
const DASHES = [[], [10, 5], [3, 3], [12, 4, 3, 4]]; // colour is never alone
const CHOSEN = ["left", "left_front_rpm", "right_front_rpm", "left_front_current"];
const STORED = "timonel.plots";

/** @param {string} name */
const colour = (name) => () => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

export function plots() {
  const signals = builtIn();
  const recorder = createRecorder(HOUR / PERIOD + HOUR);
  let chosen = stored();
  let span = SPANS[0];
  /** @type {import("uplot") | null} */
  let chart = null;
  /** @type {"unasked" | "asked" | "told"} */
  let history = "unasked";
  let built = 0; // which choice the chart was made for
  let choice = 1;
  let sampled = -Infinity;
  let drawn = -Infinity;

  const selects = chosen.map((_, place) => html("select", {"aria-label": t("plots.line", {number: place + 1}), change: choose}));
  const spans = SPANS.map((seconds) => html("button", {class: "key", type: "button", "aria-pressed": String(seconds === span), click: () => look(seconds)}, t("plots.minutes", {minutes: seconds / 60})));
  const plot = html("div", {class: "plot"});
  const node = html("section", {class: "panel plots", "aria-label": t("plots.title")},
    html("div", {class: "lines"}, ...selects.map((select, place) => html("label", {"data-line": place}, html("span", {class: "sample", "aria-hidden": "true"}), select))),
    plot, html("div", {class: "spans", role: "group", "aria-label": t("plots.span")}, ...spans));
  offer();

  /** @returns {string[]} */
  function stored() {
    try {
      const kept = JSON.parse(localStorage.getItem(STORED) ?? "null");
      if (Array.isArray(kept) && kept.length === CHOSEN.length && kept.every((one) => typeof one === "string")) return kept;
    } catch (fault) {
      if (!(fault instanceof SyntaxError)) throw fault;
    }
    return [...CHOSEN];
  }

  function offer() {
    const units = [...new Set(signals.map((one) => one.unit))];
    selects.forEach((select, place) => {
      select.replaceChildren(html("option", {value: ""}, "–"), ...units.map((unit) =>
        html("optgroup", {label: unit}, ...signals.filter((one) => one.unit === unit).map((one) => html("option", {value: one.key}, `${one.label} · ${one.unit}`)))));
      select.value = signals.some((one) => one.key === chosen[place]) ? chosen[place] : "";
    });
  }

  function choose() {
    chosen = selects.map((select) => select.value);
    localStorage.setItem(STORED, JSON.stringify(chosen));
    choice += 1;
    drawn = -Infinity;
  }

  /** @param {number} seconds */
  function look(seconds) {
    span = seconds;
    spans.forEach((one, place) => set(one, "aria-pressed", String(SPANS[place] === seconds)));
    drawn = -Infinity;
  }

  async function begin() {
    history = "asked";
    await past();
    history = "told";
  }

  /** The last hour, as far as the gateway has it. */
  async function past() {
    const answer = await fetch(`/api/v1/history?seconds=${HOUR}`).catch(() => null);
    if (answer === null || !answer.ok) return;
    /** @type {{ended: number, step: number, series: Record<string, (number | null)[]>}} */
    const {ended, step, series} = await answer.json();
    const known = signals.filter((one) => one.key in series);
    const length = Math.max(0, ...known.map((one) => series[one.key].length));
    for (let place = 0; place < length; place += 1) {
      recorder.take(ended - (length - 1 - place) * step, known.map((one) => {
        const value = series[one.key][place];
        return [one.key, value === null ? null : one.scale(value)];
      }));
    }
  }

  async function build() {
    built = choice;
    const {default: UPlot} = await import("../vendor/uplot.js");
    chart?.destroy();
    const lines = chosen.map((key) => signals.find((one) => one.key === key));
    const units = [...new Set(lines.flatMap((one) => (one === undefined ? [] : [one.unit])))];
    const axis = {stroke: colour("--quiet"), grid: {stroke: colour("--line"), width: 1}, ticks: {stroke: colour("--line"), width: 1}, font: '12px "Noto Sans"', labelFont: '12px "Noto Sans"'};
    chart = new UPlot({
      width: 300, height: 150, legend: {show: false}, cursor: {show: false}, pxAlign: 0, padding: [10, 8, 0, 4],
      scales: {x: {time: false, range: () => [-span, 0]}, ...Object.fromEntries(units.map((unit) => [unit, {range: around}]))},
      axes: [
        {...axis, size: 26, values: (_, splits) => splits.map((value) => (value === 0 ? "0" : (span > 60 ? `${value / 60} min` : `${value} s`).replace("-", "−")))},
        ...units.slice(0, 3).map((unit, place) => ({...axis, scale: unit, label: unit, labelSize: 16, labelGap: 0, size: 44, side: place === 0 ? 3 : 1, grid: {...axis.grid, show: place === 0}})),
      ],
      series: [{}, ...lines.map((one, place) => ({scale: one?.unit ?? units[0] ?? "1", stroke: colour(COLOURS[place]), width: 2, dash: DASHES[place], points: {show: false}, spanGaps: false}))],
    }, [[], ...lines.map(() => [])], plot);
    fit();
  }

  /** Never so near that a quiet signal looks wild. @param {unknown} _ @param {number | null} low @param {number | null} high @returns {[number, number]} */
  function around(_, low, high) {
    if (low == null || high == null) return [0, 1];
    const room = Math.max((high - low) * 0.1, Math.abs(high) * 0.02, 0.05);
    return [low - room, high + room];
  }

  function fit() {
    if (plot.clientWidth > 0 && plot.clientHeight > 0) chart?.setSize({width: plot.clientWidth, height: plot.clientHeight});
  }

  /** @param {State} state */
  function adopt(state) {
    const fresh = ownSignals(state).filter((one) => !signals.some((known) => known.key === one.key));
    if (fresh.length === 0) return;
    signals.push(...fresh);
    offer();
  }

  const watcher = new ResizeObserver(fit);
  watcher.observe(plot);
  const recolour = () => chart?.redraw(false);
  document.addEventListener("timonel-palette", recolour);

  /** @param {State} state @param {number} local */
  function draw(state, local) {
    if (!state.live) return;
    const time = now(state, local);
    if (history === "unasked") begin();
    if (history !== "told") return;
    if (time - sampled >= PERIOD) {
      sampled = time;
      adopt(state);
      recorder.take(time, signals.map((one) => [one.key, one.read(state)]));
    }
    if (time - drawn < REDRAW || plot.clientWidth === 0) return;
    drawn = time;
    if (built !== choice) build();
    const [times, ...values] = recorder.since(chosen, time - span);
    if (built === choice) chart?.setData([times.map((one) => one - time), ...values]);
  }

  return {node, draw, leave: () => {
    watcher.disconnect();
    document.removeEventListener("timonel-palette", recolour);
    chart?.destroy();
  }};
}
