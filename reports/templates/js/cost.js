// What accuracy costs: error against run time, and what it takes to reach an error.

import { chart } from "./chart.js";
import { cheapest, costInWords, settingOf, sweptScenes } from "./cheapest.js";
import { contestantOf, findings, groupBy, nameOf, rows } from "./data.js";
import { draw, make } from "./dom.js";
import { filmOf } from "./film.js";
import { chosen, counted, figure, interval, listed, positive, si, times } from "./numbers.js";
import { shown } from "./selection.js";
import { follow, state } from "./state.js";
import { foldedTable } from "./table.js";
import { statusInWords } from "./verdicts.js";

const MOST_ERROR = 10; // times the body's size: larger errors stand at the top of the chart

export function costSections(host) {
  for (const scene of sweptScenes()) costSection(host, scene);
}

function costSection(host, scene) {
  const runs = rows("sweep-work-precision.csv").filter((run) => run.scene === scene);
  const throws = rows("sweep-ensembles.csv").some((row) => row.scene === scene);
  const series = [...groupBy(runs, contestantOf)].map(([name, own]) => ({
    name,
    points: own.flatMap(costPoint).sort((a, b) => a.x - b.x),
  }));
  const limit = Math.max(...runs.map((run) => run.resolution_m ?? 0));
  const headline = make("p", { class: "headline" });
  host.append(headline);
  follow(["tol", "show"], () => headline.replaceChildren(...costHeadline(scene)));
  chart(host, {
    id: `cost-${scene}`,
    label: `Largest vertex error against run time of ${scene}`,
    x: { label: throws ? "run time of one throw, in the engine’s native loop" : "run time, in the engine’s native loop", log: true, show: (value) => si(value / 1e6, "s", 1) },
    y: { label: "largest vertex error", log: true, show: (value) => si(value, "m", 1) },
    series,
    limit: limit > 0 ? [{ x: Math.min(...runs.map((run) => run.run_us)), y: limit }] : [],
    under: (frame) => [...paretoFront(frame, runs), ...float32Floor(frame, scene), ...toleranceLine(frame)],
    height: 460,
    most: MOST_ERROR * (filmOf(scene)?.size ?? Infinity),
  });
  host.append(
    make("p", { class: "note" }, `Each point is one step or tolerance; crosses mark runs that were flagged or failed. The broad grey line is the Pareto front: no contestant, shown or hidden, is both faster and more accurate. Bars extend to the 90th percentile of the run times. The grey area at the bottom is the resolution of the truth. Errors above ten times the body’s size stand at the top. Repeat: `, make("code", {}, `tumble sweep ${scene}`)),
  );
  worseBelowNote(host, scene);
  costTable(host, scene);
  orderTable(host, scene);
}

/**
 * The point of a run, none where there is no error to draw.
 * @param {Tables["sweep-work-precision.csv"]} run
 * @returns {ChartPoint[]}
 */
function costPoint(run) {
  const { error_m: error, run_us: time } = run;
  if (!positive(error)) return [];
  const lines = [settingOf(run), error <= (run.resolution_m ?? 0) ? `≤ ${figure(run.resolution_m)} m` : `${figure(error)} m`, `${figure(time)} µs a run`];
  if (run.steps) lines.push(`${counted(run.steps, "step")} of ${figure(run.step_ns)} ns`);
  if (run.status !== "ok") lines.push(statusInWords(run));
  return [{ x: time, y: error, plain: run.status === "ok", lines, low: time, high: run.p90_run_us }];
}

/** The Pareto front: no contestant, shown or hidden, is both faster and more accurate. */
function paretoFront({ X, Y, area }, runs) {
  const front = runs.filter((run) => run.pareto_front && run.error_m > 0).sort((a, b) => a.run_us - b.run_us);
  if (front.length < 2) return [];
  let path = `M${X.place(front[0].run_us)},${area.top}`;
  for (const run of front) path += `H${X.place(run.run_us).toFixed(1)}V${Y.place(run.error_m).toFixed(1)}`;
  return [draw("path", { d: `${path}H${area.right}`, fill: "none", stroke: "var(--ink)", "stroke-opacity": 0.13, "stroke-width": 7 })];
}

/** Where single precision ends: its rounding of the largest coordinate. */
function float32Floor({ Y, area }, scene) {
  return findings("coordinate rounding", scene).map((row) => level(Y, area, row.value, "rounding of float32"));
}

function toleranceLine({ Y, area }) {
  return [level(Y, area, state.tol, `acceptable: ${chosen(state.tol, "m")}`)];
}

function level(Y, area, value, words) {
  const at = Y.place(value);
  if (!(at > area.top && at < area.bottom)) return draw("g");
  return draw(
    "g",
    {},
    draw("line", { x1: area.left, x2: area.right, y1: at, y2: at, stroke: "var(--warn)", "stroke-dasharray": "4 4" }),
    draw("text", { x: area.left + 4, y: at - 4, fill: "var(--warn)", "font-size": 11 }, words),
  );
}

/** The fastest and the slowest contestant that reach the tolerance, of all and not only of those shown. */
function costHeadline(scene) {
  const reaching = cheapest(state.tol, scene);
  const tolerance = chosen(state.tol, "m");
  if (!reaching.length) return [`No contestant reaches ${tolerance}.`];
  const [first, last] = [reaching[0], reaching[reaching.length - 1]];
  const parts = [`${counted(reaching.length, "contestant")} reach${reaching.length === 1 ? "es" : ""} ${tolerance}: `, make("b", {}, first.name), ` is the fastest${costInWords(first)}`];
  if (reaching.length > 1) parts.push(`, ${last.name} the slowest${costInWords(last)}`);
  const hidden = [first, last].filter(({ name }, at, both) => !shown().has(name) && both.findIndex((one) => one.name === name) === at).map(({ name }) => name);
  return [...parts, hidden.length ? `; ${listed(hidden)} ${hidden.length > 1 ? "are" : "is"} not shown.` : "."];
}

function costTable(host, scene) {
  const targets = [...new Set(rows("sweep-accuracy-cost.csv").map((row) => row.target_m))];
  foldedTable(host, {
    id: `digits-${scene}`,
    caption: `Cost of an error of ${listed(targets.map((target) => si(target, "m", 1)))} in ${scene}`,
    list: rows("sweep-accuracy-cost.csv").filter((row) => row.scene === scene),
    key: (row) => `${nameOf(row)}-${row.target_m}`,
    columns: [
      { key: "method", label: "contestant", words: true, show: nameOf, sort: nameOf },
      { key: "target_m", label: "target error", show: (row) => si(row.target_m, "m", 1) },
      { key: "verdict", label: "", words: true },
      { key: "run_us", label: "run time", unit: "µs" },
      { key: "dt_s", label: "step", unit: "s" },
      { key: "dt_taken_s", label: "step taken", unit: "s" },
      { key: "steps_per_s", label: "steps per second" },
      { key: "ratio", label: "ratio to reference", show: (row) => times(row.ratio) },
      { key: "ratio_low", label: "95 % interval", words: true, show: (row) => interval(row.ratio_low, row.ratio_high) },
    ],
  });
}

function orderTable(host, scene) {
  foldedTable(host, {
    id: `orders-${scene}`,
    caption: `Convergence order of each method in ${scene}, and the step of its least error`,
    list: rows("sweep-orders.csv").filter((row) => row.scene === scene),
    key: (row) => nameOf(row),
    columns: [
      { key: "method", label: "contestant", words: true, show: nameOf, sort: nameOf },
      { key: "order", label: "order", show: (row) => (row.order === null ? "" : row.order.toFixed(2)) },
      { key: "order_low", label: "lowest", show: (row) => (row.order_low === null ? "" : row.order_low.toFixed(2)) },
      { key: "order_high", label: "highest", show: (row) => (row.order_high === null ? "" : row.order_high.toFixed(2)) },
      { key: "best_error_m", label: "least error", unit: "m" },
      { key: "best_dt_s", label: "at step", unit: "s" },
      { key: "attitude_m", label: "from attitude", unit: "m" },
      { key: "translation_m", label: "from translation", unit: "m" },
    ],
  });
}

/** The contestants shown whose errors grow below a step, with that step. */
function worseBelowNote(host, scene) {
  const found = findings("optimal step", scene);
  if (!found.length) return;
  const reached = new Map(rows("sweep-orders.csv").filter((row) => row.scene === scene).map((row) => [nameOf(row), row]));
  const note = make("p", { class: "note", id: `worse-below-${scene}` });
  host.append(note);
  follow(["show"], () => {
    const names = shown();
    const own = found.filter((row) => names.has(nameOf(row)));
    note.replaceChildren(own.length ? `Smaller steps increase the error of ${own.map((row) => worseBelowInWords(row, reached.get(nameOf(row)))).join("; ")}.` : "");
  });
}

function worseBelowInWords(found, row) {
  const single = row.precision === "single" ? ", in single precision," : "";
  return `${nameOf(found)}${single} below ${si(found.value, "s")}, from ${si(row.best_error_m, "m")} to ${si(row.finest_error_m, "m")} at ${si(row.finest_dt_s, "s")}`;
}
