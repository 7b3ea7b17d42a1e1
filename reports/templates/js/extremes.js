// Extreme cases: a board like the first one; a cell opens the details of its run and the command that repeats it.

import { brokenName, markOf } from "./contestants.js";
import { contestantOf, findings, groupBy, nameOf, rows } from "./data.js";
import { make } from "./dom.js";
import { MINUS, counted, figure, given, listed, si } from "./numbers.js";
import { highlight, shown } from "./selection.js";
import { copyLinkButton, copyTextButton, follow } from "./state.js";
import { foldedTable } from "./table.js";
import { showTooltip } from "./tooltip.js";
import { SILENT_VERDICTS, STABILITY_VERDICTS, tintOf } from "./verdicts.js";

const CLOSE = 0.01; // of the body's size: accurate enough here, for bodies of a micrometre and of 1000 km alike

/** @type {Record<string, [string, string]>} */
const CASE_VERDICTS = {
  exact: ["◉", "indistinguishable from the truth"],
  within: ["●", "error within 1 % of the body’s size"],
  beyond: ["○", "stable, error above 1 % of the body’s size"],
  flagged: ["▲", "wrong without an error message"],
  diverged: ["✕", "diverged visibly"],
  failed: ["✕", "crashed or timed out"],
  late: ["…", "too slow: not run to the end"],
  skipped: ["·", "not supported"],
};

/**
 * The verdict on one run of an extreme case, as a key of CASE_VERDICTS.
 * @param {Tables["extremes.csv"]} row
 */
function caseKind(row) {
  if (row.verdict in SILENT_VERDICTS) return "flagged";
  if (row.verdict === "diverged") return "diverged";
  if (row.verdict === "no-return") return row.why.includes("would take") ? "late" : "failed";
  if (row.verdict === "refused") return row.status === "crashed" ? "failed" : "skipped";
  if (row.error_over_resolution !== null && row.error_over_resolution <= 1) return "exact";
  return row.max_error_m !== null && row.max_error_m <= CLOSE * row.size_m ? "within" : "beyond";
}

/**
 * The error of a run as a share of the body's size, short.
 * @param {Tables["extremes.csv"]} row
 * @param {string} kind
 */
function caseFigure(row, kind) {
  if (kind === "flagged") return SILENT_VERDICTS[row.verdict];
  if (kind === "exact" || row.max_error_m === null || !Number.isFinite(row.max_error_m)) return "";
  const share = row.max_error_m / row.size_m;
  return share >= 0.001 ? `${figure(100 * share, share < 0.1 ? 1 : 2)}%` : share.toExponential(0).replace("-", MINUS);
}

export function extremeSection(host) {
  const cases = [...groupBy(rows("extremes.csv"), (row) => row.scene).values()].map(([first]) => first);
  const runs = new Map(rows("extremes.csv").map((row) => [`${contestantOf(row)} ${row.scene}`, row]));
  const detail = make("div", { class: "case-detail", role: "status", id: "case-detail" });
  const body = make("tbody");
  host.append(
    make("p", { class: "headline" }, extremeHeadline(cases.length)),
    make(
      "div",
      { class: "wide board", tabindex: "0", role: "region", "aria-label": "Scoreboard of extreme cases: contestants by cases" },
      make(
        "table",
        { id: "extreme-board", class: "scores" },
        make("caption", { class: "unseen" }, "Result of each contestant in each extreme case; press a cell for details and the command"),
        make(
          "thead",
          {},
          make("tr", {}, make("th", { scope: "col", class: "name" }, "contestant"), make("th", { scope: "col", title: "accurate cases, of all that were run" }, "accurate"), cases.map((row) => make("th", { scope: "col", class: "upright", title: row.title }, row.scene))),
        ),
        body,
      ),
    ),
  );
  /** @type {Set<string>} */
  const kinds = new Set(rows("extremes.csv").map(caseKind));
  host.append(
    detail,
    make("p", { class: "key" }, make("span", {}, "number: largest vertex error divided by the body’s size"), Object.entries(CASE_VERDICTS).filter(([kind]) => kinds.has(kind)).map(([kind, [glyph, words]]) => make("span", {}, make("span", { class: `glyph v-${kind}`, "aria-hidden": "true" }, glyph), ` ${words}`))),
  );
  const showCase = (row) => {
    detail.replaceChildren(...caseDetail(row));
    for (const cell of body.querySelectorAll("button")) cell.setAttribute("aria-pressed", cell.dataset.case === caseId(row));
  };
  follow(["show", "tol"], () => {
    const names = [...shown()].filter((name) => cases.some((one) => runs.has(`${name} ${one.scene}`)));
    const scored = names.map((name) => {
      const own = cases.flatMap((one) => runs.get(`${name} ${one.scene}`) ?? []);
      return { name, own, sound: own.filter((row) => ["exact", "within"].includes(caseKind(row))).length, silent: own.filter((row) => caseKind(row) === "flagged").length };
    });
    scored.sort((a, b) => b.sound - a.sound || a.silent - b.silent);
    body.replaceChildren(
      ...scored.map(({ name, own, sound }) =>
        make(
          "tr",
          { id: `extreme-board-${name}`, "data-name": name, pointerenter: () => highlight(name), pointerleave: () => highlight("") },
          make("th", { scope: "row", class: "name" }, markOf(name), make("span", {}, brokenName(name)), copyLinkButton(`extreme-board-${name}`)),
          make("td", { class: "score" }, `${sound}/${own.length}`),
          cases.map((one) => caseCell(runs.get(`${name} ${one.scene}`), showCase)),
        ),
      ),
    );
    roving(body);
  });
  extremeTable(host);
}

/**
 * @param {Tables["extremes.csv"]} row
 */
function caseId(row) {
  return `${row.scene} ${nameOf(row)}`;
}

/**
 * @param {Tables["extremes.csv"] | undefined} row
 */
function caseCell(row, showCase) {
  if (!row) return make("td", { class: "cell" }, "");
  const kind = caseKind(row);
  const [glyph, words] = CASE_VERDICTS[kind];
  return make(
    "td",
    { class: `cell v-${kind} ${tintOf(kind, (row.max_error_m ?? 0) / (CLOSE * row.size_m))}`, pointermove: (event) => showTooltip([nameOf(row), `${row.title}: ${words}`, "press for details and the command"], event), pointerleave: () => showTooltip(null) },
    make(
      "button",
      { type: "button", class: "case", "data-case": caseId(row), "aria-pressed": "false", "aria-label": `${nameOf(row)}, ${row.scene}: ${STABILITY_VERDICTS[row.verdict]?.[1] ?? row.verdict}`, click: () => (showTooltip(null), showCase(row)) },
      make("span", { class: "glyph", "aria-hidden": "true" }, glyph),
      make("span", { class: "figure" }, caseFigure(row, kind)),
    ),
  );
}

/** The tab key reaches one cell of the board, arrow keys the others. */
function roving(body) {
  const table = [...body.rows].map((line) => [...line.querySelectorAll("button.case")]);
  table.flat().forEach((cell, at) => (cell.tabIndex = at ? -1 : 0));
  body.onkeydown = (event) => {
    const step = { ArrowLeft: [0, -1], ArrowRight: [0, 1], ArrowUp: [-1, 0], ArrowDown: [1, 0] }[event.key];
    const line = table.findIndex((cells) => cells.includes(event.target));
    if (!step || line < 0) return;
    const next = table[line + step[0]]?.[table[line].indexOf(event.target) + step[1]];
    event.preventDefault();
    if (!next) return;
    event.target.tabIndex = -1;
    next.tabIndex = 0;
    next.focus();
  };
}

/**
 * The result of one run, the reason, and the command that repeats it.
 * @param {Tables["extremes.csv"]} row
 */
function caseDetail(row) {
  const kind = caseKind(row);
  const error = row.max_error_m === null ? "" : Number.isFinite(row.max_error_m) ? `The largest vertex error is ${si(row.max_error_m, "m", 2)}; the body extends ${si(row.size_m, "m", 2)} from its centre. ` : "";
  const energy = kind === "flagged" && row.energy_ratio !== null && Number.isFinite(row.energy_ratio) ? `It ends with ${figure(row.energy_ratio, 2)} times the true energy. ` : "";
  const verdict = kind === "flagged" ? `${STABILITY_VERDICTS[row.verdict][1]}, without an error message` : kind === "late" ? "not run to the end" : (STABILITY_VERDICTS[row.verdict]?.[1] ?? row.verdict);
  const command = `tumble stability ${row.scene} -e ${nameOf(row)}`;
  return [
    make("p", {}, markOf(contestantOf(row)), " ", make("b", {}, nameOf(row)), ` in “${row.title}”, step ${given(row.dt_s)} s: ${verdict}. ${error}${energy}`, row.why ? make("span", { class: "note" }, `${row.why[0].toUpperCase()}${row.why.slice(1)}.`) : ""),
    make("p", {}, "Repeat: ", make("code", {}, command), copyTextButton(command)),
  ];
}

function extremeHeadline(count) {
  const accurate = [...groupBy(rows("extremes.csv"), contestantOf)].filter(([, own]) => own.every((row) => row.verdict === "stable" && (row.error_over_resolution ?? Infinity) <= 10)).map(([name]) => name);
  const silent = findings("silent failures").slice(0, 3);
  const clauses = [];
  if (accurate.length) clauses.push(`${listed(accurate)} ${accurate.length > 1 ? "are" : "is"} accurate to rounding in all ${count} cases`);
  if (silent.length) clauses.push(listed(silent.map((row, at) => `${contestantOf(row)}${at ? "" : " is wrong without an error message"} in ${row.value}`)));
  return clauses.length ? `${clauses.join("; ")}.` : `Results of ${counted(count, "extreme case")}.`;
}

function extremeTable(host) {
  foldedTable(host, {
    id: "extreme-cases",
    caption: "All runs of extreme cases",
    file: "extremes",
    list: rows("extremes.csv"),
    key: (row) => `${row.scene}-${nameOf(row)}`,
    columns: [
      { key: "scene", label: "case", words: true, show: (row) => row.title || row.scene, sort: (row) => row.scene },
      { key: "method", label: "contestant", words: true, show: nameOf, sort: nameOf },
      { key: "verdict", label: "result", words: true, show: (row) => STABILITY_VERDICTS[row.verdict]?.[1] ?? row.verdict },
      { key: "max_error_m", label: "error", unit: "m" },
      { key: "error_over_resolution", label: "error over resolution" },
      { key: "why", label: "reason", words: true },
    ],
  });
}
