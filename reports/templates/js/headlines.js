// What is special about each scene: of all that can be said of it, what is said of the fewest others.

import { CONTESTANTS, RUNS } from "./contestants.js";
import { contestantOf, errorOf, findingValue, findings, groupBy, nameOf, numbersFound, rows } from "./data.js";
import { filmOf } from "./film.js";
import { counted, figure, given, listed, si } from "./numbers.js";
import { state } from "./state.js";
import { verdictOf } from "./verdicts.js";

let headlines = null;

/** The headline of a scene; '' where there is nothing to say. */
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

/** The two rarest facts of a scene, each of another kind. */
function inOneSentence(own, shared) {
  const ranked = own.map((fact, at) => ({ ...fact, at, rank: shared.get(fact.key) })).sort((a, b) => a.rank - b.rank || a.at - b.at);
  const [first] = ranked;
  if (!first) return "";
  const second = ranked.find((fact) => fact.kind !== first.kind);
  const said = [first, second].filter(Boolean).map(({ text }) => text).join("; ");
  const name = CONTESTANTS.has(said.split(/[ ,]/)[0]); // a name is written as it is typed
  return `${name ? said : `${said[0].toUpperCase()}${said.slice(1)}`}.`;
}

const finished = (run) => ["ok", "flagged"].includes(run.status) && Number.isFinite(errorOf(run));

/**
 * What can be said of one scene: {kind, key: what other scenes may share, text}.
 * @param {Tables["scenes.csv"]} scene
 * @param {Tables["runs.csv"][]} runs
 */
function factsAbout(scene, runs) {
  const found = [];
  const say = (kind, key, text) => found.push({ kind, key: `${kind} ${key}`, text });
  const lost = runs.filter((run) => run.status === "diverged");
  if (lost.length) say("lost", lost.map(nameOf).join(), `${abbreviated(lost.map(nameOf))} ${lost.length > 1 ? "blow" : "blows"} up${lost.length > 1 ? " at the scene’s own step" : ` ${lost[0].why}`}`);
  for (const run of runs.filter((run) => run.status === "flagged")) {
    const wrong = (RUNS.get(contestantOf(run)) ?? []).filter((other) => other.status === "flagged").length;
    if (wrong <= 3) say("silent", nameOf(run), `${nameOf(run)} goes wrong silently, ${si(errorOf(run), "m", 2)} off, as it does ${wrong === 1 ? "nowhere else" : `in ${counted(wrong - 1, "other scene")}`}`);
  }
  const exact = runs.filter((run) => verdictOf(run, state.tol) === "exact");
  if (exact.length > 1) say("exact", `${exact.length}`, `${exact.length} contestants cannot be told from the truth`);
  const rescued = runs.filter((run) => run.status === "ok" && (errorOf(run) ?? Infinity) < 1e-9 && median((RUNS.get(contestantOf(run)) ?? []).map(errorOf)) > 1e-4);
  if (rescued.length) say("rescued", "", `${abbreviated(rescued.map(nameOf))}, far off elsewhere, ${rescued.length > 1 ? "are" : "is"} right here`);
  const [pair] = numbersFound("apart", scene.scene);
  if (pair) say("pair", `${nameOf(pair)} ${pair.other}`, `${nameOf(pair)} and ${pair.other} agree ${pair.value ? `to ${si(pair.value, "m", 2)}` : "to the last digit"} and are both ${si(numbersFound("both off", scene.scene)[0].value, "m", 2)} off`);
  const [right, wrong] = ["right column", "wrong column"].map((name) => numbersFound(name, scene.scene)[0]);
  if (right) say("report", "", `the ${right.other} column of the printed table is right to ${si(right.value, "m", 2)}, the ${wrong.other} one is ${si(wrong.value, "m", 2)} off`);
  const [bent] = numbersFound("bent edge", scene.scene);
  if (bent && Math.abs(Math.log(bent.value)) > 0.2) say("bent", "", `${contestantOf(bent)} ends with an edge ${bent.value.toFixed(2)} times its length`);
  const unable = runs.filter((run) => run.status === "skipped");
  const forces = scene.needs.split(", ").filter((need) => ["drag", "floor", "tether"].includes(need));
  if (unable.length && forces.length) say("unable", forces.join(), `${unable.length} of ${runs.length} contestants do not support ${forces.join(" or ")}`);
  if (scene.horizon_s !== null) say("horizon", "", `no program in double precision can follow beyond ${given(scene.horizon_s)} s`);
  for (const row of findings("nearest engine", scene.scene)) say("nearest", nameOf(row), `the nearest engine is ${nameOf(row)}, ${si(findingValue(row), "m", 2)} off`);
  return found;
}

// Of all scenes the one with the most of something, where that is told of one alone.
const SUPERLATIVES = [
  { kind: "most", of: (scene, runs) => Math.max(...engineRuns(runs).map(errorOf)), text: (value, scene, runs) => `no engine is further off anywhere than ${nameOf(engineRuns(runs).find((run) => errorOf(run) === value))} here, ${si(value, "m", 2)}` },
  { kind: "least", of: (scene, runs) => -Math.max(...engineRuns(runs).map(errorOf)), text: (value) => `no contestant is off by more than ${si(-value, "m", 2)}` },
  { kind: "nearest", key: "long", of: (scene) => scene.duration_s, text: (value, scene) => `the longest flight, ${given(value)} s: ${nearestOf(scene)}` },
  { kind: "throws", of: (scene) => new Set(rows("members.csv").filter((row) => row.scene === scene.scene).map((row) => row.member)).size, text: (value) => `the worst of ${value} throws counts` },
  { kind: "fast", of: (scene) => spinOf(scene.scene) * scene.step_s, text: (value, scene) => `the fastest turn a step, ${figure((value * 180) / Math.PI, 2)}° in ${given(scene.step_s)} s` },
  { kind: "impulses", of: (scene) => rows("loads.csv").filter((act) => act.scene === scene.scene && act.kind === "impulse").length, text: (value) => `${value} impulses, and the attitude at the last decides what it does` },
  { kind: "vertices", of: (scene) => scene.vertices, text: (value) => `${value} vertices` },
  { kind: "edge", of: (scene) => Math.max(0, ...numbersFound("bent edge", scene.scene).map((row) => row.value)), text: (value, scene) => `${contestantOf(numbersFound("bent edge", scene.scene)[0])} ends with an edge ${value.toFixed(1)} times its length` },
  { kind: "nearest", key: "hardest", of: (scene) => Math.max(0, ...numbersFound("nearest engine", scene.scene).map((row) => findingValue(row) ?? 0)), text: (value, scene) => `the hardest for the engines: ${nearestOf(scene)}` },
];

const engineRuns = (runs) => runs.filter((run) => finished(run) && !CONTESTANTS.get(contestantOf(run))?.byHand);

function nearestOf(scene) {
  const [best] = findings("nearest engine", scene.scene);
  return best ? `the nearest engine, ${nameOf(best)}, is ${si(findingValue(best), "m", 2)} off` : "no engine ends it";
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

/** Some names and how many more. */
function abbreviated(names) {
  return names.length > 3 ? `${names.slice(0, 2).join(", ")} and ${names.length - 2} more` : listed(names);
}
