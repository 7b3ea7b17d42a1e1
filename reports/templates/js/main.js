// Puts the page together: the first screen at once, every section when it comes near the view.

const SECTIONS = {
  changed: ["changed-runs.csv", changesSection],
  scenes: ["scenes.csv", sceneSections],
  cost: ["sweep-work-precision.csv", costSections],
  stability: ["limits.csv", stableSection],
  extremes: ["extremes.csv", extremeSection],
  same: ["agreement.csv", agreementSection],
  matrix: ["deformed", matrixSection],
  "class-report": ["table-4-1-budget.csv", reportSection],
  spared: ["ablation.csv", sparedSection],
  releases: ["releases.csv", releasesSections],
  how: ["conditions.csv", provenanceSection],
};

function hasAny(table) {
  if (table === "deformed") return Object.values(DATA.films).some((film) => Object.values(film.others).some((one) => one.vertices));
  return rows(table).length > 0;
}

document.body.append(teller);
if (rows("runs.csv").length || sweptScenes().length) toleranceInput(document.getElementById("tolerance-host"));
answer(document.getElementById("answer"));
if (FIELD.size) {
  chips(document.getElementById("chips"));
  chooser(document.getElementById("chips"));
}
if (rows("runs.csv").length) board(document.getElementById("board-host"));
hero(document.getElementById("hero"));

for (const [id, [table, fill]] of Object.entries(SECTIONS)) {
  const section = document.getElementById(id);
  const link = document.querySelector(`nav a[href="#${id}"]`);
  if (!hasAny(table)) {
    section.remove();
    link?.parentElement.remove();
    continue;
  }
  link?.addEventListener("click", (event) => visit(event, id));
  // The scenes are folded and cheap; a section that an address points into cannot wait.
  const host = section.querySelector(".host");
  if (id === "scenes" || section.contains(document.getElementById(state.at)) || state.at) fill(host);
  else whenSeen(section, () => fill(host));
}
arrive();
document.documentElement.dataset.ready = "yes";

/** Everybody by name, to be shown or not. */
function chooser(host) {
  const boxes = new Map();
  const list = make("div", { class: "chooser-list" });
  for (const [engine, own] of groupBy(FIELD.values(), (one) => one.engine)) {
    const field = make("fieldset", {}, make("legend", {}, engine));
    for (const { name, method } of own) {
      const box = make("input", { type: "checkbox", change: () => show([...boxes].filter(([, each]) => each.checked).map(([other]) => other)) });
      boxes.set(name, box);
      field.append(make("label", {}, box, markOf(name), ` ${method}`));
    }
    list.append(field);
  }
  host.append(make("details", { class: "chooser" }, make("summary", {}, "choose"), list));
  follow(["show", "tol"], () => {
    const names = shown();
    for (const [name, box] of boxes) box.checked = names.has(name);
  });
}
