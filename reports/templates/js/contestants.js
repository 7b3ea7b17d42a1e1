// The contestants: one colour and one mark each in every figure, their scores and defaults.

import { DATA, contestantOf, errorOf, findings, groupBy, rows } from "./data.js";
import { draw, make, styleOf } from "./dom.js";
import { state } from "./state.js";

// Okabe and Ito's colours, which colour-blind readers can distinguish; DATA.places assigns them, the same on every page.
const HUES = ["--hue-1", "--hue-2", "--hue-3", "--hue-4", "--hue-5", "--hue-6"];

// In units about the origin.  The contestants of an engine differ in their marks, so that colour is never the only sign.
export const MARKS = [
  "M-1,0A1,1,0,1,1,1,0A1,1,0,1,1,-1,0Z",
  "M-.9,-.9L.9,-.9L.9,.9L-.9,.9Z",
  "M0,-1.15L1.1,.85L-1.1,.85Z",
  "M0,-1.3L1.1,0L0,1.3L-1.1,0Z",
  "M0,1.15L1.1,-.85L-1.1,-.85Z",
  "M-.35,-1.1L.35,-1.1L.35,-.35L1.1,-.35L1.1,.35L.35,.35L.35,1.1L-.35,1.1L-.35,.35L-1.1,.35L-1.1,-.35L-.35,-.35Z",
];

export const CROSS = "M-1,-1L1,1M-1,1L1,-1";
const DASHES = ["", "7 3", "2 3", "9 3 2 3", "5 2 5 2 1 2", "1 2"];

/** Every contestant of any table, by name: engine, method, variant (tuned, defaults, held), colour, mark and dash. */
export const CONTESTANTS = allContestants();

function allContestants() {
  const found = new Map();
  const counts = new Map();
  for (const row of [...rows("runs.csv"), ...rows("sweep-runs.csv"), ...rows("limits.csv"), ...rows("extremes.csv"), ...rows("contact.csv"), ...rows("releases.csv")]) {
    const name = contestantOf(row);
    if (!row.method || found.has(name)) continue;
    const at = counts.get(row.engine) ?? 0;
    counts.set(row.engine, at + 1);
    const method = row.method.split("@")[0];
    const [plain, variant] = method.split("+");
    const place = DATA.places[row.engine] ?? 0;
    found.set(name, {
      name,
      engine: row.engine,
      method,
      plain,
      variant: variant ?? "tuned",
      ours: row.engine === DATA.ours,
      byHand: row.engine === DATA.byHand,
      hue: row.engine === DATA.byHand ? "--soft" : HUES[place % HUES.length],
      round: Math.max(0, Math.floor(place / HUES.length)),
      mark: MARKS[at % MARKS.length],
      dash: DASHES[at % DASHES.length],
    });
  }
  return found;
}

/** A name that can be wrapped after its engine. */
export function brokenName(name) {
  const [engine, ...rest] = name.split(":");
  return rest.length ? [`${engine}:`, make("wbr"), rest.join(":")] : [name];
}

export function colourOf(name) {
  return styleOf(CONTESTANTS.get(name)?.hue ?? "--soft");
}

/** How a mark is filled: engines that share a colour differ in this. */
export function inkOf(name) {
  const one = CONTESTANTS.get(name);
  const hue = `var(${one?.hue ?? "--soft"})`;
  const edge = { stroke: hue, "stroke-width": 0.5 };
  return [{ fill: hue }, { fill: "var(--paper)", ...edge }, { fill: hue, "fill-opacity": 0.4, ...edge }][Math.min(one?.round ?? 0, 2)];
}

/**
 * A contestant's mark as a small picture.
 * @param {string} name
 */
export function markOf(name, size = 12) {
  const one = CONTESTANTS.get(name);
  return draw(
    "svg",
    { viewBox: "-1.6 -1.6 3.2 3.2", width: size, height: size, class: "mark", "aria-hidden": "true" },
    draw("path", { d: one?.mark ?? MARKS[0], ...inkOf(name) }),
  );
}

/** The contestant that is an engine's default, by engine. */
export const ENGINE_DEFAULTS = new Map(findings("engine default").filter((row) => CONTESTANTS.has(contestantOf(row))).map((row) => [row.engine, contestantOf(row)]));

/** The contestants that the user named. */
export const REQUESTED = new Set(findings("named method").map(contestantOf));

/** An engine's default, or its first contestant where it has no default. */
export const defaultOf = (engine) => ENGINE_DEFAULTS.get(engine) ?? [...CONTESTANTS.values()].find((one) => one.engine === engine && RUNS.has(one.name))?.name;
export const RUNS = groupBy(rows("runs.csv"), contestantOf);

/**
 * In how many scenes a contestant's error is within the tolerance, of how many, and its mean log10 error.
 * @param {string} name
 * @param {number} tolerance
 */
export function scoreOf(name, tolerance) {
  let within = 0;
  let count = 0;
  let digits = 0;
  for (const run of RUNS.get(name) ?? []) {
    const error = errorOf(run);
    if (run.status === "skipped" || run.status === "missing") continue;
    count += 1;
    if (error === null || !Number.isFinite(error)) continue;
    digits += Math.log10(Math.max(error, 1e-18));
    if (run.status === "ok" && error <= tolerance) within += 1;
  }
  return { within, count, digits: count ? digits / count : 0 };
}

/**
 * An engine's best contestant: within the tolerance in most scenes, then of the smallest errors; null where none ran.
 * @param {string} engine
 * @param {number} tolerance
 */
export function bestOf(engine, tolerance) {
  const own = [...CONTESTANTS.values()].filter((one) => one.engine === engine && one.variant === "tuned" && !one.byHand);
  const ranked = own
    .map((one) => ({ name: one.name, ...scoreOf(one.name, tolerance) }))
    .filter((one) => one.count)
    .sort((a, b) => b.within - a.within || a.digits - b.digits);
  return ranked[0]?.name ?? null;
}

/**
 * What a contestant is for its engine.
 * @param {string} name
 */
export function rolesOf(name) {
  const { engine, variant, byHand } = CONTESTANTS.get(name);
  if (byHand) return "";
  const roles = [];
  if (ENGINE_DEFAULTS.get(engine) === name) roles.push(variant === "defaults" ? "default settings" : "default method");
  if (REQUESTED.has(name)) roles.push("requested");
  if (bestOf(engine, state.tol) === name) roles.push("best of its engine");
  return roles.join(", ");
}

/** The findings on the defaults of all engines in a scene, or on requested contestants of engines without a default. */
export function defaultFindings(scene) {
  return [...findings("engine default", scene), ...findings("first method", scene).filter((row) => row.engine !== DATA.byHand && !ENGINE_DEFAULTS.has(row.engine))];
}
