// @ts-check
/** The way that was driven, in metres on a plane about its beginning; and the scale that it is drawn in. Pure. */

/** @typedef {{east: number, north: number}} Place m */

const EARTH = 6371008.8; // m
const STEP = 0.5; // m between two points that are kept; GPS gives 0.4 m at best
const KEPT = 4000;
const RADIAN = Math.PI / 180;

export function createWay() {
  /** @type {{latitude: number, longitude: number} | null} */
  let origin = null;
  /** @type {Place[]} */
  let places = [];
  let length = 0;

  return {
    get places() {
      return places;
    },
    /** m that were driven, as far as GPS tells. */
    get length() {
      return length;
    },
    clear() {
      origin = null;
      places = [];
      length = 0;
    },
    /** @param {number} latitude @param {number} longitude degrees @returns {Place} */
    add(latitude, longitude) {
      origin ??= {latitude, longitude};
      const place = {
        east: (longitude - origin.longitude) * RADIAN * EARTH * Math.cos(origin.latitude * RADIAN),
        north: (latitude - origin.latitude) * RADIAN * EARTH,
      };
      const last = places.at(-1);
      const step = last === undefined ? Infinity : Math.hypot(place.east - last.east, place.north - last.north);
      if (step >= STEP) {
        if (last !== undefined) length += step;
        places.push(place);
        if (places.length > KEPT) places = places.filter((_, index) => index % 2 === 1 || index > KEPT / 2);
      }
      return place;
    },
  };
}

/**
 * What of the plane is shown, so that all places are in it.
 *
 * @param {Place[]} places
 * @param {number} least m that are seen at least
 * @returns {{east: number, north: number, span: number}} the middle, and how much is seen of it
 */
export function view(places, least = 10) {
  const easts = places.map((one) => one.east);
  const norths = places.map((one) => one.north);
  const [west, east, south, north] = places.length === 0 ? [0, 0, 0, 0] : [Math.min(...easts), Math.max(...easts), Math.min(...norths), Math.max(...norths)];
  const span = nice(Math.max(least, 1.25 * Math.max(east - west, north - south)));
  return {east: (west + east) / 2, north: (south + north) / 2, span};
}

/** The next 1, 2 or 5 times a power of ten. @param {number} value above 0 */
export function nice(value) {
  const power = 10 ** Math.floor(Math.log10(value));
  return ([1, 2, 5, 10].find((step) => step * power >= value - 1e-9 * power) ?? 10) * power;
}
