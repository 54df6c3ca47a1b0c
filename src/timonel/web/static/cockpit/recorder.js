// @ts-check
/** What is kept of signals, so that any of them may be drawn against time: a ring of numbers for each. Pure. */

const NONE = Number.NaN;

/** @param {number} size samples that are kept */
export function createRecorder(size) {
  const times = new Float64Array(size);
  /** @type {Map<string, Float32Array>} */
  const rings = new Map();
  let count = 0;

  /** @param {string} key */
  function ring(key) {
    const known = rings.get(key) ?? new Float32Array(size).fill(NONE);
    rings.set(key, known);
    return known;
  }

  return {
    get count() {
      return count;
    },
    /** One more sample of everything. @param {number} time s @param {Iterable<[string, number | null]>} values */
    take(time, values) {
      const place = count % size;
      times[place] = time;
      for (const one of rings.values()) one[place] = NONE;
      for (const [key, value] of values) ring(key)[place] = value ?? NONE;
      count += 1;
    },
    /**
     * The samples since `from`, oldest first; null where there was nothing.
     *
     * @param {string[]} keys
     * @param {number} from s
     * @returns {[number[], ...(number | null)[][]]}
     */
    since(keys, from) {
      const kept = Math.min(count, size);
      let begin = count - kept;
      while (begin < count && times[begin % size] < from) begin += 1;
      const places = Array.from({length: count - begin}, (_, index) => (begin + index) % size);
      return [places.map((place) => times[place]), ...keys.map((key) => {
        const values = rings.get(key);
        return places.map((place) => (values === undefined || Number.isNaN(values[place]) ? null : values[place]));
      })];
    },
  };
}
