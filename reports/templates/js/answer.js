// The first sentence, and the tolerance that it answers for.

import { costInWords, namedInAnswer, sweptScenes } from "./cheapest.js";
import { CONTESTANTS, ENGINE_DEFAULTS, REQUESTED, defaultOf, scoreOf } from "./contestants.js";
import { contestantOf, findings } from "./data.js";
import { make } from "./dom.js";
import { chosen, counted, listed } from "./numbers.js";
import { choose, follow, linkToPlace, state } from "./state.js";

/** The tolerance the reader asks for. */
export function toleranceInput(host) {
  const units = { m: 1, mm: 1e-3, "µm": 1e-6, nm: 1e-9 };
  const unitFor = (value) => Object.keys(units).find((unit) => value >= units[unit]) ?? "nm";
  const number = make("input", { id: "tolerance", type: "number", min: "0", step: "any", inputmode: "decimal", "aria-label": "Acceptable error" });
  const unit = make("select", { "aria-label": "Unit of the tolerance" }, Object.keys(units).map((name) => make("option", { value: name }, name)));
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

/** The sentence that answers: which engine, at which step, and what engines do by default, or else as asked. */
export function answer(host) {
  follow(["tol"], () => {
    const tolerance = chosen(state.tol, "m");
    const parts = [];
    const [first, ...others] = namedInAnswer(state.tol);
    if (first) {
      parts.push(`To stay within ${tolerance} on the ${sweptScenes()[0]} throw, `, make("b", {}, first.name), ` is cheapest${costInWords(first)}`);
      others.forEach((one, at) => parts.push(at ? ", " : "; then ", make("b", {}, one.name), costInWords(one)));
      parts.push(". ");
    }
    const failing = otherEngines()
      .map((engine) => ({ name: defaultOf(engine), ...scoreOf(defaultOf(engine), state.tol) }))
      .filter(({ within, flown }) => within < flown);
    const [left, asked] = [true, false].map((isDefault) => failing.filter(({ name }) => ENGINE_DEFAULTS.has(CONTESTANTS.get(name).engine) === isDefault));
    const managed = [left.length && defaultsInWords(left), asked.length && requestedInWords(asked)].filter(Boolean);
    if (managed.length) parts.push(`At the scenes' own steps, ${managed.join("; ")}.`);
    host.replaceChildren(...parts, ...stiffClause());
  });
}

/** How many throws engines manage as they come; of several that manage none, only their names. */
function defaultsInWords(failing) {
  const none = failing.filter(({ within }) => !within).map(({ name }) => CONTESTANTS.get(name).engine);
  if (none.length === failing.length && none.length > 2) return `left at their defaults, ${listed(none)} manage none`;
  const told = none.length > 2 ? failing.filter(({ within }) => within) : failing;
  const each = told.map(({ name, within, flown }, at) => `${CONTESTANTS.get(name).engine}${at ? "" : " manages"} ${within} of ${flown}${at ? "" : " throws"}`);
  return `left at its default, ${listed(each)}${told.length < failing.length ? `; ${listed(none)} none` : ""}`;
}

/** The same of contestants that are no defaults: the user named them, or their engines have none. */
function requestedInWords(failing) {
  return `${failing.every(({ name }) => REQUESTED.has(name)) ? "as asked, " : ""}${listed(failing.map(({ name, within, flown }, at) => `${name}${at ? "" : " manages"} ${within} of ${flown}${at ? "" : " throws"}`))}`;
}

/** The engines that are not ours and took part in a scene. */
function otherEngines() {
  const named = [...CONTESTANTS.values()].filter((one) => !one.ours && !one.byHand).map((one) => one.engine);
  return [...new Set(named)].filter((engine) => defaultOf(engine));
}

/** The first sentence's clause on stiff scenes and extreme cases; nothing where there are none. */
function stiffClause() {
  const [known] = findings("limits with theory");
  const [near] = findings("limits as in theory");
  const [cases] = findings("extreme cases");
  const said = [];
  if (known) said.push([" On ", linkToPlace("stability", "stiff scenes"), `, ${near.value === known.value ? "all" : `${near.value} of`} ${counted(known.value, "measured step limit")} ${known.value === 1 ? "is that" : "are those"} of theory`]);
  const silent = findings("silent failures").filter((row) => [undefined, contestantOf(row)].includes(defaultOf(row.engine)));
  if (silent.length) said.push([said.length ? "; of " : ` On stiff scenes, of `, `${cases.value} `, linkToPlace("extremes", "extreme cases"), ` ${listed(silent.slice(0, 2).map((row, at) => `${ENGINE_DEFAULTS.has(row.engine) ? row.engine : contestantOf(row)}${at ? "" : " gets"} ${row.value}${at ? "" : " wrong without an error"}`))}`]);
  return said.length ? [...said.flat(), "."] : [];
}
