// @ts-check
/** What is read in digits: heading and set point, big; speeds, depth, wind and temperature, smaller. */

import {html, set, setText} from "../dom.js";
import {t} from "../i18n.js";
import {now, valid} from "../store.js";
import {age, course, depth, rateOfTurn, referenceLetter, sided, speed, temperature} from "../units.js";

/** @typedef {import("../store.js").State} State */
/** @typedef {{text: string, unit: string, side?: string}} Shown */

const SHOW_AGE = 3; // s; from then on dashes say how old they are

/** @param {string} kind @param {string} key */
function big(kind, key) {
  const value = html("output", {class: "value"});
  const unit = html("span", {class: "unit"});
  const node = html("section", {class: `panel big ${kind}`, "aria-label": t(`${key}_long`)},
    html("span", {class: "label"}, t(key)), unit, value);
  return {node, value, unit};
}

export function heading() {
  const {node, value, unit} = big("heading", "value.heading");
  /** @param {State} state */
  function draw(state) {
    const measured = state.topics.heading;
    const angle = valid(state, measured);
    setText(value, course(angle));
    setText(unit, `°${referenceLetter(measured?.reference ?? "true")}`);
    set(node, "data-absent", angle === null);
  }
  return {node, draw};
}

export function setpoint() {
  const {node, value, unit} = big("setpoint", "value.setpoint");
  /** @param {State} state */
  function draw(state) {
    const pilot = state.topics.pilot;
    const angle = state.live ? (pilot?.setpoint ?? null) : null;
    setText(value, course(angle));
    setText(unit, `°${referenceLetter(pilot?.reference ?? "true")}`);
    set(node, "data-absent", angle === null);
    set(node, "data-pending", state.live && pilot?.pending === true);
  }
  return {node, draw};
}

/** @param {string} key */
function tile(key) {
  const value = html("output", {class: "value"});
  const unit = html("span", {class: "unit"});
  const more = html("span", {class: "more"});
  const node = html("div", {class: "tile", "data-key": key},
    html("div", {class: "head"}, html("span", {class: "label", title: t(`value.${key}_long`)}, t(`value.${key}`)), more),
    html("div", {class: "number"}, value, unit));

  /** @param {State} state @param {number} local @param {{at: number | null, quality: string} | undefined} measured @param {Shown} shown @param {string} extra */
  function write(state, local, measured, shown, extra) {
    const held = state.live && measured?.quality === "fresh";
    const old = !held && state.met && measured?.at != null ? now(state, local) - measured.at : 0;
    setText(value, shown.text);
    setText(unit, shown.unit);
    setText(more, old > SHOW_AGE ? age(old) : held ? extra : "");
    set(node, "data-absent", !held);
  }
  return {node, write};
}

/** @param {"apparent" | "true"} kind */
function windTile(kind) {
  const {node, write} = tile(`wind_${kind}`);
  /** @param {State} state @param {number} local */
  function draw(state, local) {
    const wind = state.topics[`wind_${kind}`];
    const held = state.live && wind?.quality === "fresh";
    const from = sided(held ? (wind?.angle ?? null) : null, 0);
    const angle = `${from.text.padStart(3, held ? "0" : "–")}°${from.side === "" ? "" : t(`side.${from.side}`)}`;
    write(state, local, wind, speed(held ? (wind?.speed ?? null) : null), angle);
  }
  return {node, draw};
}

/** @param {string} key @param {"stw" | "sog" | "depth" | "water_temperature" | "rate_of_turn"} topic @param {(value: number | null) => Shown} convert */
function valueTile(key, topic, convert) {
  const {node, write} = tile(key);
  /** @param {State} state @param {number} local */
  function draw(state, local) {
    const measured = state.topics[topic];
    write(state, local, measured, convert(valid(state, measured)), "");
  }
  return {node, draw};
}

function courseTile() {
  const {node, write} = tile("cog");
  /** @param {State} state @param {number} local */
  function draw(state, local) {
    const cog = state.topics.cog;
    write(state, local, cog, {text: course(valid(state, cog), 0), unit: `°${referenceLetter(cog?.reference ?? "true")}`}, "");
  }
  return {node, draw};
}

/** Course and rate of turn stand in the compass too, where that has room. */
export function tiles() {
  const all = [
    valueTile("stw", "stw", speed), valueTile("sog", "sog", speed), valueTile("depth", "depth", depth),
    windTile("apparent"), windTile("true"), valueTile("temperature", "water_temperature", temperature),
    courseTile(), valueTile("rot", "rate_of_turn", rateOfTurn),
  ];
  const node = html("section", {class: "tiles", "aria-label": t("values.title")}, ...all.map((one) => one.node));
  /** @param {State} state @param {number} local */
  function draw(state, local) {
    for (const one of all) one.draw(state, local);
  }
  return {node, draw};
}
