// How large a time step is stable: measured and theoretical limits in one figure, and maps of the result of each step.

import { FONT, legendOf, scale } from "./chart.js";
import { CONTESTANTS, MARKS, inkOf } from "./contestants.js";
import { contestantOf, findings, groupBy, nameOf, numbersFound, rows } from "./data.js";
import { draw, make, whenThemeChanges } from "./dom.js";
import { counted, figure, given, positive, si } from "./numbers.js";
import { figureTools } from "./save.js";
import { followHighlight, highlight, shown } from "./selection.js";
import { follow, state } from "./state.js";
import { foldedTable } from "./table.js";
import { showTooltip } from "./tooltip.js";
import { SILENT_VERDICTS, STABILITY_VERDICTS } from "./verdicts.js";

const LANE = 13; // between marks that would cover each other
const SIDE = 14; // of a map's cell

export function stableSection(host) {
  host.append(make("p", { class: "headline" }, stableHeadline()));
  limitFigure(host);
  mapsFold(host);
  limitTable(host);
}

function stableHeadline() {
  const known = findings("limits with theory")[0]?.value;
  const near = findings("limits matching theory")[0]?.value;
  const [most] = numbersFound("largest stable step").sort((a, b) => b.value - a.value);
  const [least] = numbersFound("smallest stable step").sort((a, b) => a.value - b.value);
  const sentences = [];
  if (known) sentences.push(`Within 5 %, ${near === known ? "all" : `${near} of`} ${counted(known, "measured limit")} ${near === 1 ? "matches" : "match"} theory.`);
  if (most) sentences.push(`In radians of the stiffest mode, ${nameOf(most)} is stable up to ω·dt = ${figure(most.value)} (${most.scene}), ${nameOf(least)} up to ${figure(least.value)} (${least.scene}).`);
  const hiding = rows("limits.csv").filter((row) => row.beyond in SILENT_VERDICTS).map(contestantOf);
  const often = [...groupBy(hiding, (name) => name)].sort((a, b) => b[1].length - a[1].length)[0];
  if (often) sentences.push(`Beyond its limit ${often[0]} is wrong without an error message in ${counted(often[1].length, "scene")}.`);
  return sentences.join(" ") || "The largest time step at which each contestant is stable.";
}

/** All scenes' limits: a band a scene, a mark a contestant where its limit was measured, a bar where theory puts one. */
function limitFigure(host) {
  const limits = rows("limits.csv").filter((row) => row.w_dt_limit !== null && CONTESTANTS.has(contestantOf(row)));
  if (!limits.length) return;
  const scenes = [...new Set(limits.map((row) => row.scene))];
  const svg = draw("svg", { class: "chart", role: "group", id: "limits-figure", "aria-label": "Largest stable step of each contestant in each stiff scene, in radians of the stiffest mode, beside the theoretical limit" });
  const box = make("figure", { class: "chart-box" }, svg, figureTools("limits-figure", () => svg));
  host.append(box);
  const render = () => {
    const names = shown();
    const drawn = limits.filter((row) => names.has(contestantOf(row)));
    const placed = drawn.flatMap((row) => [row.w_dt_limit, row.theory_w_dt]).filter(positive);
    const width = Math.max(280, Math.round(box.clientWidth) || 600);
    const entries = [...new Set(drawn.map(contestantOf))];
    const legend = legendOf(entries, width, 0.3);
    const left = width < 560 ? 8 : 150;
    const area = { left: left + 64, right: width - legend.beside - 70 };
    const X = scale({ log: true }, [Math.min(0.8, ...placed) / 1.15, Math.max(3.5, ...placed) * 1.25], [area.left, area.right]);
    const ends = { never: left + 22, always: area.right + 34 };
    const parts = [];
    let top = 24;
    for (const scene of scenes) {
      const band = limitBand(scene, drawn.filter((row) => row.scene === scene), { X, area, ends, top, width: width - legend.beside, above: width < 560 });
      parts.push(...band.parts);
      top += band.height;
    }
    const ticks = [0.01, 0.1, 0.2, 0.5, 1, 2, 3, 4, 5, 10, 20, 50, 100, 1000].filter((value) => X.place(value) >= area.left - 1 && X.place(value) <= area.right + 1);
    const soft = (x, y, words, anchor = "middle") => draw("text", { x, y, "text-anchor": anchor, fill: "var(--soft)", "font-size": FONT }, words);
    const grid = ticks.map((value) => draw("line", { x1: X.place(value), x2: X.place(value), y1: 24, y2: top, stroke: "var(--rule)" }));
    const axis = [...ticks.map((value) => soft(X.place(value), top + 15, given(value))), soft(ends.never, 12, "none"), soft(ends.always, 12, "no limit"), soft((area.left + area.right) / 2, 12, "largest stable step, ω·dt [rad]")];
    const key = limitKey(left, top + 34, drawn);
    svg.setAttribute("viewBox", `0 0 ${width} ${Math.max(top + 42 + legend.below, legend.height)}`);
    svg.replaceChildren(...grid, ...parts, ...axis, key, ...legend.draw(legend.beside ? width - legend.beside + 6 : 0, legend.beside ? 34 : top + 52));
    fadeOthers();
  };
  const fadeOthers = followHighlight(svg);
  follow(["show", "tol"], render);
  whenThemeChanges(render);
  new ResizeObserver(render).observe(box);
}

/**
 * One scene of the figure: its name, theory's bars, and its marks, one above the other where they would overlap.
 * @param {string} scene
 * @param {Tables["limits.csv"][]} limits
 */
function limitBand(scene, limits, { X, area, ends, top, width, above }) {
  const place = (value) => (value === 0 ? ends.never : Number.isFinite(value) ? X.place(value) : ends.always);
  const lanes = [];
  const marks = limits
    .map((row) => ({ row, x: place(row.w_dt_limit), wide: (row.beyond in SILENT_VERDICTS ? 12 : 0) + (above || !positive(row.w_dt_limit) ? 0 : 30) }))
    .sort((a, b) => a.x - b.x)
    .map((one) => {
      let lane = lanes.findIndex((end) => one.x - end >= LANE);
      if (lane < 0) lane = lanes.length;
      lanes[lane] = one.x + one.wide;
      return { ...one, lane };
    });
  const head = above ? 16 : 0;
  const height = head + Math.max(1, lanes.length) * LANE + 9;
  const title = rows("scenes.csv").find((row) => row.scene === scene)?.title ?? scene;
  const parts = [
    draw("line", { x1: 0, x2: width, y1: top, y2: top, stroke: "var(--rule)" }),
    draw("text", { x: above ? 0 : 4, y: top + 15, fill: "var(--ink)", "font-size": FONT }, scene, draw("title", {}, title)),
  ];
  const bars = [...new Set(limits.map((row) => row.theory_w_dt).filter(positive).map((value) => Number(value.toPrecision(2))))];
  for (const value of bars) parts.push(draw("line", { class: "theory", x1: X.place(value), x2: X.place(value), y1: top + head + 2, y2: top + height - 2, stroke: "var(--ink)", "stroke-width": 2.5, "stroke-opacity": 0.55 }));
  if (!marks.length) parts.push(draw("text", { x: area.left, y: top + head + 14, fill: "var(--soft)", "font-size": FONT - 1 }, "no contestant shown has a limit here"));
  for (const { row, x, lane } of marks) parts.push(limitMark(row, x, top + head + 10 + lane * LANE, !above));
  return { parts, height };
}

/**
 * @param {Tables["limits.csv"]} row
 */
function limitMark(row, x, y, numbered) {
  const name = contestantOf(row);
  const hides = row.beyond in SILENT_VERDICTS;
  const limit = row.w_dt_limit === 0 ? "none: unstable at every step" : Number.isFinite(row.w_dt_limit) ? `stable up to ω·dt = ${figure(row.w_dt_limit)}, ${si(row.dt_stable_s, "s", 2)}` : "no limit at any step tried";
  const theory = row.theory_w_dt === null ? "" : `theory: ${row.theory_w_dt === 0 ? "none" : Number.isFinite(row.theory_w_dt) ? figure(row.theory_w_dt) : "no limit"}`;
  const beyond = row.beyond ? `beyond it: ${STABILITY_VERDICTS[row.beyond]?.[1] ?? row.beyond}` : "";
  const lines = [name, row.scene, limit, theory, beyond].filter(Boolean);
  return draw(
    "g",
    { "data-name": name, class: "limit", pointermove: (event) => (highlight(name), showTooltip(lines, event)), pointerleave: () => (highlight(""), showTooltip(null)) },
    draw("rect", { x: x - 7, y: y - 6, width: hides ? 24 : 14, height: 13, fill: "transparent" }),
    draw("path", { class: "point", transform: `translate(${x.toFixed(1)} ${y}) scale(4)`, d: CONTESTANTS.get(name).mark, ...inkOf(name) }),
    hides ? draw("path", { class: "silent", transform: `translate(${(x + 11).toFixed(1)} ${y}) scale(3.2)`, d: MARKS[2], fill: "var(--warn)" }) : "",
    numbered && positive(row.w_dt_limit) ? draw("text", { x: x + (hides ? 19 : 8), y: y + 4, fill: "var(--soft)", "font-size": FONT - 2 }, figure(row.w_dt_limit)) : "",
  );
}

/** The meaning of bars and triangles. */
function limitKey(x, y, drawn) {
  const hides = drawn.some((row) => row.beyond in SILENT_VERDICTS);
  return draw(
    "g",
    { "font-size": FONT - 0.5 },
    draw("line", { x1: x + 4, x2: x + 4, y1: y - 10, y2: y + 2, stroke: "var(--ink)", "stroke-width": 2.5, "stroke-opacity": 0.55 }),
    draw("text", { x: x + 12, y, fill: "var(--soft)" }, "theory"),
    hides ? draw("path", { transform: `translate(${x + 66} ${y - 4}) scale(3.2)`, d: MARKS[2], fill: "var(--warn)" }) : "",
    hides ? draw("text", { x: x + 74, y, fill: "var(--soft)" }, "wrong without an error message beyond it") : "",
  );
}

/** All maps, folded: to the right the step, upwards what makes the scene stiff; contestants with equal maps share one. */
function mapsFold(host) {
  const scenes = groupBy(rows("stability.csv"), (row) => row.scene);
  if (!scenes.size) return;
  const whole = [...scenes.values()].some((cells) => new Set(cells.map((row) => row.value)).size > 1);
  const fold = make("details", { class: "fold", id: "maps" }, make("summary", {}, "Maps: the result of each step in each stiff scene"));
  const fill = () => {
    if (!fold.open || fold.children.length > 1) return;
    const seen = new Set(rows("stability.csv").map((row) => row.verdict));
    fold.append(make("p", { class: "key" }, Object.entries(STABILITY_VERDICTS).filter(([word]) => seen.has(word)).map(([word, [sign, meaning]]) => make("span", {}, make("span", { class: `swatch s-${word}` }, sign || "\u00a0"), ` ${meaning}`))));
    const box = make("div", { class: whole ? "" : "multiples" });
    fold.append(box);
    for (const [scene, cells] of scenes) sceneMaps(box, scene, cells);
    if (!whole) fold.append(make("p", { class: "note" }, "Each scene is shown at its own stiffness. For maps over four decades of stiffness run ", make("code", {}, "tumble stability -o report/tumble-tables/stability"), ", then rebuild the page."));
  };
  fold.addEventListener("toggle", fill);
  host.append(fold);
  if (state.at.startsWith("map")) {
    fold.open = true;
    fill();
  }
}

/**
 * @param {Element} fold
 * @param {string} scene
 * @param {Tables["stability.csv"][]} cells
 */
function sceneMaps(fold, scene, cells) {
  const strips = new Set(cells.map((row) => row.value)).size === 1;
  const box = make("div", { class: "maps" });
  const title = rows("scenes.csv").find((row) => row.scene === scene)?.title ?? scene;
  fold.append(make("div", { id: `maps-${scene}`, class: "map-box" }, make("h3", {}, title), make("span", { class: "note" }, strips ? ` at ${cells[0].parameter.replace(" [", ` ${figure(cells[0].value, 2)} [`)}` : ` step by ${cells[0].parameter}`), box));
  const alike = new Map();
  for (const [name, own] of groupBy(cells, contestantOf)) {
    if (own.length < 2) continue; // it refused, or chooses its own steps: there is nothing to map
    const key = own.map((row) => `${row.value} ${row.dt_s} ${row.verdict}`).join();
    if (!alike.has(key)) alike.set(key, { names: [], own });
    alike.get(key).names.push(name);
  }
  const limits = new Map(rows("limits.csv").filter((row) => row.scene === scene).map((row) => [contestantOf(row), row]));
  follow(["show", "tol"], () => {
    const wanted = shown();
    const maps = [...alike.values()].map(({ names, own }) => ({ names: names.filter((name) => wanted.has(name)), own })).filter(({ names }) => names.length);
    if (!maps.length) box.replaceChildren(make("p", { class: "note" }, "No contestant shown has a map here: choose others above."));
    else if (strips) box.replaceChildren(stripsOf(scene, maps, limits));
    else box.replaceChildren(...maps.map(({ names, own }) => mapOf(names, own, limits.get(names[0]))));
  });
}

/** A scene at one value: a line per group of contestants, steps to the right, the theoretical limit as a bar. */
function stripsOf(scene, maps, limits) {
  const longest = Math.max(...maps.flatMap(({ own }) => own.map((row) => row.dt_s)));
  const column = (dt) => Math.log2(longest / dt);
  const wide = Math.max(...maps.flatMap(({ own }) => own.map((row) => Math.round(column(row.dt_s))))) + 1;
  const words = Math.max(...maps.map(({ names }) => names.join(", ").length)) * 6.2 + 12;
  const [width, height] = [wide * SIDE + words, maps.length * (SIDE + 4) + 16];
  const id = `map-${scene}`;
  const svg = draw("svg", { id, role: "img", viewBox: `0 0 ${width} ${height}`, width, "aria-label": `Stability in ${scene} by the step` });
  maps.forEach(({ names, own }, line) => {
    const y = line * (SIDE + 4);
    for (const row of own) svg.append(mapCell(row, names, (wide - 1 - Math.round(column(row.dt_s))) * SIDE, y, SIDE));
    const limit = limits.get(names[0]);
    if (limit && positive(limit.theory_w_dt)) {
      const x = (wide - 0.5 - column(limit.theory_w_dt / limit.w_rad_s)) * SIDE;
      if (x >= 0 && x <= wide * SIDE) svg.append(draw("path", { d: `M${x},${y - 1}V${y + SIDE}`, stroke: "var(--ink)", "stroke-width": 2.5 }));
    }
    svg.append(draw("text", { class: "beside", x: wide * SIDE + 8, y: y + SIDE - 3, "font-size": 11, fill: "var(--soft)" }, names.join(", ")));
  });
  svg.append(draw("text", { x: (wide * SIDE) / 2, y: height - 3, "text-anchor": "middle", "font-size": 10, fill: "var(--soft)" }, "larger steps →"));
  return make("figure", { class: "map" }, svg, figureTools(id, () => svg));
}

/**
 * One cell of a map, of that width, with its sign in the middle or at a place of its own.
 * @param {Tables["stability.csv"]} row
 */
function mapCell(row, names, x, y, width, middle = x + SIDE / 2) {
  return draw(
    "g",
    { pointermove: (event) => showTooltip([names.join(", "), `${row.parameter} ${figure(row.value)}, step ${figure(row.dt_s)} s`, STABILITY_VERDICTS[row.verdict]?.[1] ?? row.verdict, row.max_error_m === null ? "" : `error ${figure(row.max_error_m)} m`].filter(Boolean), event), pointerleave: () => showTooltip(null) },
    draw("rect", { x, y, width: width - 1, height: SIDE - 1, class: `s-${row.verdict}` }),
    draw("text", { x: middle - 0.5, y: y + SIDE - 4, "text-anchor": "middle", "font-size": 10, fill: "var(--ink)" }, STABILITY_VERDICTS[row.verdict]?.[0] ?? ""),
  );
}

/**
 * @param {string[]} names
 * @param {Tables["stability.csv"][]} cells
 * @param {Tables["limits.csv"] | undefined} limit
 */
function mapOf(names, cells, limit) {
  const values = [...new Set(cells.map((row) => row.value))].sort((a, b) => b - a);
  const longest = new Map(values.map((value) => [value, Math.max(...cells.filter((row) => row.value === value).map((row) => row.dt_s))]));
  const columns = (row) => Math.round(Math.log2((longest.get(row.value) ?? row.dt_s) / row.dt_s));
  const wide = Math.max(...cells.map(columns)) + 1;
  const broad = Math.max(wide * SIDE, 90);
  const id = `map-${cells[0].scene}-${names[0].replaceAll(":", "-")}`;
  const svg = draw("svg", { id, role: "img", viewBox: `-44 0 ${broad + 48} ${values.length * SIDE + 18}`, width: broad + 48, "aria-label": `Stability of ${names.join(", ")}` });
  const taken = new Map(values.map((value) => [value, cells.filter((row) => row.value === value).map(columns).sort((a, b) => a - b)]));
  for (const row of cells) {
    // Where few steps were run a cell reaches half way to its neighbours.
    const column = columns(row);
    const own = taken.get(row.value) ?? [];
    const at = own.indexOf(column);
    const later = at + 1 < own.length ? (own[at + 1] - column) / 2 : 0.5;
    const sooner = at > 0 ? (column - own[at - 1]) / 2 : 0.5;
    const [x, y, width] = [(wide - 0.5 - column - later) * SIDE, values.indexOf(row.value) * SIDE, (later + sooner) * SIDE];
    svg.append(mapCell(row, names, x, y, width, (wide - 0.5 - column) * SIDE));
  }
  values.forEach((value, at) => svg.append(draw("text", { x: -4, y: at * SIDE + SIDE - 4, "text-anchor": "end", "font-size": 9, fill: "var(--soft)" }, figure(value, 2))));
  if (limit && positive(limit.theory_w_dt)) {
    const own = cells.filter((row) => row.value === limit.value);
    const most = Math.max(...own.map((row) => row.dt_s)) * limit.w_rad_s;
    const x = (wide - 1 - Math.log2(most / limit.theory_w_dt)) * SIDE + SIDE / 2;
    svg.append(draw("path", { d: `M${x},0V${values.length * SIDE}`, stroke: "var(--ink)", "stroke-width": 2.5 }));
  }
  svg.append(draw("text", { x: (wide * SIDE) / 2, y: values.length * SIDE + 13, "text-anchor": "middle", "font-size": 10, fill: "var(--soft)" }, "larger steps →"));
  return make("figure", { class: "map" }, svg, make("figcaption", {}, names.join(", ")), figureTools(id, () => svg));
}

function limitTable(host) {
  const finest = new Map();
  for (const row of rows("stability.csv")) {
    const key = `${row.scene} ${nameOf(row)} ${row.value}`;
    finest.set(key, Math.min(row.dt_s, finest.get(key) ?? Infinity));
  }
  // Where even the smallest step tried is too large, only that bound is known.
  const within = (column) => (row) => row[column] ?? (row.w_dt_limit === null || row.note ? "" : `< ${figure(finest.get(`${row.scene} ${nameOf(row)} ${row.value}`))}`);
  foldedTable(host, {
    id: "limits",
    caption: "Largest stable and accurate steps in all stiff scenes",
    list: rows("limits.csv"),
    key: (row) => `${row.scene}-${nameOf(row)}`,
    columns: [
      { key: "method", label: "contestant", words: true, show: nameOf, sort: nameOf },
      { key: "scene", label: "scene", words: true },
      { key: "w_dt_limit", label: "largest stable ω·dt", show: (row) => figure(row.w_dt_limit) },
      { key: "theory_w_dt", label: "theory", show: (row) => figure(row.theory_w_dt) },
      { key: "beyond", label: "beyond the limit", words: true, show: (row) => STABILITY_VERDICTS[row.beyond]?.[1] ?? row.beyond },
      { key: "dt_stable_s", label: "stable up to", unit: "s" },
      { key: "dt_1pct_s", label: "within 1 %", unit: "s", show: within("dt_1pct_s") },
      { key: "dt_1mm_s", label: "within 1 mm", unit: "s", show: within("dt_1mm_s") },
      { key: "note", label: "", words: true },
    ],
  });
}
