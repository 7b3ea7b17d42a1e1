// One folded section per scene: the die in flight, its errors, and what a free body conserves.

import { chart } from "./chart.js";
import { ENGINE_DEFAULTS, REQUESTED, defaultFindings } from "./contestants.js";
import { DATA, contestantOf, findingValue, findings, groupBy, nameOf, rows } from "./data.js";
import { draw, make, reducedMotion } from "./dom.js";
import { ensembleFigure } from "./ensemble.js";
import { filmOf } from "./film.js";
import { headlineOf } from "./headlines.js";
import { THIN, counted, figure, finite, given, si, superscript } from "./numbers.js";
import { clockOf, player } from "./player.js";
import { polhode } from "./polhode.js";
import { shown } from "./selection.js";
import { sensorFold } from "./sensors.js";
import { choose, state } from "./state.js";
import { foldedTable } from "./table.js";
import { statusInWords } from "./verdicts.js";

export function openScene(event, scene) {
  event.preventDefault();
  const fold = /** @type {HTMLDetailsElement} */ (document.getElementById(`scene-${scene}`));
  fold.open = true;
  choose({ at: `scene-${scene}` });
  fold.scrollIntoView({ block: "start", behavior: reducedMotion.matches ? "auto" : "smooth" });
}

export function sceneSections(host) {
  for (const scene of rows("scenes.csv")) sceneSection(host, scene);
}

/**
 * @param {Element} host
 * @param {Tables["scenes.csv"]} scene
 */
function sceneSection(host, scene) {
  const id = `scene-${scene.scene}`;
  const runs = rows("runs.csv").filter((run) => run.scene === scene.scene);
  const fold = make(
    "details",
    { class: "scene", id },
    make("summary", {}, make("h3", {}, scene.title || scene.scene), make("span", { class: "headline" }, headlineOf(scene.scene) || sceneHeadline(scene))),
  );
  const body = make("div", { class: "scene-body" });
  fold.append(body);
  host.append(fold);
  const fill = () => {
    if (fold.open && !body.hasChildNodes()) fillScene(body, scene, runs);
  };
  fold.addEventListener("toggle", () => {
    const open = new Set(state.open);
    fold.open ? open.add(scene.scene) : open.delete(scene.scene);
    choose({ open: [...open] });
    fill();
  });
  // The place of an address must exist when the reader arrives.
  fold.open = state.open.includes(scene.scene) || state.at === id;
  fill();
}

/**
 * The least accurate default, or requested contestant, and the most accurate engine.
 * @param {Tables["scenes.csv"]} scene
 */
function sceneHeadline(scene) {
  if (!findings("most accurate", scene.scene).length) return scene.bound_m === null ? `No truth: ${scene.truth}` : "No contestant finished.";
  const first = defaultFindings(scene.scene).filter((row) => row.engine !== DATA.ours && Number.isFinite(findingValue(row)) && row.value !== null);
  const [worst] = first.sort((a, b) => (findingValue(b) ?? 0) - (findingValue(a) ?? 0));
  const clauses = [];
  if (worst) clauses.push(`${ENGINE_DEFAULTS.has(worst.engine) ? `By default ${worst.engine}` : `${REQUESTED.has(contestantOf(worst)) ? "As requested, " : ""}${contestantOf(worst)}`} has an error of up to ${si(findingValue(worst), "m", 2)}`);
  for (const row of findings("most accurate engine", scene.scene)) clauses.push(`the most accurate engine, ${contestantOf(row)}, of ${si(findingValue(row), "m", 2)}`);
  return `${clauses.join("; ")}${clauses.length ? "." : ""}`;
}

/**
 * @param {Element} body
 * @param {Tables["scenes.csv"]} scene
 * @param {Tables["runs.csv"][]} runs
 */
function fillScene(body, scene, runs) {
  const name = scene.scene;
  const film = filmOf(name);
  const ghosts = () => (film ? [...shown()].filter((one) => film.runs.has(one)) : []);
  const clock = film && clockOf(film);
  body.append(make("p", { class: "note" }, sceneHeadline(scene)));
  const cursor = clock && { get: () => clock.time, set: (time) => clock.choose(time) };
  if (film) {
    const show = make("div", { class: "flight" });
    body.append(show);
    player(show, film, { ghosts, id: `flight-${name}`, label: `The body of ${name} in flight: the truth solid, contestants as frames in their colours` });
  }
  const graph = make("div", { class: "graph" });
  body.append(graph);
  const made = [];
  const error = errorSeries(film, name, runs);
  if (error.some((one) => one.points.length)) {
    made.push(
      chart(graph, {
        id: `error-${name}`,
        label: `Largest vertex error over time in ${name}, metres`,
        x: { label: "time [s]", show: given },
        y: { label: "largest vertex error", log: true, show: (value) => si(value, "m", 1) },
        series: error,
        limit: limitOf(film, name),
        range: scene.horizon_s === null ? null : [0, scene.duration_s],
        under: (frame) => horizonLine(frame, scene.horizon_s),
        cursor,
      }),
    );
  }
  if (film) {
    const small = make("div", { class: "small-charts" });
    body.append(small);
    for (const [at, what] of ["energy", "angular momentum"].entries()) {
      const series = driftSeries(film, runs, 8 + at);
      if (!series.some((one) => one.points.length)) continue;
      made.push(
        chart(small, {
          id: `${what.replace(" ", "-")}-${name}`,
          label: `Drift of ${what} in ${name}, relative`,
          x: { label: "time [s]", show: given },
          y: { label: `drift of ${what}`, log: true, show: (value) => (value >= 1e-3 && value < 10 ? `${figure(100 * value, 1)}${THIN}%` : `10${superscript(Math.round(Math.log10(value)))}`) },
          series,
          cursor,
          height: 220,
        }),
      );
    }
    // The ellipsoid is that of a body that no force turns.
    if (!/plane/.test(scene.needs)) polhode(small, film, ghosts);
    for (const each of made) clock.followers.add(each.moveCursor);
  }
  ensembleFigure(body, name);
  body.append(factsOf(scene, runs));
  runTable(body, name, runs);
  vertexTable(body, name);
  sensorFold(body, name);
}

/** The predictability horizon, where the scene has one. */
function horizonLine({ X, area }, time) {
  if (time === null) return [];
  const at = X.place(time);
  return [
    draw("rect", { class: "horizon", x: at, y: area.top, width: area.right - at, height: area.bottom - area.top, fill: "var(--ink)", "fill-opacity": 0.05 }),
    draw("line", { x1: at, x2: at, y1: area.top, y2: area.bottom, stroke: "var(--warn)", "stroke-dasharray": "6 3" }),
    draw("text", { x: at - 5, y: area.top + 12, "text-anchor": "end", fill: "var(--warn)", "font-size": 11 }, `horizon, ${given(time)} s: beyond it no program in double precision can predict the motion`),
  ];
}

function errorTooltip(time, error, limit) {
  return [`t = ${given(time)} s`, error <= limit ? `≤ ${figure(limit)} m, the resolution of the truth` : `${figure(error)} m`];
}

/**
 * The errors of all contestants over time: from the film where there is one, else at the scene's samples.
 * @param {Film | null} film
 * @param {string} scene
 * @param {Tables["runs.csv"][]} runs
 */
function errorSeries(film, scene, runs) {
  const plain = new Map(runs.map((run) => [contestantOf(run), run.status === "ok"]));
  if (!film) {
    return [...groupBy(rows("error-over-time.csv").filter((row) => row.scene === scene), contestantOf)].map(([name, own]) => ({
      name,
      points: own.flatMap(({ t_s: x, error_m: error, resolution_m: limit }) => (finite(error) ? [{ x, y: Math.max(error, limit), plain: plain.get(name) ?? true, lines: errorTooltip(x, error, limit) }] : [])),
    }));
  }
  return [...film.runs].map(([name, one]) => ({
    name,
    points: one.frames
      .map((frame, at) => ({ x: film.t[at], y: Math.max(frame[7], film.limit[at]), plain: plain.get(name) ?? true, lines: errorTooltip(film.t[at], frame[7], film.limit[at]) }))
      .filter((point) => point.y > 0 && Number.isFinite(point.y)),
  }));
}

/**
 * @param {Film | null} film
 * @param {string} scene
 */
function limitOf(film, scene) {
  const found = film ? film.t.map((x, at) => ({ x, y: film.limit[at] })) : [...new Map(rows("error-over-time.csv").filter((row) => row.scene === scene).map((row) => [row.t_s, { x: row.t_s, y: row.resolution_m }])).values()];
  return found.filter((point) => point.y > 0);
}

/**
 * The relative drift of what a free body conserves.
 * @param {Film} film
 * @param {Tables["runs.csv"][]} runs
 * @param {number} column
 */
function driftSeries(film, runs, column) {
  const plain = new Map(runs.map((run) => [contestantOf(run), run.status === "ok"]));
  return [...film.runs].map(([name, one]) => ({
    name,
    points: one.frames
      .map((frame, at) => ({ x: film.t[at], y: Math.max(Math.abs(frame[column]), 1e-17), plain: plain.get(name) ?? true, lines: [`t = ${given(film.t[at])} s`, `relative drift ${figure(frame[column])}`] }))
      .filter((point) => point.x > 0 && Number.isFinite(point.y)),
  }));
}

/**
 * @param {Tables["scenes.csv"]} scene
 * @param {Tables["runs.csv"][]} runs
 */
function factsOf(scene, runs) {
  const steps = [...groupBy(runs.filter((run) => run.dt_s), (run) => run.dt_s ?? 0)].sort(([a], [b]) => a - b).map(([step, own]) => stepInWords(step, own));
  const facts = [
    ["source", scene.source],
    ["needs", scene.needs],
    ["flight", `${given(scene.duration_s)} s, errors measured at ${counted(scene.samples, "instant")}, step ${steps.join(" and ")}`],
    ["truth", scene.bound_m === null ? `none: ${scene.truth}` : `${scene.truth}; its own error is at most ${figure(scene.bound_m, 2)} m, and rounding the inputs to double precision moves a vertex by up to ${figure(scene.input_error_m, 2)} m`],
    ["repeat", make("code", {}, `tumble compare ${scene.scene}`)],
  ];
  return make("dl", { class: "facts" }, facts.filter(([, value]) => value).map(([what, value]) => make("div", {}, make("dt", {}, what), make("dd", {}, value))));
}

/**
 * The requested step, and the step taken where samples and impulses cut the run.
 * @param {number} step
 * @param {Tables["runs.csv"][]} runs
 */
function stepInWords(step, runs) {
  const taken = runs.map((run) => run.dt_taken_s).find(Boolean) ?? step;
  return taken === step ? `${given(step)} s` : `${given(step)} s (${figure(taken, 4)} s taken, because samples cut the run)`;
}

/**
 * @param {number | null} value
 * @param {number | null} limit
 */
function metres(value, limit) {
  if (value === null) return "";
  return value <= (limit ?? 0) ? `≤ ${figure(limit)}` : figure(value);
}

/**
 * @param {Element} body
 * @param {string} scene
 * @param {Tables["runs.csv"][]} runs
 */
function runTable(body, scene, runs) {
  foldedTable(body, {
    id: `runs-${scene}`,
    caption: `All runs of ${scene}`,
    list: runs,
    key: (run) => nameOf(run),
    columns: [
      { key: "method", label: "contestant", words: true, show: (run) => nameOf(run), sort: nameOf },
      { key: "status", label: "result", words: true, show: (run) => statusInWords(run) },
      { key: "max_error_m", label: "largest error", unit: "m", show: (run) => metres(run.max_error_m, run.resolution_m) },
      { key: "rms_error_m", label: "rms", unit: "m", show: (run) => metres(run.rms_error_m, run.resolution_m) },
      { key: "final_error_m", label: "at the end", unit: "m", show: (run) => metres(run.final_error_m, run.resolution_m) },
      { key: "energy_drift", label: "energy drift", unit: "relative", show: (run) => figure(run.energy_drift, 2) },
      { key: "angular_momentum_drift", label: "angular momentum drift", unit: "relative", show: (run) => figure(run.angular_momentum_drift, 2) },
      { key: "wall_ns_per_step", label: "time per step, one pass", unit: "ns", show: (run) => figure(run.wall_ns_per_step, 3) },
    ],
  });
}

function vertexTable(body, scene) {
  const list = rows("vertex-errors.csv").filter((row) => row.scene === scene);
  if (!list.length) return;
  foldedTable(body, {
    id: `vertices-${scene}`,
    caption: `Error at each vertex at the end of ${scene}`,
    list,
    key: (row) => `${nameOf(row)}-${row.vertex}`,
    columns: [
      { key: "method", label: "contestant", words: true, show: nameOf, sort: nameOf },
      { key: "vertex", label: "vertex", show: (row) => String(row.vertex) },
      { key: "true_x_m", label: "true position", unit: "m", words: true, show: (row) => [row.true_x_m, row.true_y_m, row.true_z_m].map((value) => figure(value)).join(", ") },
      { key: "x_m", label: "its position", unit: "m", words: true, show: (row) => [row.x_m, row.y_m, row.z_m].map((value) => figure(value)).join(", ") },
      { key: "error_m", label: "error", unit: "m" },
    ],
  });
}
