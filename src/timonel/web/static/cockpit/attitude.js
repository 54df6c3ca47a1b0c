// @ts-check
/** Roll and pitch out of an IMU: the turning it feels, led back slowly to where it feels the ground. Pure. */

/** @typedef {import("../messages.d.ts").ImuState} ImuState */
/** @typedef {{roll: number, pitch: number, at: number}} Attitude rad, starboard down and bow up positive; at in s */

const SETTLING = 0.8; // s in which a wrong attitude has gone to a third
const GAP = 1.0; // s without word after which it begins anew

/**
 * @param {Attitude | null} before
 * @param {ImuState | undefined} imu
 * @returns {Attitude | null} null where the IMU has nothing to say
 */
export function attitude(before, imu) {
  if (imu === undefined || imu.at === null || imu.quality !== "fresh") return null;
  const {x, y, z} = imu.acceleration;
  if (x === null || y === null || z === null || Math.hypot(x, y, z) < 1) return null; // falling
  const felt = {roll: Math.atan2(y, z), pitch: Math.atan2(x, Math.hypot(y, z)), at: imu.at};
  if (before === null || imu.at - before.at > GAP || imu.at < before.at) return felt;
  const passed = imu.at - before.at;
  const trust = 1 - Math.exp(-passed / SETTLING);
  const roll = before.roll + (imu.rate.x ?? 0) * passed;
  const pitch = before.pitch - (imu.rate.y ?? 0) * passed;
  return {roll: roll + trust * (felt.roll - roll), pitch: pitch + trust * (felt.pitch - pitch), at: imu.at};
}
