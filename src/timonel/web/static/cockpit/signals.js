// @ts-check
/** Everything that may be drawn against time: its name, its unit, and how it is read. Names are those of the history. */

import {t} from "../i18n.js";
import {ZERO_CELSIUS, degrees} from "../units.js";

/** @typedef {import("../store.js").State} State */
/** @typedef {{key: string, label: string, unit: string, scale: (value: number) => number, read: (state: State) => number | null}} Signal `scale`: from the history's unit */

const SIDES = /** @type {const} */ (["left", "right"]);
const PLACES = /** @type {const} */ (["front", "middle", "rear"]);
const AXES = /** @type {const} */ (["x", "y", "z"]);
const same = (/** @type {number} */ value) => value;
const percent = (/** @type {number} */ value) => value * 100;
const celsius = (/** @type {number} */ value) => value - ZERO_CELSIUS;

/** @param {string} key @param {string} label @param {string} unit @param {(value: number) => number} scale @param {(state: State) => number | null | undefined} raw @returns {Signal} */
function signal(key, label, unit, scale, raw) {
  return {key, label, unit, scale, read: (state) => {
    const value = raw(state);
    return value == null ? null : scale(value);
  }};
}

/** @template {{quality: string}} T @param {T | undefined} topic */
const fresh = (topic) => (topic?.quality === "fresh" ? topic : undefined);

/** The signals that every rover has. @returns {Signal[]} */
export function builtIn() {
  const sides = SIDES.map((side) => signal(side, t(`signal.${side}`), "%", percent, (state) => state.topics.drive?.[side]));
  const wheels = SIDES.flatMap((side, s) => PLACES.flatMap((place, p) => {
    const wheel = (/** @type {State} */ state) => state.topics.wheels?.[3 * s + p];
    const name = t(`wheel.${side}_${place}`);
    return [
      signal(`${side}_${place}_rpm`, name, "rpm", same, (state) => fresh(wheel(state))?.rpm),
      signal(`${side}_${place}_current`, name, "A", same, (state) => wheel(state)?.current),
      signal(`${side}_${place}_temperature`, name, "°C", celsius, (state) => wheel(state)?.temperature),
    ];
  }));
  const cells = [0, 1, 2, 3].map((cell) => signal(`cell${cell + 1}`, t("battery.cell", {number: cell + 1}), "V", same, (state) => fresh(state.topics.battery)?.cells[cell]));
  const modules = [0, 1, 2, 3, 4, 5].map((module) => signal(`module${module + 1}`, t("battery.module", {number: module + 1}), "°C", celsius, (state) => state.topics.battery?.modules[module]));
  const felt = AXES.flatMap((axis) => [
    signal(`acceleration_${axis}`, t("signal.acceleration", {axis}), "m/s²", same, (state) => fresh(state.topics.imu)?.acceleration[axis]),
    signal(`rate_${axis}`, t("signal.rate", {axis}), "°/s", degrees, (state) => fresh(state.topics.imu)?.rate[axis]),
  ]);
  return [
    ...sides, ...wheels, signal("battery_voltage", t("battery.title"), "V", same, (state) => fresh(state.topics.battery)?.voltage), ...cells, ...modules, ...felt,
    signal("heading", t("imu.heading"), "°", degrees, (state) => fresh(state.topics.magnetometer)?.heading),
    signal("strength", t("signal.field"), "µT", (value) => value * 1e6, (state) => fresh(state.topics.magnetometer)?.strength),
  ];
}

/** Those of the owner's frames, as far as they were heard. @param {State} state @returns {Signal[]} */
export function ownSignals(state) {
  return (state.topics.own ?? []).flatMap((frame) => frame.values.filter(({value}) => typeof value !== "string").map(({name, unit}) =>
    signal(`${frame.id}.${name}`, `${frame.name} ${name}`, unit || "1", same, (now) => {
      const value = fresh(now.topics.own?.find((one) => one.id === frame.id))?.values.find((one) => one.name === name)?.value;
      return typeof value === "number" ? value : null;
    })));
}
