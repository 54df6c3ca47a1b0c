// @ts-check
/** What is asked over HTTP: who we are, signing in, pairing, and what was before we came. */

/** @typedef {import("./messages.d.ts").You} You */
/** @typedef {{ok: true, answer: any} | {ok: false, status: number, error: string}} Outcome */

/** @param {string} path @param {object} [body] @returns {Promise<Outcome>} */
async function call(path, body) {
  try {
    const request = body === undefined ? {} : {method: "POST", headers: {"Content-Type": "application/json"}, body: JSON.stringify(body)};
    const response = await fetch(`/api/v1/${path}`, {...request, cache: "no-store"});
    const answer = response.status === 204 ? null : await response.json();
    return response.ok ? {ok: true, answer} : {ok: false, status: response.status, error: answer?.error ?? ""};
  } catch {
    return {ok: false, status: 0, error: ""};
  }
}

/** Whether a token must be told before there is anything to see. */
export async function mustSignIn() {
  const outcome = await call("you");
  return !outcome.ok && (outcome.status === 401 || outcome.status === 403);
}

/** The nearest zoom of the map tiles that the gateway has; null for none. @returns {Promise<number | null>} */
export async function nearestTiles() {
  const outcome = await call("about");
  return (outcome.ok ? outcome.answer.tiles : null) ?? null;
}

/** @param {string} token */
export const signIn = (token) => call("login", {token});

/** Asks to be a station; six digits appear at the helm. @param {number} station */
export const askPairing = (station) => call("pairings", {station, name: navigator.platform.slice(0, 40)});

/** @param {number} pairing @param {string} code */
export const tellCode = (pairing, code) => call("pairings/code", {pairing, code});

/**
 * The last ten minutes, once a second; null if they are not to be had.
 *
 * @param {string[]} names
 * @param {number} seconds
 * @returns {Promise<{ended: number, step: number, series: Record<string, (number | null)[]>} | null>}
 */
export async function past(names, seconds) {
  const outcome = await call(`history?series=${names.join()}&seconds=${seconds}`);
  return outcome.ok ? outcome.answer : null;
}
