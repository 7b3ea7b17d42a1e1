// Who takes part: one colour and one mark each on every figure, and who of them is shown.

import { DATA, contestantOf, errorOf, findings, groupBy, rows } from "./data.js";
import { draw, make, styleOf } from "./dom.js";
import { state } from "./state.js";

/**
 * What a contestant is to its engine.
 * @param {string} name
 */
export function rolesOf(name) {
  const { engine, manner, byHand } = CONTESTANTS.get(name);
  if (byHand) return "";
  const roles = [];
  if (ENGINE_DEFAULTS.get(engine) === name) roles.push(manner === "defaults" ? "as it ships" : "its default");
  if (REQUESTED.has(name)) roles.push("as asked");
  if (bestOf(engine, state.tol) === name) roles.push("its best");
  return roles.join(", ");
}

/** What engines did in a scene by default, and of those that took part only as asked what they did so. */
export function defaultFindings(scene) {
  return [...findings("as shipped", scene), ...findings("asked for", scene).filter((row) => row.engine !== DATA.byHand && !ENGINE_DEFAULTS.has(row.engine))];
}

// Okabe and Ito's colours, told apart by colour-blind readers; DATA.places says which is whose, on every page the same.
const HUES = ["--hue-1", "--hue-2", "--hue-3", "--hue-4", "--hue-5", "--hue-6"];

// Units about the origin; a contestant's mark is its own within its engine, so colour is never all.
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

/** Everybody in any table, by name: engine, method, manner (tuned, defaults, held), colour, mark and dash. */
export const CONTESTANTS = allContestants();

function allContestants() {
  const found = new Map();
  const counts = new Map();
  for (const row of [...rows("runs.csv"), ...rows("sweep-runs.csv"), ...rows("limits.csv"), ...rows("extremes.csv"), ...rows("releases.csv")]) {
    const name = contestantOf(row);
    if (!row.method || found.has(name)) continue;
    const at = counts.get(row.engine) ?? 0;
    counts.set(row.engine, at + 1);
    const method = row.method.split("@")[0];
    const [plain, manner] = method.split("+");
    const place = DATA.places[row.engine] ?? 0;
    found.set(name, {
      name,
      engine: row.engine,
      method,
      plain,
      manner: manner ?? "tuned",
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

/** A name that may be broken after its engine. */
export function brokenName(name) {
  const [engine, ...rest] = name.split(":");
  return rest.length ? [`${engine}:`, make("wbr"), rest.join(":")] : [name];
}

export function colourOf(name) {
  return styleOf(CONTESTANTS.get(name)?.hue ?? "--soft");
}

/** How a mark is filled: there are more engines than colours, and those that share one differ in this. */
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

/** What an engine does where its user sets nothing, by engine; of those that took part so. */
export const ENGINE_DEFAULTS = new Map(findings("as shipped").filter((row) => CONTESTANTS.has(contestantOf(row))).map((row) => [row.engine, contestantOf(row)]));

/** Who took part because the user named them. */
export const REQUESTED = new Set(findings("as asked").map(contestantOf));

/** Its default, or, of an engine without one, its first contestant. */
export const defaultOf = (engine) => ENGINE_DEFAULTS.get(engine) ?? [...CONTESTANTS.values()].find((one) => one.engine === engine && RUNS.has(one.name))?.name;
export const RUNS = groupBy(rows("runs.csv"), contestantOf);

/**
 * How many scenes a contestant finished within the tolerance, and the sum of its errors' digits.
 * @param {string} name
 * @param {number} tolerance
 */
export function scoreOf(name, tolerance) {
  let within = 0;
  let flown = 0;
  let digits = 0;
  for (const run of RUNS.get(name) ?? []) {
    const error = errorOf(run);
    if (run.status === "skipped" || run.status === "missing") continue;
    flown += 1;
    if (error === null || !Number.isFinite(error)) continue;
    digits += Math.log10(Math.max(error, 1e-18));
    if (run.status === "ok" && error <= tolerance) within += 1;
  }
  return { within, flown, digits: flown ? digits / flown : 0 };
}

/**
 * An engine's best: within the tolerance in most scenes, of those the one of smallest errors; null if none flew.
 * @param {string} engine
 * @param {number} tolerance
 */
export function bestOf(engine, tolerance) {
  const own = [...CONTESTANTS.values()].filter((one) => one.engine === engine && one.manner === "tuned" && !one.byHand);
  const ranked = own
    .map((one) => ({ name: one.name, ...scoreOf(one.name, tolerance) }))
    .filter((one) => one.flown)
    .sort((a, b) => b.within - a.within || a.digits - b.digits);
  return ranked[0]?.name ?? null;
}
