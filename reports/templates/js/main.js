// Assembles the page: the first screen at once, each section when it comes near the view.

import { ablationSection } from "./ablation.js";
import { agreementSection } from "./agreement.js";
import { answer, toleranceInput } from "./answer.js";
import { board } from "./board.js";
import { changesSection } from "./changes.js";
import { sweptScenes } from "./cheapest.js";
import { contactSection } from "./contact.js";
import { CONTESTANTS } from "./contestants.js";
import { costSections } from "./cost.js";
import { courseworkSection } from "./coursework.js";
import { DATA, rows } from "./data.js";
import { byId, whenSeen } from "./dom.js";
import { extremeSection } from "./extremes.js";
import { hero } from "./hero.js";
import { matrixSection } from "./matrix.js";
import { provenanceSection } from "./provenance.js";
import { releasesSections } from "./releases.js";
import { sceneSections } from "./scenes.js";
import { chips, chooser } from "./selection.js";
import { stableSection } from "./stability.js";
import { goTo, showPlace, state } from "./state.js";
import { tooltip } from "./tooltip.js";

/** @type {Record<string, [keyof Tables | "deformed", (host: Element) => void]>} */
const SECTIONS = {
  changed: ["changed-runs.csv", changesSection],
  scenes: ["scenes.csv", sceneSections],
  contact: ["contact.csv", contactSection],
  cost: ["sweep-work-precision.csv", costSections],
  stability: ["limits.csv", stableSection],
  extremes: ["extremes.csv", extremeSection],
  same: ["agreement.csv", agreementSection],
  matrix: ["deformed", matrixSection],
  "class-report": ["table-4-1-budget.csv", courseworkSection],
  spared: ["ablation.csv", ablationSection],
  releases: ["releases.csv", releasesSections],
  how: ["conditions.csv", provenanceSection],
};

function hasAny(table) {
  if (table === "deformed") return Object.values(DATA.films).some((film) => Object.values(film.runs).some((one) => one.vertices));
  return rows(table).length > 0;
}

document.body.append(tooltip);

if (rows("runs.csv").length || sweptScenes().length) toleranceInput(byId("tolerance-host"));

answer(byId("answer"));

if (CONTESTANTS.size) {
  chips(byId("chips"));
  chooser(byId("chips"));
}

if (rows("runs.csv").length) board(byId("board-host"));

hero(byId("hero"));

for (const [id, [table, fill]] of Object.entries(SECTIONS)) {
  const section = byId(id);
  const link = document.querySelector(`nav a[href="#${id}"]`);
  if (!hasAny(table)) {
    section.remove();
    link?.parentElement?.remove();
    continue;
  }
  link?.addEventListener("click", (event) => goTo(event, id));
  // The scenes are folded and cheap; a section that holds the place of the address cannot wait.
  const host = /** @type {Element} */ (section.querySelector(".host"));
  if (id === "scenes" || section.contains(document.getElementById(state.at)) || state.at) fill(host);
  else whenSeen(section, () => fill(host));
}

showPlace();

document.documentElement.dataset.ready = "yes";
