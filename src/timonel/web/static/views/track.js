// @ts-check
/** Where the boat is and was: a graticule, the track and a scale, over the gateway's own map tiles if it has some. */

import {html, svg} from "../dom.js";
import {t} from "../i18n.js";
import {nearestTiles, past} from "../session.js";
import {now, valid} from "../store.js";
import {degrees, latitude, longitude} from "../units.js";

/** @typedef {import("../store.js").State} State */

const KEPT = 3600; // points of the track
const STEP = 1; // s
const ZOOM = 16;
const NEAREST = 19;
const MILE = 1852; // m
const STEPS = [1 / 600, 1 / 300, 1 / 120, 1 / 60, 1 / 30, 1 / 12, 1 / 6, 0.5, 1, 2, 5, 10, 30]; // degrees between lines

/** Lines of latitude and longitude, with their minutes. @param {typeof import("leaflet")} L @param {import("leaflet").Map} map */
function graticule(L, map) {
  const lines = L.layerGroup().addTo(map);

  /** @param {number} value @param {boolean} north */
  const label = (value, north) => L.divIcon({className: `graticule-label ${north ? "north" : "east"}`, iconSize: [0, 0], html: north ? latitude(value).replace(/\.000/, "") : longitude(value).replace(/\.000/, "")});

  function draw() {
    lines.clearLayers();
    const bounds = map.getBounds();
    const wanted = (bounds.getEast() - bounds.getWest()) / Math.max(1.5, map.getSize().x / 150);
    const step = STEPS.find((one) => one >= wanted) ?? STEPS[STEPS.length - 1];
    const style = {className: "graticule", interactive: false, weight: 1};
    for (let value = Math.ceil(bounds.getSouth() / step) * step; value < bounds.getNorth(); value += step) {
      L.polyline([[value, bounds.getWest()], [value, bounds.getEast()]], style).addTo(lines);
      L.marker([value, bounds.getWest()], {icon: label(value, true), interactive: false, keyboard: false}).addTo(lines);
    }
    for (let value = Math.ceil(bounds.getWest() / step) * step; value < bounds.getEast(); value += step) {
      L.polyline([[bounds.getSouth(), value], [bounds.getNorth(), value]], style).addTo(lines);
      L.marker([bounds.getNorth(), value], {icon: label(value, false), interactive: false, keyboard: false}).addTo(lines);
    }
  }

  map.on("moveend resize", draw);
  draw();
}

/** A bar of a round number of miles. @param {import("leaflet").Map} map */
function scaleBar(map) {
  const text = html("span");
  const node = html("div", {class: "scale-bar"}, text);
  function draw() {
    const middle = map.getSize().y / 2;
    const perPixel = map.distance(map.containerPointToLatLng([0, middle]), map.containerPointToLatLng([100, middle])) / 100;
    const wanted = (perPixel * 110) / MILE;
    const power = 10 ** Math.floor(Math.log10(wanted));
    const miles = [5, 2, 1].map((one) => one * power).find((one) => one <= wanted) ?? power;
    node.style.width = `${((miles * MILE) / perPixel).toFixed(0)}px`;
    text.textContent = `${Number(miles.toPrecision(1))} NM`;
  }
  map.on("zoomend moveend resize", draw);
  draw();
  return node;
}

export function track() {
  const place = html("div", {class: "map"});
  const position = html("output", {class: "position"});
  const node = html("section", {class: "panel track", "aria-label": t("track.title")}, place, position);
  /** @type {[number, number][]} */
  const points = [];
  /** @type {{map: import("leaflet").Map, line: import("leaflet").Polyline, marker: import("leaflet").Marker, boat: SVGElement} | null} */
  let chart = null;
  let starting = false;
  let followed = true;
  let added = -Infinity;

  async function start() {
    starting = true;
    const L = await import("../vendor/leaflet.js");
    const map = L.map(place, {attributionControl: false, zoomControl: false, minZoom: 3, maxZoom: NEAREST, zoomAnimation: false, fadeAnimation: false, inertia: false, keyboard: false});
    const boat = svg("svg", {viewBox: "-20 -20 40 40", width: 40, height: 40, "aria-hidden": "true"}, svg("path", {class: "own", d: "M0 -17C6 -9 8 2 5 15H-5C-8 2 -6 -9 0 -17Z"}));
    map.setView(points.at(-1) ?? [0, 0], ZOOM);
    const line = L.polyline(points, {className: "track-line", interactive: false, weight: 2, smoothFactor: 1.5}).addTo(map);
    const holder = html("div");
    holder.append(boat);
    const marker = L.marker(points.at(-1) ?? [0, 0], {icon: L.divIcon({className: "own-boat", html: holder, iconSize: [40, 40], iconAnchor: [20, 20]}), interactive: false, keyboard: false}).addTo(map);
    graticule(L, map);
    spread(L, map);
    /** @param {string} key @param {string} sign @param {() => void} act */
    const button = (key, sign, act) => html("button", {class: "key map-key", type: "button", "aria-label": t(key), click: act}, sign);
    node.append(scaleBar(map), html("div", {class: "map-keys"}, button("track.nearer", "+", () => map.zoomIn()), button("track.farther", "−", () => map.zoomOut()),
      button("track.follow", "◎", () => {
        followed = true;
      })));
    map.on("dragstart", () => {
      followed = false;
    });
    new ResizeObserver(() => map.invalidateSize({pan: false})).observe(place);
    chart = {map, line, marker, boat};
    await recall();
  }

  /** A map below it all. @param {typeof import("leaflet")} L @param {import("leaflet").Map} map */
  async function spread(L, map) {
    const nearest = await nearestTiles();
    if (nearest !== null) L.tileLayer("tiles/{z}/{x}/{y}.png", {maxNativeZoom: nearest, maxZoom: NEAREST, keepBuffer: 1}).addTo(map);
  }

  /** What was before we came. */
  async function recall() {
    const before = await past(["latitude", "longitude"], KEPT);
    if (before === null) return;
    const {latitude: norths, longitude: easts} = before.series;
    const sailed = norths.flatMap((north, place) => {
      const east = easts[place];
      return north === null || east === null ? [] : [/** @type {[number, number]} */ ([north, east])];
    });
    points.unshift(...sailed);
  }

  /** @param {State} state @param {number} local */
  function draw(state, local) {
    const where = state.topics.position;
    const held = state.live && where?.quality === "fresh" && where.latitude !== null && where.longitude !== null;
    const north = held ? where.latitude : null;
    const east = held ? where.longitude : null;
    position.textContent = `${latitude(north)}  ${longitude(east)}`;
    node.toggleAttribute("data-absent", !held);
    if (north === null || east === null) return;
    const time = now(state, local);
    if (time - added < STEP) return;
    added = time;
    points.push([north, east]);
    if (points.length > KEPT) points.shift();
    if (!starting) start();
    if (chart === null) return;
    chart.line.setLatLngs(points);
    chart.marker.setLatLng([north, east]);
    const heading = valid(state, state.topics.heading);
    chart.boat.setAttribute("transform", `rotate(${heading === null ? 0 : degrees(heading).toFixed(0)})`);
    if (followed) chart.map.panTo([north, east], {animate: false});
  }

  return {node, draw};
}
