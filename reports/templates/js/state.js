// The reader's choices, held in the address: each view can be copied, and the back button works.

import { make } from "./dom.js";

/** @typedef {{ tol: number, show: string, scene: string, t: Record<string, number>, mag: number, open: string[], at: string }} State */

/** @type {State} */
const DEFAULTS = { tol: 1e-3, show: "best", scene: "", t: {}, mag: 1, open: [], at: "" };

/** @type {State} */
export const state = { ...DEFAULTS, ...readAddress() };

const listeners = [];

/**
 * Call act now and whenever one of these parts of the state changes.
 * @param {(keyof State)[]} parts
 * @param {() => void} act
 */
export function follow(parts, act) {
  listeners.push([parts, act]);
  act();
}

/**
 * Change the state, the address, and all that follows them.
 * @param {Partial<State>} change
 */
export function choose(change) {
  const changed = Object.keys(change).filter((part) => JSON.stringify(state[part]) !== JSON.stringify(change[part]));
  if (!changed.length) return;
  Object.assign(state, change);
  writeAddress();
  for (const [parts, act] of listeners) if (parts.some((part) => changed.includes(part))) act();
}

/** @returns {Partial<State>} */
function readAddress() {
  /** @type {Partial<State> & { t: Record<string, number> }} */
  const found = { t: {} };
  const parameters = new URLSearchParams(location.hash.slice(1));
  const text = (name) => parameters.get(name) ?? "";
  const tolerance = Number(text("tol"));
  if (tolerance > 0 && Number.isFinite(tolerance)) found.tol = tolerance;
  const magnified = Number(text("mag"));
  if ([1, 10, 100, 1000].includes(magnified)) found.mag = magnified;
  if (text("show")) found.show = text("show");
  if (text("scene")) found.scene = text("scene");
  if (text("open")) found.open = text("open").split(",");
  if (text("at")) found.at = text("at");
  for (const pair of parameters.getAll("t")) {
    const cut = pair.lastIndexOf("~");
    const time = Number(pair.slice(cut + 1));
    if (cut > 0 && Number.isFinite(time)) found.t[pair.slice(0, cut)] = time;
  }
  // An address without a = is a place on the page: #cost, #scene-die-vertex.
  const bare = location.hash.slice(1);
  if (bare && !bare.includes("=")) found.at = [...parameters.keys()][0] ?? "";
  return found;
}

/** The state as an address; it holds only what differs from a fresh page. */
function address(at = "") {
  const parameters = new URLSearchParams();
  if (state.tol !== DEFAULTS.tol) parameters.set("tol", String(state.tol));
  if (state.show !== DEFAULTS.show) parameters.set("show", state.show);
  if (state.scene) parameters.set("scene", state.scene);
  if (state.mag !== 1) parameters.set("mag", String(state.mag));
  if (state.open.length) parameters.set("open", state.open.join(","));
  for (const [scene, time] of Object.entries(state.t)) parameters.append("t", `${scene}~${Number(time.toPrecision(6))}`);
  if (at) parameters.set("at", at);
  return `#${parameters}`;
}

let addressDue = 0;

/** Browsers refuse too many changes a second: a slider is written when it stops. */
function writeAddress() {
  clearTimeout(addressDue);
  addressDue = setTimeout(() => history.replaceState(null, "", address() === "#" ? location.pathname + location.search : address()), 150);
}

window.addEventListener("hashchange", () => {
  const found = { ...DEFAULTS, ...readAddress() };
  choose(found);
  showPlace();
});

/** Bring the place of the address into view, unfolded and marked. */
export function showPlace() {
  const target = state.at && document.getElementById(state.at);
  if (!target) return;
  for (let fold = target.closest("details"); fold; fold = fold.parentElement?.closest("details") ?? null) fold.open = true;
  target.classList.add("arrived");
  target.scrollIntoView({ block: "start" });
  // Figures above are drawn as they are passed and move this one: scroll again after that.
  setTimeout(() => target.scrollIntoView({ block: "start" }), 250);
}

/** Go to a place on the page; the reader's other choices stay. */
export function goTo(event, id) {
  event.preventDefault();
  if (location.hash === address(id)) showPlace();
  else location.hash = address(id);
}

export function linkToPlace(id, words) {
  return make("a", { href: `#${id}`, click: (event) => goTo(event, id) }, words);
}

/** A button that copies the address of a place in this view. */
export function copyLinkButton(id) {
  const copy = async (button) => {
    const copied = await copyText(button, location.href.split("#")[0] + address(id));
    if (copied) return;
    location.hash = address(id); // without a clipboard the address bar has it
    flash(button, "in the address bar");
  };
  return make("button", { type: "button", class: "link", title: "Copy a link to this view", "aria-label": `Copy a link to this view of ${id}`, click: (event) => copy(event.currentTarget) }, "⚓︎");
}

/** A button that copies a text; empty where the browser has no clipboard. */
export function copyTextButton(text) {
  if (!navigator.clipboard) return "";
  return make("button", { type: "button", class: "link copy", "aria-label": `Copy ${text}`, click: (event) => copyText(event.currentTarget, text) }, "copy");
}

async function copyText(button, text) {
  try {
    await navigator.clipboard.writeText(text);
    flash(button, "copied");
    return true;
  } catch {
    return false;
  }
}

/** Show a notice on a button for a moment. */
function flash(button, words) {
  button.dataset.notice = words;
  setTimeout(() => delete button.dataset.notice, 1500);
}
