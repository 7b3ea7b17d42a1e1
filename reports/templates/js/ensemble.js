// Very many throws of a scene that ran in parts: how the errors of a contestant are spread, up to the rarest.

import { chart } from "./chart.js";
import { contestantOf, rows } from "./data.js";
import { draw, make } from "./dom.js";
import { counted, figure, finite, si } from "./numbers.js";
import { foldedTable } from "./table.js";

// Column, and one throw in how many has a larger error.
const QUANTILES = /** @type {const} */ ([
  ["p1_error_m", 1 / 0.99],
  ["p5_error_m", 1 / 0.95],
  ["p25_error_m", 1 / 0.75],
  ["median_error_m", 2],
  ["p75_error_m", 4],
  ["p95_error_m", 20],
  ["p99_error_m", 100],
  ["p99_9_error_m", 1e3],
  ["p99_99_error_m", 1e4],
  ["p99_9999_error_m", 1e6],
]);

/**
 * Append the figure and the table of a scene's throws, where it ran in parts.
 * @param {Element} host
 * @param {string} scene
 */
export function ensembleFigure(host, scene) {
  const spreads = rows("ensemble-errors.csv").filter((row) => row.scene === scene && finite(row.median_error_m));
  if (!spreads.length) return;
  const throws = Math.max(...spreads.map((row) => row.members));
  const graph = make("div", { class: "throws" }, make("h4", {}, `The errors of ${counted(throws, "throw")}`));
  host.append(graph);
  chart(graph, {
    id: `throws-${scene}`,
    label: `Largest vertex error of a throw in ${scene} against how rare it is, metres`,
    x: { label: "one throw in n has a larger error", log: true, show: (value) => si(value, "", 1) },
    y: { label: "largest vertex error", log: true, show: (value) => si(value, "m", 1) },
    series: spreads.map((row) => ({ name: contestantOf(row), points: pointsOf(row) })),
    under: band,
  });
  graph.append(make("p", { class: "note" }, `In the grey band are 90 % of the throws; to its right is the tail, up to the largest error of all. Each quantile is within ${figure(100 * (spreads[0].quantile_error ?? 0), 1)} % of its value.`));
  foldedTable(host, {
    id: `throws-table-${scene}`,
    caption: `Quantiles of the largest vertex error over ${counted(throws, "throw")}`,
    list: spreads,
    key: contestantOf,
    columns: [
      { key: "engine", label: "contestant", words: true, show: contestantOf, sort: contestantOf },
      { key: "p5_error_m", label: "5 %", unit: "m" },
      { key: "median_error_m", label: "median", unit: "m" },
      { key: "p95_error_m", label: "95 %", unit: "m" },
      { key: "p99_9_error_m", label: "99.9 %", unit: "m" },
      { key: "p99_99_error_m", label: "99.99 %", unit: "m" },
      { key: "max_error_m", label: "largest", unit: "m" },
      { key: "lost", label: "diverged" },
      { key: "unknown", label: "without a truth" },
    ],
  });
}

/** Where 90 % of the throws are: the 5th to the 95th percentile. */
function band({ X, area }) {
  const [left, right] = [X.place(1 / 0.95), X.place(20)];
  return [draw("rect", { x: left, y: area.top, width: right - left, height: area.bottom - area.top, fill: "var(--ink)", "fill-opacity": 0.05 })];
}

/**
 * The errors of a contestant by their rarity; none rarer than one of all its throws, which is the largest.
 * @param {Tables["ensemble-errors.csv"]} row
 * @returns {ChartPoint[]}
 */
function pointsOf(row) {
  const known = row.members - row.unknown;
  const all = [...QUANTILES.filter(([, rarity]) => rarity < known).map(([column, rarity]) => ({ x: rarity, y: row[column] })), { x: known, y: row.max_error_m }];
  return all.flatMap(({ x, y }) => (y !== null && y > 0 && Number.isFinite(y) ? [{ x, y, plain: row.status === "ok", lines: [`1 in ${figure(x)} throws`, `more than ${figure(y)} m`] }] : []));
}
