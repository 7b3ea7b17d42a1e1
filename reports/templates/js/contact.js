// Does it land? Stopping distances by direction, what holds on a tilted plane, the rebound by drop height, and all verdicts.

import { CONTESTANTS, inkOf, markOf } from "./contestants.js";
import { FONT, chart, legendOf } from "./chart.js";
import { contestantOf, groupBy, nameOf, numbersFound, rows } from "./data.js";
import { draw, make, whenThemeChanges } from "./dom.js";
import { figure, finite, si } from "./numbers.js";
import { figureTools } from "./save.js";
import { followHighlight, shownWith } from "./selection.js";
import { follow } from "./state.js";
import { foldedTable } from "./table.js";
import { showTooltip } from "./tooltip.js";

const RIGHT = "Coulomb and Newton";
const OWN = [...groupBy(rows("contact.csv"), contestantOf).keys()];
const selected = () => shownWith(OWN);

/** The section of scenes with a rigid plane. */
export function contactSection(host) {
  host.append(make("p", { class: "headline" }, contactHeadline()));
  const scans = groupBy(rows("contact-scans.csv"), (row) => `${row.scan} ${row.scene}`);
  for (const own of scans.values()) {
    const figureHost = make("div", { class: "scan" });
    host.append(figureHost);
    if (own[0].scan === "direction") rose(figureHost, own);
    else scanChart(figureHost, own);
  }
  contactTable(host);
  host.append(...whatIsLeftOut());
}

/** Of scenes that are here for contact alone: what else can be run. */
function whatIsLeftOut() {
  const compared = new Set(rows("scenes.csv").map((row) => row.scene));
  const alone = [...groupBy(rows("contact.csv"), (row) => row.scene).keys()].filter((scene) => !compared.has(scene));
  if (!alone.length) return [];
  const command = make("code", {}, `tumble report ${alone.join(" ")}`);
  return [make("p", { class: "note" }, "In these scenes only contact is measured, with one method for each contact law of an engine and, of a ball, the first impact. ", command, " makes their own page: all methods (Tumble’s exact one, tumble:events, compiles for 20 s the first time), later impacts, films. ", make("code", {}, "-e ENGINE"), " adds an engine.")];
}

function percent(share) {
  return `${share > 0 ? "+" : ""}${figure(100 * share, 3)} %`;
}

/** The largest law error of all scenes, and who has none. */
function contactHeadline() {
  const [worst] = numbersFound("largest law error").sort((a, b) => b.value - a.value);
  const all = [...groupBy(rows("contact.csv"), contestantOf)];
  const right = all.filter(([, own]) => own.every((row) => row.verdict === RIGHT || row.verdict.startsWith("sinks by"))).map(([name]) => name);
  const follows = right.length ? ` ${right.length} of ${all.length} contestants follow Coulomb and Newton in every scene here.` : "";
  if (!worst) return `No contestant has a law error here.${follows}`;
  const row = rows("contact.csv").find((one) => one.scene === worst.scene && nameOf(one) === nameOf(worst) && one.observable === worst.other);
  const verdict = row && row.verdict !== "another law" ? ` (${row.verdict})` : "";
  return `The largest law error: in ${worst.scene}, ${nameOf(worst)} is ${figure(100 * worst.value, 2)} % off in the ${worst.other}, and no smaller step removes it${verdict}.${follows}`;
}

/**
 * Where a body stops that slides in each direction, over the true circle.
 * @param {Element} host
 * @param {Tables["contact-scans.csv"][]} all
 */
function rose(host, all) {
  const { scene, true: true_m } = all[0];
  const contestants = groupBy(all, nameOf);
  const id = `rose-${scene}`;
  const svg = draw("svg", { class: "rose", role: "img", id, "aria-label": `Stopping distance by direction, ${scene}: the truth is a circle` });
  const fadeOthers = followHighlight(svg);
  const ways = new Map([...contestants].map(([name, own]) => [name, waysOf(own)]));
  function render() {
    const names = [...ways.keys()].filter((name) => selected().has(name) && ways.get(name).length);
    const size = 320;
    const legend = legendOf(names, size, 0, selected);
    svg.setAttribute("viewBox", `0 0 ${size} ${size + 8 + legend.below}`);
    const reach = Math.max(1.1, ...names.flatMap((name) => ways.get(name).map(({ x, y }) => Math.hypot(x, y))));
    const place = ({ x, y }) => [size / 2 + (0.44 * size * x) / reach, size / 2 - (0.44 * size * y) / reach];
    svg.replaceChildren();
    for (const angle of [0, 1, 2, 3, 4, 5, 6, 7].map((step) => (step * Math.PI) / 4)) {
      const [x, y] = place({ x: reach * Math.cos(angle), y: reach * Math.sin(angle) });
      svg.append(draw("line", { x1: size / 2, y1: size / 2, x2: x, y2: y, stroke: "var(--rule)", "stroke-width": 1 }));
      const [tx, ty] = place({ x: 1.08 * reach * Math.cos(angle), y: 1.08 * reach * Math.sin(angle) });
      if (angle < 3) svg.append(draw("text", { x: tx, y: ty + 4, "text-anchor": "middle", fill: "var(--soft)", "font-size": FONT - 1 }, `${Math.round((angle * 180) / Math.PI)}°`));
    }
    svg.append(draw("circle", { cx: size / 2, cy: size / 2, r: (0.44 * size) / reach, fill: "var(--ink)", "fill-opacity": 0.06, stroke: "var(--ink)", "stroke-width": 2.4 }));
    for (const name of names) {
      const points = ways.get(name).map(place);
      const { hue, dash, mark } = CONTESTANTS.get(name);
      const group = draw("g", { class: "curve", "data-name": name, pointermove: (event) => showTooltip([name, ...roseLines(ways.get(name), true_m)], event), pointerleave: () => showTooltip(null) });
      group.append(draw("path", { d: `M${points.map((point) => point.map((value) => value.toFixed(1)).join(",")).join("L")}Z`, fill: "none", stroke: `var(${hue})`, "stroke-width": 1.8, "stroke-dasharray": dash, "stroke-linejoin": "round" }));
      for (const [x, y] of points) group.append(draw("path", { transform: `translate(${x.toFixed(1)} ${y.toFixed(1)}) scale(2.6)`, d: mark, ...inkOf(name) }));
      svg.append(group);
    }
    svg.append(...legend.draw(0, size + 12));
    fadeOthers();
  }
  host.append(
    make("h3", {}, `Where does a sliding body stop? (${scene})`),
    make("figure", { class: "chart-box" }, svg, make("figcaption", {}, `Stopping places for sixteen directions of the first velocity. By Coulomb’s law the distance is ${si(true_m, "m", 3)} in each, on a straight line: the circle. Straight lines join the sixteen places. A friction pyramid makes a square of the circle.`), figureTools(id, () => svg)),
  );
  whenThemeChanges(render);
  follow(["show", "tol"], render);
}

/** Where the body stops, over the true distance: direction and turn of the path together. */
function waysOf(own) {
  const turns = new Map(own.filter((row) => row.unit === "rad").map((row) => [row.at, row.value]));
  return own
    .filter((row) => row.unit === "m" && finite(row.value))
    .map((row) => {
      const angle = row.at + (turns.get(row.at) ?? 0);
      return { at: row.at, ratio: row.value / row.true, turn: turns.get(row.at) ?? 0, x: (row.value / row.true) * Math.cos(angle), y: (row.value / row.true) * Math.sin(angle) };
    });
}

function roseLines(ways, true_m) {
  const far = ways.reduce((a, b) => (Math.abs(b.ratio - 1) > Math.abs(a.ratio - 1) ? b : a));
  const turned = ways.reduce((a, b) => (Math.abs(b.turn) > Math.abs(a.turn) ? b : a));
  return [`${si(far.ratio * true_m, "m", 3)} at ${Math.round((far.at * 180) / Math.PI)}° (${percent(far.ratio - 1)})`, `path turned by up to ${figure((Math.abs(turned.turn) * 180) / Math.PI, 2)}°`];
}

/** @type {Record<string, { title: string, x: Axis, y: Axis, least: number, words: string }>} */
const SCANS = {
  tilt: {
    title: "What holds on a tilted plane?",
    x: { label: "tan(tilt) / friction", show: (value) => figure(value, 2) },
    y: { label: "speed along the plane at the end [m/s]", log: true, show: (value) => figure(value, 1) },
    least: 1e-7,
    words: "Above 1 the body must slide. Left of 1 the true speed is 0: what is above the lowest points creeps. Speeds below 10⁻⁷ m/s are drawn as that. The thick line is the truth.",
  },
  "drop height": {
    title: "How high does a ball rebound?",
    x: { label: "drop height [m]", log: true, show: (value) => figure(value, 2) },
    y: { label: "restitution: speed after over speed before" },
    least: -Infinity,
    words: "Newton’s restitution is the same at every height: the thick line. Of the two positions in a step at which the ball meets the plane, the one that is more wrong is shown.",
  },
};

/**
 * One scan of a scene, a curve a contestant, with the truth as a line.
 * @param {Element} host
 * @param {Tables["contact-scans.csv"][]} all
 */
function scanChart(host, all) {
  const { scan, scene } = all[0];
  const said = SCANS[scan];
  if (!said) return;
  const truth = [...groupBy(all, (row) => row.at)].map(([at, [first]]) => ({ x: at, y: first.true })).sort((a, b) => a.x - b.x);
  const series = [...groupBy(all, nameOf)].map(([name, own]) => ({
    name,
    points: [...groupBy(own, (row) => row.at)]
      .flatMap(([, each]) => each.flatMap((row) => (row.value === null ? [] : [{ row, value: row.value }])).sort((a, b) => Math.abs(b.value - b.row.true) - Math.abs(a.value - a.row.true)).slice(0, 1))
      .map(({ row, value }) => ({ x: row.at, y: Math.max(value, said.least), plain: true, lines: [`${figure(value)} ${row.unit === "1" ? "" : row.unit}, true ${figure(row.true)}`, `${scan} ${figure(row.at)}`, `step ${figure(row.dt_s)} s`] }))
      .sort((a, b) => a.x - b.x),
  }));
  host.append(make("h3", {}, `${said.title} (${scene})`));
  const under = ({ X, Y, area, low }) => {
    const points = truth.map(({ x, y }) => [X.place(x), Y.place(said.y.log ? Math.max(y, low) : y)]);
    return [draw("path", { d: `M${points.map((point) => point.map((value) => value.toFixed(1)).join(",")).join("L")}`, fill: "none", stroke: "var(--ink)", "stroke-width": 2.4, "stroke-opacity": 0.7 }), ...(scan === "tilt" ? [draw("line", { x1: X.place(1), x2: X.place(1), y1: area.top, y2: area.bottom, stroke: "var(--ink)", "stroke-dasharray": "4 4" })] : [])];
  };
  chart(host, { id: `scan-${scan.replace(" ", "-")}-${scene}`, label: `${said.title} ${scene}`, x: said.x, y: said.y, series, under, selected, within: said.y.log ? [] : truth.map((point) => point.y) });
  host.append(make("p", { class: "note" }, said.words));
}

function contactTable(host) {
  foldedTable(host, {
    id: "contact-observables",
    file: "contact",
    caption: "All observables: the error of the law apart from that of the step",
    list: rows("contact.csv"),
    key: (row) => `${row.scene}-${nameOf(row)}-${row.observable}-${row.blow ?? ""}`,
    columns: [
      { key: "scene", label: "scene", words: true },
      { key: "method", label: "contestant", words: true, show: (row) => make("span", {}, markOf(contestantOf(row)), ` ${nameOf(row)}`), sort: nameOf },
      { key: "observable", label: "observable", words: true, show: (row) => `${row.observable}${row.blow ? ` ${row.blow}` : ""}` },
      { key: "true", label: "true" },
      { key: "unit", label: "unit", words: true },
      { key: "law_error", label: "law error" },
      { key: "law_error_low", label: "from" },
      { key: "law_error_high", label: "to" },
      { key: "step_error", label: "step error" },
      { key: "order", label: "order" },
      { key: "verdict", label: "verdict", words: true },
    ],
  });
}
