// @ts-check
// Keeps the page itself, so that it opens while the gateway restarts. What the gateway knows is never kept.

const worker = /** @type {any} */ (self);
const SHELL = "timonel-shell";

worker.addEventListener("install", () => worker.skipWaiting());
worker.addEventListener("activate", (/** @type {any} */ event) => event.waitUntil(worker.clients.claim()));

/** The gateway's own file, and only without a gateway the one that was kept. @param {Request} request */
async function shell(request) {
  const cache = await caches.open(SHELL);
  try {
    const response = await fetch(request);
    if (response.ok) await cache.put(request, response.clone());
    return response;
  } catch (fault) {
    const kept = await cache.match(request);
    if (kept === undefined) throw fault;
    return kept;
  }
}

worker.addEventListener("fetch", (/** @type {any} */ event) => {
  const {request} = event;
  const url = new URL(request.url);
  if (request.method === "GET" && url.origin === location.origin && !/^\/(api|tiles)\//.test(url.pathname)) event.respondWith(shell(request));
});
