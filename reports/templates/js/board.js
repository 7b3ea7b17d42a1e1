// The first screen: engines by scenes, one sign and one number a cell, for the error that the reader accepts.

import { cheapest, settingOf } from "./cheapest.js";
import { RUNS, brokenName, markOf, rolesOf, scoreOf } from "./contestants.js";
import { contestantOf, errorOf, rows } from "./data.js";
import { make } from "./dom.js";
import { figure, inUnit, unitOf } from "./numbers.js";
import { openScene } from "./scenes.js";
import { highlight, shown } from "./selection.js";
import { choose, copyLinkButton, follow, state } from "./state.js";
import { showTooltip } from "./tooltip.js";
import { VERDICTS, tintOf, verdictOf } from "./verdicts.js";

/**
 * The lines of a run's tooltip.
 * @param {Tables["runs.csv"]} run
 * @param {number} tolerance
 */
function runTooltip(run, tolerance) {
  const words = VERDICTS[verdictOf(run, tolerance)][1];
  const lines = [`${run.scene}, ${settingOf(run)}: ${words}`];
  if (run.max_error_m !== null) lines.push(`largest vertex error ${run.max_error_m <= (run.resolution_m ?? 0) ? `≤ ${figure(run.resolution_m)} m, the resolution of the truth` : `${figure(run.max_error_m)} m`}`);
  if (run.why) lines.push(run.why);
  return lines;
}

/** The scenes in the order of the board: free flights first, then those with forces, and those above a plane. */
function boardScenes() {
  const forced = (scene) => /tether|drag|floor/.test(scene.needs), landing = (scene) => /plane/.test(scene.needs);
  const all = rows("scenes.csv");
  /** @type {[string, Tables["scenes.csv"][]][]} */
  const groups = [
    ["free flight", all.filter((scene) => !forced(scene) && !landing(scene))],
    ["with forces", all.filter(forced)],
    ["above a plane", all.filter((scene) => landing(scene) && !forced(scene))],
  ];
  return groups.filter(([, list]) => list.length);
}

/** Put the scoreboard into host. */
export function board(host) {
  const groups = boardScenes();
  const scenes = groups.flatMap(([, list]) => list);
  const body = make("tbody");
  host.append(
    make(
      "div",
      { class: "wide board", tabindex: "0", role: "region", "aria-label": "Scoreboard: contestants by scenes" },
      make(
        "table",
        { id: "board", class: "scores" },
        make("caption", { class: "unseen" }, "Largest vertex error of each contestant in each scene, and whether it is acceptable"),
        make(
          "thead",
          {},
          make("tr", {}, make("td"), make("td"), make("td"), groups.map(([label, list]) => make("th", { scope: "colgroup", colspan: list.length, class: "group" }, label))),
          make(
            "tr",
            {},
            make("th", { scope: "col", class: "name" }, "contestant"),
            make("th", { scope: "col", title: "scenes in which the largest error is acceptable, of all that were run" }, "within"),
            make("th", { scope: "col", class: "of-row", title: "unit of the errors in this row" }, "unit"),
            scenes.map((scene) => make("th", { scope: "col", class: "upright" }, make("a", { href: `#scene-${scene.scene}`, title: scene.title, click: (event) => openScene(event, scene.scene) }, scene.scene))),
          ),
        ),
        body,
      ),
    ),
  );
  const runs = new Map(rows("runs.csv").map((run) => [`${contestantOf(run)} ${run.scene}`, run]));
  follow(["tol", "show"], () => {
    const names = [...shown()].filter((name) => RUNS.has(name)).map((name) => ({ name, unit: unitOf((RUNS.get(name) ?? []).map(errorOf)), ...scoreOf(name, state.tol) }));
    names.sort((a, b) => b.within - a.within || a.digits - b.digits);
    const [first] = cheapest(state.tol);
    body.replaceChildren(
      ...names.map(({ name, within, count, unit }) =>
        make(
          "tr",
          { id: `board-${name}`, "data-name": name, pointerenter: () => highlight(name), pointerleave: () => highlight("") },
          make("th", { scope: "row", class: "name" }, markOf(name), make("span", {}, brokenName(name), make("span", { class: "note" }, [rolesOf(name), name === first?.name ? "cheapest" : ""].filter(Boolean).join(", "))), copyLinkButton(`board-${name}`)),
          make("td", { class: "score" }, count ? `${within}/${count}` : "–"),
          make("td", { class: "of-row" }, unit),
          scenes.map((scene) => boardCell(runs.get(`${name} ${scene.scene}`), scene.scene, unit)),
        ),
      ),
    );
  });
  /** @type {Set<string>} */
  const kinds = new Set(rows("runs.csv").map((run) => verdictOf(run, state.tol)));
  host.append(
    make(
      "p",
      { class: "key" },
      Object.entries(VERDICTS)
        .filter(([kind]) => kinds.has(kind) || kind === "within")
        .map(([kind, [glyph, words]]) => make("span", {}, make("span", { class: `glyph v-${kind}`, "aria-hidden": "true" }, glyph), ` ${words}`)),
    ),
  );
}

/**
 * @param {Tables["runs.csv"] | undefined} run
 * @param {string} scene
 * @param {string} unit
 */
function boardCell(run, scene, unit) {
  if (!run) return make("td", { class: "cell" }, "");
  const kind = verdictOf(run, state.tol);
  const [glyph, words] = VERDICTS[kind];
  const error = errorOf(run);
  const number = error === null || kind === "diverged" ? "" : `${kind === "exact" ? "≤" : ""}${inUnit(error, unit)}`;
  const showRun = (event) => showTooltip([contestantOf(run), ...runTooltip(run, state.tol)], event);
  return make(
    "td",
    { class: `cell v-${kind} ${tintOf(kind, (error ?? 0) / state.tol)}`, pointermove: showRun, pointerleave: () => showTooltip(null), click: () => choose({ scene }) },
    make("span", { class: "glyph", "aria-hidden": "true" }, glyph),
    make("span", { class: "unseen" }, words),
    make("span", { class: "figure" }, number),
  );
}
