// @ts-check
/** What a hand means: dead zone and curve of a stick, the ramp of a key. Pure. */

const DEAD_ZONE = 0.1; // of a worn pad's stick at rest
const LINEAR = 0.4; // share of the curve that is straight; the rest is cubic, for slow driving
const RISE = 2.0; // of full deflection a second, for keys, which know no half

/** @param {number} value */
const clamped = (value) => Math.max(-1, Math.min(1, value));

/** Fine around the middle, full at the end. @param {number} share 0..1 */
const curve = (share) => LINEAR * share + (1 - LINEAR) * share ** 3;

/**
 * A stick of a pad or a screen, -1..1: nothing in the dead zone, no jump at its edge, never longer than 1.
 *
 * @param {number} x @param {number} y @param {number} [deadZone]
 * @returns {{x: number, y: number}}
 */
export function shaped(x, y, deadZone = DEAD_ZONE) {
  const length = Math.hypot(x, y);
  if (!Number.isFinite(length) || length <= deadZone) return {x: 0, y: 0};
  const share = curve(Math.min(1, (length - deadZone) / (1 - deadZone)));
  return {x: clamped((x / length) * share), y: clamped((y / length) * share)};
}

/**
 * A key's axis after `seconds`: it rises to what is wanted, and falls at once.
 *
 * @param {number} current @param {number} wanted @param {number} seconds
 */
export function ramped(current, wanted, seconds) {
  if (wanted === 0) return 0;
  const from = current * wanted < 0 ? 0 : current; // the other way begins at rest
  return Math.abs(wanted) <= Math.abs(from) ? wanted : clamped(from + Math.sign(wanted) * Math.min(RISE * seconds, Math.abs(wanted - from)));
}

/**
 * What the wheels of each side would be told of a stick, before the speed limit: the mixer of the rover.
 *
 * @param {number} x @param {number} y
 */
export const mixed = (x, y) => ({left: clamped(y + x), right: clamped(y - x)});
