// @ts-check
/** How well the link carries: there and back, frames a second and age for each id, bytes that belonged to none. */

import {html, set, setText, show} from "../dom.js";
import {t} from "../i18n.js";
import {now} from "../store.js";
import {digits} from "../units.js";

/** @typedef {import("../store.js").State} State */
/** @typedef {import("../app.js").Console} Console */
/** @typedef {import("./driving.js").Driving} Driving */

const PING = 500; // ms
const KEPT = 20; // pings of the last ten seconds
const LOST = 2000; // ms
const SILENT = 2; // s; a frame this old is marked

/** The time there and back, ms. @param {Console} console */
function pinging({store, socket}) {
  /** @type {Map<number, number>} */
  const sent = new Map();
  /** @type {(number | null)[]} */
  let times = [];
  let count = 0;

  /** @param {number | null} time */
  function keep(time) {
    times = [...times, time].slice(-KEPT);
  }

  /** @param {number} n */
  function pong(n) {
    const began = sent.get(n);
    if (began === undefined) return;
    sent.delete(n);
    keep(performance.now() - began);
  }

  function ping() {
    for (const [n, began] of sent) {
      if (performance.now() - began < LOST) continue;
      sent.delete(n);
      keep(null);
    }
    if (!store.state.live) {
      sent.clear();
      times = [];
    } else if (!document.hidden) {
      sent.set(++count, performance.now());
      socket.say({type: "ping", n: count});
    }
  }

  socket.pongs.add(pong);
  const timer = setInterval(ping, PING);
  return {
    get times() {
      return /** @type {number[]} */ (times.filter((time) => time !== null)).sort((a, b) => a - b);
    },
    get lost() {
      return times.filter((time) => time === null).length;
    },
    leave() {
      socket.pongs.delete(pong);
      clearInterval(timer);
    },
  };
}

/** @param {string[]} columns keys of their headings @param {string} caption */
function table(columns, caption) {
  const body = html("tbody");
  const node = html("table", {"aria-label": caption}, html("thead", {}, html("tr", {}, ...columns.map((key) => html("th", {scope: "col"}, t(key))))), body);

  /** @param {{cells: string[], marked?: boolean}[]} rows */
  function write(rows) {
    while (body.rows.length > rows.length) body.deleteRow(-1);
    rows.forEach(({cells, marked = false}, place) => {
      const row = body.rows[place] ?? body.insertRow();
      while (row.cells.length < cells.length) row.append(row.cells.length === 0 ? html("th", {scope: "row"}) : html("td"));
      cells.forEach((text, column) => setText(row.cells[column], text));
      set(row, "data-old", marked);
    });
  }
  return {node, write};
}

/** @param {Console} console @param {Driving} driving */
export function quality(console, driving) {
  const pings = pinging(console);
  /** @param {string} key @param {string} unit */
  function figure(key, unit) {
    const value = html("output", {class: "value"});
    return {value, node: html("div", {class: "figure"}, html("span", {class: "label"}, t(key)), value, html("span", {class: "unit"}, unit))};
  }
  const median = figure("quality.median", "ms");
  const worst = figure("quality.worst", "ms");
  const rejected = figure("quality.rejected", "");
  const sticks = figure("quality.sticks", "/s");
  const frames = table(["quality.id", "quality.frame", "quality.rate", "quality.age"], t("quality.frames"));
  const ports = table(["quality.port", "quality.whole", "quality.skipped", "quality.broken"], t("quality.ports"));
  const dialect = html("p", {class: "dialect"});
  const node = html("section", {class: "panel quality", "aria-label": t("quality.title"), tabindex: "0"},
    html("div", {class: "figures"}, median.node, worst.node, sticks.node, rejected.node), frames.node, ports.node, dialect);
  let counted = {at: 0, said: 0, rate: 0};

  /** @param {State} state @param {number} local */
  function draw(state, local) {
    if (local - counted.at >= 1) counted = {at: local, said: driving.said, rate: (driving.said - counted.said) / (local - counted.at)};
    const {times} = pings;
    setText(median.value, digits(times.length === 0 ? null : times[Math.floor(times.length / 2)], 4, 0));
    setText(worst.value, digits(times.length === 0 ? null : (times.at(-1) ?? null), 4, 0));
    set(worst.node, "data-lost", pings.lost > 0);
    setText(sticks.value, digits(state.live ? counted.rate : null, 2, 0));
    const told = state.live ? state.topics.quality : undefined;
    setText(rejected.value, digits(told?.rejected ?? null, 4, 0));
    const clock = now(state, local);
    frames.write([...(told?.frames ?? [])].sort((a, b) => a.id - b.id).map(({id, name, rate, at}) =>
      ({cells: [String(id), name, digits(rate, 2, 1), digits(Math.min(999, Math.max(0, clock - at)), 3, 1)], marked: clock - at > SILENT})));
    ports.write((told?.framing ?? []).map((port) => ({cells: [port.port, String(port.frames), String(port.skipped), String(port.rejected)]})));
    setText(dialect, told === undefined ? "" : t("quality.dialect", {dialect: told.dialect}));
  }

  return {node, draw, leave: pings.leave};
}

/** The frames that the owner declared, each signal in a line. */
export function own() {
  const rows = table(["own.id", "own.frame", "own.signal", "own.value", "own.unit"], t("own.title"));
  const none = html("p", {class: "none"}, t("own.none"));
  const node = html("section", {class: "panel own", "aria-label": t("own.title"), tabindex: "0"}, html("h2", {class: "label"}, t("own.title")), none, rows.node);

  /** @param {State} state */
  function draw(state) {
    const told = state.topics.own ?? [];
    show(none, told.length === 0);
    show(rows.node, told.length > 0);
    rows.write(told.flatMap((frame) => frame.values.map(({name, unit, value}) => {
      const fresh = state.live && frame.quality === "fresh";
      const text = !fresh || value === null ? "----" : typeof value === "string" ? value : String(Number(value.toPrecision(6)));
      return {cells: [String(frame.id), frame.name, name, text, unit], marked: !fresh};
    })));
  }

  return {node, draw};
}
