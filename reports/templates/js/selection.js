// Which contestants every figure shows, and which one the pointer highlights.

import { namedInAnswer } from "./cheapest.js";
import { CONTESTANTS, bestOf, defaultOf, markOf } from "./contestants.js";
import { groupBy } from "./data.js";
import { make } from "./dom.js";
import { choose, follow, state } from "./state.js";

/** The default and the best contestant of each engine: shown unless the reader chooses others. */
function leading(tolerance = state.tol) {
  const names = [];
  for (const engine of new Set([...CONTESTANTS.values()].filter((one) => !one.byHand).map((one) => one.engine))) {
    names.push(defaultOf(engine), bestOf(engine, tolerance));
  }
  names.push(...namedInAnswer(tolerance).map(({ name }) => name)); // those that the answer names have a row
  const unique = [...new Set(names.filter(Boolean))];
  return unique.length ? unique : [...CONTESTANTS.keys()]; // a sweep or maps alone have no defaults
}

/** @type {Record<string, [string, () => string[]]>} */
const PRESETS = {
  best: ["defaults and best", () => leading()],
  engines: ["engines", () => namesWhere((one) => !one.ours && !one.byHand)],
  ours: ["Tumble’s own", () => namesWhere((one) => one.ours)],
  tuned: ["fair settings", () => namesWhere((one) => one.variant === "tuned")],
  defaults: ["default settings", () => namesWhere((one) => one.variant === "defaults")],
  held: ["zero-order hold", () => namesWhere((one) => one.variant === "held")],
  all: ["all", () => namesWhere(() => true)],
  none: ["none", () => []],
};

function namesWhere(wanted) {
  return [...CONTESTANTS.values()].filter(wanted).map((one) => one.name);
}

/** The names of the contestants that all figures show now. */
export function shown() {
  const named = state.show.split(",").filter((name) => CONTESTANTS.has(name));
  if (named.length && !PRESETS[state.show]) return new Set(named);
  return new Set((PRESETS[state.show] ?? PRESETS.best)[1]());
}

// A section with no more contestants of its own shows them all at first.
const FEW = 8;

/**
 * The names that a section shows which has figures of these contestants alone.
 * @param {string[]} own
 */
export function shownWith(own) {
  return new Set([...shown(), ...(state.show === "best" && own.length <= FEW ? own : [])]);
}

/** Show only these. */
export function show(names) {
  choose({ show: [...names].join(",") || "none" });
}

/** The buttons that select contestants in all figures. */
export function chips(host) {
  const buttons = Object.entries(PRESETS)
    .filter(([key, [, names]]) => key === "none" || names().length)
    .map(([key, [label]]) => make("button", { type: "button", class: "chip", "data-show": key, click: () => choose({ show: key }) }, label));
  host.append(make("span", { class: "chips-title" }, "Show in all figures:"), ...buttons);
  follow(["show"], () => buttons.forEach((button) => button.setAttribute("aria-pressed", button.dataset.show === state.show)));
}

let highlighted = "";
const highlightable = [];

/** Highlight a contestant in every figure; "" highlights none. */
export function highlight(name) {
  if (name === highlighted) return;
  highlighted = name;
  highlightable.forEach(fadeOthers);
}

/** Let a figure follow the highlight; call the returned function after it is drawn again. */
export function followHighlight(svg) {
  highlightable.push(svg);
  return () => fadeOthers(svg);
}

function fadeOthers(svg) {
  for (const part of svg.querySelectorAll("[data-name]")) part.setAttribute("opacity", highlighted && highlighted !== part.dataset.name ? 0.15 : 1);
}

/** A box for each contestant, to show or hide it. */
export function chooser(host) {
  const boxes = new Map();
  const list = make("div", { class: "chooser-list" });
  for (const [engine, own] of groupBy(CONTESTANTS.values(), (one) => one.engine)) {
    const field = make("fieldset", {}, make("legend", {}, engine));
    for (const { name, method } of own) {
      const box = make("input", { type: "checkbox", change: () => show([...boxes].filter(([, each]) => each.checked).map(([other]) => other)) });
      boxes.set(name, box);
      field.append(make("label", {}, box, markOf(name), ` ${method}`));
    }
    list.append(field);
  }
  host.append(make("details", { class: "chooser" }, make("summary", {}, "choose contestants"), list));
  follow(["show", "tol"], () => {
    const names = shown();
    for (const [name, box] of boxes) box.checked = names.has(name);
  });
}
