// The headline of each scene: of all facts about it, the two that fewest other scenes share.

import { CONTESTANTS, RUNS } from "./contestants.js";
import { contestantOf, errorOf, findingValue, findings, groupBy, nameOf, numbersFound, rows } from "./data.js";
import { filmOf } from "./film.js";
import { counted, figure, given, listed, si } from "./numbers.js";
import { state } from "./state.js";
import { verdictOf } from "./verdicts.js";

let headlines = null;

/** The headline of a scene; '' where no fact stands out. */
export function headlineOf(scene) {
  headlines ??= allHeadlines();
  return headlines.get(scene) ?? "";
}

function allHeadlines() {
  const scenes = rows("scenes.csv");
  const runs = groupBy(rows("runs.csv"), (run) => run.scene);
  const facts = new Map(scenes.map((scene) => [scene.scene, factsAbout(scene, (runs.get(scene.scene) ?? []).filter((run) => !CONTESTANTS.get(contestantOf(run))?.byHand))]));
  for (const one of SUPERLATIVES) addSuperlative(facts, scenes, runs, one);
  const shared = new Map();
  for (const own of facts.values()) for (const { key } of own) shared.set(key, (shared.get(key) ?? 0) + 1);
  return new Map([...facts].map(([scene, own]) => [scene, inOneSentence(own, shared)]));
}

/** The two rarest facts of a scene, of different kinds. */
function inOneSentence(own, shared) {
  const ranked = own.map((fact, at) => ({ ...fact, at, rank: shared.get(fact.key) })).sort((a, b) => a.rank - b.rank || a.at - b.at);
  const [first] = ranked;
  if (!first) return "";
  const second = ranked.find((fact) => fact.kind !== first.kind);
  const text = [first, second].filter(Boolean).map(({ text }) => text).join("; ");
  const name = CONTESTANTS.has(text.split(/[ ,]/)[0]); // a name is written as it is typed
  return `${name ? text : `${text[0].toUpperCase()}${text.slice(1)}`}.`;
}

const finished = (run) => ["ok", "flagged"].includes(run.status) && Number.isFinite(errorOf(run));

/**
 * The facts about one scene: {kind, key: what other scenes may share, text}.
 * @param {Tables["scenes.csv"]} scene
 * @param {Tables["runs.csv"][]} runs
 */
function factsAbout(scene, runs) {
  const found = [];
  const add = (kind, key, text) => found.push({ kind, key: `${kind} ${key}`, text });
  const lost = runs.filter((run) => run.status === "diverged");
  if (lost.length) add("lost", lost.map(nameOf).join(), `${abbreviated(lost.map(nameOf))} ${lost.length > 1 ? "diverge" : "diverges"}${lost.length > 1 ? " at the scene’s own step" : ` ${lost[0].why}`}`);
  for (const run of runs.filter((run) => run.status === "flagged")) {
    const wrong = (RUNS.get(contestantOf(run)) ?? []).filter((other) => other.status === "flagged").length;
    if (wrong <= 3) add("silent", nameOf(run), `${nameOf(run)} is wrong by ${si(errorOf(run), "m", 2)} without an error message, ${wrong === 1 ? "only here" : `as in ${counted(wrong - 1, "other scene")}`}`);
  }
  const exact = runs.filter((run) => verdictOf(run, state.tol) === "exact");
  if (exact.length > 1) add("exact", `${exact.length}`, `${exact.length} contestants are indistinguishable from the truth`);
  const rescued = runs.filter((run) => run.status === "ok" && (errorOf(run) ?? Infinity) < 1e-9 && median((RUNS.get(contestantOf(run)) ?? []).map(errorOf)) > 1e-4);
  if (rescued.length) add("rescued", "", `${abbreviated(rescued.map(nameOf))}, inaccurate elsewhere, ${rescued.length > 1 ? "are" : "is"} accurate here`);
  const [pair] = numbersFound("agreement distance", scene.scene);
  if (pair) add("pair", `${nameOf(pair)} ${pair.other}`, `${nameOf(pair)} and ${pair.other} agree ${pair.value ? `to ${si(pair.value, "m", 2)}` : "to the last digit"} and are both wrong by ${si(numbersFound("agreement error", scene.scene)[0].value, "m", 2)}`);
  const [right] = numbersFound("right column", scene.scene);
  const [wrong] = numbersFound("wrong column", scene.scene);
  if (right) add("report", "", `the ${right.other} column of the printed table is right to ${si(right.value, "m", 2)}, the ${wrong.other} one is wrong by ${si(wrong.value, "m", 2)}`);
  const [bent] = numbersFound("edge stretch", scene.scene);
  if (bent && Math.abs(Math.log(bent.value)) > 0.2) add("bent", "", `${contestantOf(bent)} ends with an edge ${bent.value.toFixed(2)} times its length`);
  const unable = runs.filter((run) => run.status === "skipped");
  const forces = scene.needs.split(", ").filter((need) => ["drag", "floor", "tether"].includes(need));
  if (unable.length && forces.length) add("unable", forces.join(), `${unable.length} of ${runs.length} contestants do not support ${forces.join(" or ")}`);
  if (scene.horizon_s !== null) add("horizon", "", `no program in double precision can predict the motion beyond ${given(scene.horizon_s)} s`);
  for (const row of findings("most accurate engine", scene.scene)) add("nearest", nameOf(row), `the most accurate engine is ${nameOf(row)}, with an error of ${si(findingValue(row), "m", 2)}`);
  return found;
}

// Superlatives: facts about the one scene with the most of something.
const SUPERLATIVES = [
  { kind: "most", of: (scene, runs) => Math.max(...engineRuns(runs).map(errorOf)), text: (value, scene, runs) => `the largest error of all scenes: ${nameOf(engineRuns(runs).find((run) => errorOf(run) === value))} is wrong by ${si(value, "m", 2)}` },
  { kind: "least", of: (scene, runs) => -Math.max(...engineRuns(runs).map(errorOf)), text: (value) => `no contestant has an error above ${si(-value, "m", 2)}` },
  { kind: "nearest", key: "long", of: (scene) => scene.duration_s, text: (value, scene) => `the longest flight, ${given(value)} s: ${nearestOf(scene)}` },
  { kind: "throws", of: (scene) => throwsOf(scene.scene), text: (value) => `the result is the worst of ${value} throws` },
  { kind: "fast", of: (scene) => spinOf(scene.scene) * scene.step_s, text: (value, scene) => `the fastest rotation per step, ${figure((value * 180) / Math.PI, 2)}° in ${given(scene.step_s)} s` },
  { kind: "impulses", of: (scene) => rows("loads.csv").filter((act) => act.scene === scene.scene && act.kind === "impulse").length, text: (value) => `${value} impulses; the effect of each depends on the attitude at that time` },
  { kind: "vertices", of: (scene) => scene.vertices, text: (value) => `${value} vertices` },
  { kind: "edge", of: (scene) => Math.max(0, ...numbersFound("edge stretch", scene.scene).map((row) => row.value)), text: (value, scene) => `${contestantOf(numbersFound("edge stretch", scene.scene)[0])} ends with an edge ${value.toFixed(1)} times its length` },
  { kind: "nearest", key: "hardest", of: (scene) => Math.max(0, ...numbersFound("most accurate engine", scene.scene).map((row) => findingValue(row) ?? 0)), text: (value, scene) => `the hardest for the engines: ${nearestOf(scene)}` },
];

/** The number of throws of a scene; of one that ran in parts, members.csv has the worst alone. */
function throwsOf(scene) {
  const inParts = rows("ensemble-errors.csv").find((row) => row.scene === scene);
  return inParts?.members ?? new Set(rows("members.csv").filter((row) => row.scene === scene).map((row) => row.member)).size;
}

const engineRuns = (runs) => runs.filter((run) => finished(run) && !CONTESTANTS.get(contestantOf(run))?.byHand);

function nearestOf(scene) {
  const [best] = findings("most accurate engine", scene.scene);
  return best ? `the most accurate engine, ${nameOf(best)}, is wrong by ${si(findingValue(best), "m", 2)}` : "no engine finishes it";
}

function addSuperlative(facts, scenes, runs, { kind, key = kind, of, text }) {
  const ranked = scenes
    .map((scene) => ({ scene, own: runs.get(scene.scene) ?? [] }))
    .map((one) => ({ ...one, value: of(one.scene, one.own) }))
    .filter(({ value }) => Number.isFinite(value) && value !== 0)
    .sort((a, b) => b.value - a.value);
  const [first, second] = ranked;
  if (first && (!second || first.value > second.value)) facts.get(first.scene.scene).unshift({ kind, key, text: text(first.value, first.scene, first.own) });
}

/**
 * The largest angular velocity of the truth on film [rad/s].
 * @param {string} scene
 */
function spinOf(scene) {
  const film = filmOf(scene);
  return film ? Math.max(...film.truth.map((frame) => Math.hypot(frame[10], frame[11], frame[12]))) : 0;
}

/**
 * @param {(number | null)[]} values
 */
function median(values) {
  const sorted = values.filter((value) => value !== null).sort((a, b) => a - b);
  return sorted[Math.floor((sorted.length - 1) / 2)] ?? 0;
}

/** At most three names, or two and the number of the rest. */
function abbreviated(names) {
  return names.length > 3 ? `${names.slice(0, 2).join(", ")} and ${names.length - 2} more` : listed(names);
}
