// The first sentence, and the tolerance that it answers for.

import { costInWords, namedInAnswer, sweptScenes } from "./cheapest.js";
import { CONTESTANTS, ENGINE_DEFAULTS, REQUESTED, defaultOf, scoreOf } from "./contestants.js";
import { contestantOf, numbersFound } from "./data.js";
import { make } from "./dom.js";
import { chosen, counted, listed } from "./numbers.js";
import { choose, follow, linkToPlace, state } from "./state.js";

/** The input of the acceptable error. */
export function toleranceInput(host) {
  const units = { m: 1, mm: 1e-3, "µm": 1e-6, nm: 1e-9 };
  const unitFor = (value) => Object.keys(units).find((unit) => value >= units[unit]) ?? "nm";
  const number = make("input", { id: "tolerance", type: "number", min: "0", step: "any", inputmode: "decimal", "aria-label": "Acceptable error" });
  const unit = make("select", { "aria-label": "Unit of the acceptable error" }, Object.keys(units).map((name) => make("option", { value: name }, name)));
  const read = () => {
    const value = Number(number.value) * units[unit.value];
    if (value > 0 && Number.isFinite(value)) choose({ tol: Number(value.toPrecision(6)) });
  };
  number.addEventListener("change", read);
  unit.addEventListener("change", read);
  host.append(make("label", { for: "tolerance" }, "Acceptable error"), number, unit);
  follow(["tol"], () => {
    const typed = Number((Number(number.value) * units[unit.value]).toPrecision(6));
    if (number.value !== "" && typed === state.tol) return; // as the reader wrote it: 0.01 mm stays 0.01 mm
    unit.value = unitFor(state.tol);
    number.value = Number((state.tol / units[unit.value]).toPrecision(6));
  });
}

/** The sentence that answers: the cheapest contestant and its step, and what engines reach by default or as requested. */
export function answer(host) {
  follow(["tol"], () => {
    const tolerance = chosen(state.tol, "m");
    const parts = [];
    const [first, ...others] = namedInAnswer(state.tol);
    if (first) {
      parts.push(`To stay within ${tolerance} on the ${sweptScenes()[0]} throw, `, make("b", {}, first.name), ` is the cheapest${costInWords(first)}`);
      others.forEach((one, at) => parts.push(at ? ", " : "; then ", make("b", {}, one.name), costInWords(one)));
      parts.push(". ");
    }
    const scores = otherEngines().map((engine) => ({ name: defaultOf(engine), ...scoreOf(defaultOf(engine), state.tol) }));
    const failing = scores.filter(({ within, count }) => within < count);
    if (scores.length && !failing.length) parts.push(`At each scene's own step, ${listed(scores.map(({ name }) => name))} ${scores.length === 1 ? "stays" : "stay"} within ${tolerance} in every throw. `);
    const [defaults, requested] = [true, false].map((isDefault) => failing.filter(({ name }) => ENGINE_DEFAULTS.has(CONTESTANTS.get(name).engine) === isDefault));
    if (defaults.length) parts.push(`By default, at each scene's own step, ${defaultsInWords(defaults, tolerance)}. `);
    const how = requested.every(({ name }) => REQUESTED.has(name)) ? "As requested" : "At each scene's own step";
    if (requested.length) parts.push(`${how}, ${sharesInWords(requested, tolerance, ({ name }) => name)}. `);
    host.replaceChildren(...parts, ...stiffClause());
  });
}

/** In how many throws engines stay within a tolerance by default; of three or more that never do, only the names. */
function defaultsInWords(failing, tolerance) {
  const engineOf = ({ name }) => CONTESTANTS.get(name).engine;
  const never = failing.filter(({ within }) => !within);
  if (never.length < 3) return sharesInWords(failing, tolerance, engineOf);
  const rest = failing.filter(({ within }) => within);
  if (!rest.length) return `${listed(never.map(engineOf))} never stay within ${tolerance}`;
  return `${sharesInWords(rest, tolerance, engineOf)}; ${listed(never.map(engineOf))} in none`;
}

/** `a stays within 1 mm in 3 of 9 throws and b in 2 of 9`. */
function sharesInWords(scores, tolerance, nameFor) {
  return listed(scores.map((score, at) => `${nameFor(score)}${at ? "" : ` stays within ${tolerance}`} in ${score.within} of ${score.count}${at ? "" : " throws"}`));
}

/** The engines that are not ours and took part in a scene. */
function otherEngines() {
  const named = [...CONTESTANTS.values()].filter((one) => !one.ours && !one.byHand).map((one) => one.engine);
  return [...new Set(named)].filter((engine) => defaultOf(engine));
}

/** The clause on stiff scenes and extreme cases; nothing where there are none. */
function stiffClause() {
  const [known] = numbersFound("limits with theory");
  const [near] = numbersFound("limits matching theory");
  const [cases] = numbersFound("extreme cases");
  const parts = [];
  if (known) parts.push(["On ", linkToPlace("stability", "stiff scenes"), `, ${near.value === known.value ? "all" : `${near.value} of`} ${counted(known.value, "measured step limit")} ${known.value === 1 ? "matches" : "match"} theory`]);
  const silent = numbersFound("silent failures").filter((row) => [undefined, contestantOf(row)].includes(defaultOf(row.engine)));
  const shares = silent.slice(0, 2).map((row, at) => `${ENGINE_DEFAULTS.has(row.engine) ? row.engine : contestantOf(row)}${at ? "" : " is wrong without an error message"} in ${row.value}`);
  if (silent.length) parts.push([parts.length ? "; of " : "Of ", `${cases.value} `, linkToPlace("extremes", "extreme cases"), `, ${listed(shares)}`]);
  return parts.length ? [...parts.flat(), "."] : [];
}
