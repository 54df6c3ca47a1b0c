// @ts-check
/**
 * Meaning it: a thumb slid to the end and let go there, or a key held for a while. Pure machines, told place and time.
 *
 * event                      slide                                  hold
 * begins                     on the thumb only                      when it is pressed
 * goes on                    the thumb follows                      it fills
 * ends                       at the end: meant; else back           full: meant; else back
 */

const END = 0.95; // of the way
export const HOLD = 0.8; // s

/** A thumb `thumb` long that slides on a track `length` long; places are from the track's beginning. */
export function createSlide() {
  /** @type {number | null} where on the thumb it is held */
  let grip = null;
  let share = 0;

  return {
    get share() {
      return share;
    },
    get held() {
      return grip !== null;
    },
    /** @param {number} place @param {number} thumb @returns {boolean} whether it is held now */
    press(place, thumb) {
      grip = place >= 0 && place <= thumb ? place : null;
      return grip !== null;
    },
    /** @param {number} place @param {number} way that the thumb can go */
    move(place, way) {
      if (grip !== null && way > 0) share = Math.max(0, Math.min(1, (place - grip) / way));
    },
    /** @returns {boolean} whether it was meant */
    release() {
      const meant = grip !== null && share >= END;
      grip = null;
      share = 0;
      return meant;
    },
    cancel() {
      grip = null;
      share = 0;
    },
  };
}

/** Something that is held for `HOLD` seconds. */
export function createHold() {
  /** @type {number | null} */
  let since = null;

  return {
    /** @param {number} now s */
    press(now) {
      since ??= now;
    },
    cancel() {
      since = null;
    },
    /** @param {number} now s */
    share(now) {
      return since === null ? 0 : Math.max(0, Math.min(1, (now - since) / HOLD));
    },
    /** Whether it was held long enough, told once. @param {number} now s */
    done(now) {
      if (since === null || now < since + HOLD) return false;
      since = Infinity; // until it is let go
      return true;
    },
  };
}
