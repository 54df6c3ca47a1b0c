// @ts-check
/** The one place where SI becomes what people read. */

/** @typedef {{text: string, unit: string}} Reading */

export const KNOT = 1852 / 3600; // m/s
export const ZERO_CELSIUS = 273.15; // K
const MINUTE = 60; // s

/** @param {number} radians */
export const degrees = (radians) => (radians * 180) / Math.PI;

/** @param {number} angle degrees @returns {number} the same direction within 0..360 */
export const turned = (angle) => ((angle % 360) + 360) % 360;

/** @param {number} angle degrees @returns {number} the same direction within -180..180, starboard positive */
export const signed = (angle) => turned(angle + 180) - 180;

/**
 * A number as it is shown: dashes where there is none, and a rounded zero has no sign.
 *
 * @param {number | null} value
 * @param {number} whole digits before the point, as dashes
 * @param {number} decimals
 */
export function digits(value, whole, decimals) {
  if (value === null || !Number.isFinite(value)) return dashes(whole, decimals);
  const text = Math.abs(value).toFixed(decimals);
  return value < 0 && Number(text) !== 0 ? `−${text}` : text;
}

/** @param {number} whole @param {number} decimals */
const dashes = (whole, decimals) => "–".repeat(whole) + (decimals ? `.${"–".repeat(decimals)}` : "");

/**
 * A course, 000.0 to 359.9 degrees: what rounds to 360 is 0.
 *
 * @param {number | null} radians
 * @param {number} [decimals]
 */
export function course(radians, decimals = 1) {
  if (radians === null) return dashes(3, decimals);
  const step = 10 ** decimals;
  const rounded = (Math.round(turned(degrees(radians)) * step) % (360 * step)) / step;
  return rounded.toFixed(decimals).padStart(decimals ? 4 + decimals : 3, "0");
}

/** @param {"true" | "magnetic"} reference */
export const referenceLetter = (reference) => (reference === "true" ? "T" : "M");

/** @param {number | null} metresPerSecond @returns {Reading} */
export const speed = (metresPerSecond) => ({text: digits(metresPerSecond === null ? null : metresPerSecond / KNOT, 2, 1), unit: "kn"});

/** @param {number | null} metres @returns {Reading} */
export const depth = (metres) => ({text: digits(metres, 3, metres !== null && metres >= 100 ? 0 : 1), unit: "m"});

/** @param {number | null} kelvin @returns {Reading} */
export const temperature = (kelvin) => ({text: digits(kelvin === null ? null : kelvin - ZERO_CELSIUS, 2, 1), unit: "°C"});

/** @param {number | null} radiansPerSecond @returns {Reading} in degrees a minute, starboard positive */
export const rateOfTurn = (radiansPerSecond) => ({
  text: digits(radiansPerSecond === null ? null : degrees(radiansPerSecond) * MINUTE, 3, 0), unit: "°/min",
});

/**
 * An angle from the bow with its side in words: "12.4 S" is to starboard.
 *
 * @param {number | null} radians starboard positive
 * @param {number} [decimals]
 * @returns {{text: string, side: "port" | "starboard" | ""}}
 */
export function sided(radians, decimals = 1) {
  if (radians === null) return {text: digits(null, 2, decimals), side: ""};
  const angle = signed(degrees(radians));
  const text = digits(Math.abs(angle), 2, decimals);
  return {text, side: Number(text) === 0 ? "" : angle < 0 ? "port" : "starboard"};
}

/** @param {number | null} angle degrees @param {string} positive @param {string} negative @param {number} whole */
function nautical(angle, positive, negative, whole) {
  if (angle === null) return `${"–".repeat(whole)}°––.–––′`;
  const minutes = Math.round(Math.abs(angle) * 60_000);
  const degreesText = String(Math.floor(minutes / 60_000)).padStart(whole, "0");
  const minutesText = ((minutes % 60_000) / 1000).toFixed(3).padStart(6, "0");
  return `${degreesText}°${minutesText}′${angle < 0 ? negative : positive}`;
}

/** @param {number | null} angle degrees, north positive */
export const latitude = (angle) => nautical(angle, "N", "S", 2);

/** @param {number | null} angle degrees, east positive */
export const longitude = (angle) => nautical(angle, "E", "W", 3);

/** @param {number | null} seconds since 1970 */
export function utc(seconds) {
  return seconds === null ? "––:––:––" : new Date(seconds * 1000).toISOString().slice(11, 19);
}

/** How long ago, in one short word. @param {number} seconds */
export function age(seconds) {
  if (seconds < 100) return `${Math.max(0, Math.floor(seconds))}s`;
  return seconds < 6000 ? `${Math.floor(seconds / 60)}min` : `${Math.floor(seconds / 3600)}h`;
}
