// The first screen: engines by scenes, one glyph and one number a cell, for the error that the reader can bear.

const VERDICTS = {
  exact: ["◉", "cannot be told from the truth"],
  within: ["●", "finished, within the tolerance"],
  beyond: ["○", "finished, beyond the tolerance"],
  flagged: ["▲", "finished, but something went wrong silently"],
  diverged: ["✕", "blew up"],
  failed: ["✕", "crashed or timed out"],
  skipped: ["·", "cannot fly this scene"],
};

function verdictOf(run, tolerance) {
  const kind = run.status;
  if (kind === "skipped" || kind === "missing") return "skipped";
  if (kind === "diverged") return "diverged";
  if (kind === "crashed" || kind === "timeout") return "failed";
  const error = errorOf(run);
  if (error === null) return "skipped";
  if (kind === "flagged") return "flagged";
  if (run.max_error_m <= (run.resolution_m ?? 0)) return "exact";
  return error <= tolerance ? "within" : "beyond";
}

/** What is said of one run. */
function toldOf(run, tolerance) {
  const words = VERDICTS[verdictOf(run, tolerance)][1];
  const lines = [`${run.scene}, ${settingOf(run)}: ${words}`];
  if (run.max_error_m !== null) lines.push(`largest vertex error ${run.max_error_m <= (run.resolution_m ?? 0) ? `≤ ${figure(run.resolution_m)} m, all that the truth can tell` : `${figure(run.max_error_m)} m`}`);
  if (run.why) lines.push(run.why);
  return lines;
}

/** The scenes in the order of the board: free ones first, then those with forces. */
function boardScenes() {
  const forced = (scene) => /tether|drag|floor/.test(scene.needs);
  const all = rows("scenes.csv");
  return [["free flight", all.filter((scene) => !forced(scene))], ["under forces", all.filter(forced)]].filter(([, list]) => list.length);
}

function board(host) {
  const groups = boardScenes();
  const scenes = groups.flatMap(([, list]) => list);
  const body = make("tbody");
  host.append(
    make(
      "div",
      { class: "wide board", tabindex: "0", role: "region", "aria-label": "Scoreboard: engines by scenes" },
      make(
        "table",
        { id: "board", class: "scores" },
        make("caption", { class: "unseen" }, "Largest vertex error of each contestant in each scene, and whether it is within the tolerance"),
        make(
          "thead",
          {},
          make("tr", {}, make("td"), make("td"), make("td"), groups.map(([label, list]) => make("th", { scope: "colgroup", colspan: list.length, class: "group" }, label))),
          make(
            "tr",
            {},
            make("th", { scope: "col", class: "name" }, "contestant"),
            make("th", { scope: "col" }, "within"),
            make("th", { scope: "col", class: "of-row" }, "in"),
            scenes.map((scene) => make("th", { scope: "col", class: "upright" }, make("a", { href: `#scene-${scene.scene}`, title: scene.title, click: (event) => openScene(event, scene.scene) }, scene.scene))),
          ),
        ),
        body,
      ),
    ),
  );
  const runs = new Map(rows("runs.csv").map((run) => [`${contestantOf(run)} ${run.scene}`, run]));
  follow(["tol", "show"], () => {
    const names = [...shown()].filter((name) => RUNS.has(name)).map((name) => ({ name, unit: unitOf(RUNS.get(name).map(errorOf)), ...scoreOf(name, state.tol) }));
    names.sort((a, b) => b.within - a.within || a.digits - b.digits);
    const [first] = cheapest(state.tol);
    body.replaceChildren(
      ...names.map(({ name, within, flown, unit }) =>
        make(
          "tr",
          { id: `board-${name}`, "data-name": name, pointerenter: () => pick(name), pointerleave: () => pick("") },
          make("th", { scope: "row", class: "name" }, markOf(name), make("span", {}, brokenName(name), make("span", { class: "note" }, [rolesOf(name), name === first?.name ? "cheapest" : ""].filter(Boolean).join(", "))), linkTo(`board-${name}`)),
          make("td", { class: "score" }, flown ? `${within}/${flown}` : "–"),
          make("td", { class: "of-row" }, unit),
          scenes.map((scene) => boardCell(runs.get(`${name} ${scene.scene}`), scene.scene, unit)),
        ),
      ),
    );
  });
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

/** What a contestant is to its engine. */
function rolesOf(name) {
  const { engine, manner, byHand } = FIELD.get(name);
  if (byHand) return "";
  const roles = [];
  if (ENGINE_DEFAULTS.get(engine) === name) roles.push(manner === "defaults" ? "as it ships" : "its default");
  if (ASKED.has(name)) roles.push("as asked");
  if (bestOf(engine, state.tol) === name) roles.push("its best");
  return roles.join(", ");
}

function boardCell(run, scene, unit) {
  if (!run) return make("td", { class: "cell" }, "");
  const kind = verdictOf(run, state.tol);
  const [glyph, words] = VERDICTS[kind];
  const error = errorOf(run);
  const number = error === null || kind === "diverged" ? "" : `${kind === "exact" ? "≤" : ""}${inUnit(error, unit)}`;
  const tellIt = (event) => tell([contestantOf(run), ...toldOf(run, state.tol)], event);
  return make(
    "td",
    { class: `cell v-${kind} ${tintOf(kind, error / state.tol)}`, pointermove: tellIt, pointerleave: () => tell(null), click: () => choose({ scene }) },
    make("span", { class: "glyph", "aria-hidden": "true" }, glyph),
    make("span", { class: "unseen" }, words),
    make("span", { class: "figure" }, number),
  );
}

/** How strongly a cell is coloured: a step for each decade that its error is below the tolerance, or above it. */
function tintOf(kind, ratio) {
  if (!["exact", "within", "beyond"].includes(kind)) return "";
  const decades = Math.min(12, Math.max(1, Math.ceil(Math.abs(Math.log10(ratio || 1e-12)))));
  return `${kind === "beyond" ? "above" : "below"}-${decades}`;
}

function openScene(event, scene) {
  event.preventDefault();
  const fold = document.getElementById(`scene-${scene}`);
  fold.open = true;
  choose({ at: `scene-${scene}` });
  fold.scrollIntoView({ block: "start", behavior: stillness.matches ? "auto" : "smooth" });
}

/** The tolerance the reader asks for. */
function toleranceInput(host) {
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
function answer(host) {
  follow(["tol"], () => {
    const tolerance = chosen(state.tol, "m");
    const parts = [];
    const [first, ...others] = answering(state.tol);
    if (first) {
      parts.push(`To stay within ${tolerance} on the ${sweptScenes()[0]} throw, `, make("b", {}, first.name), ` is cheapest${costInWords(first)}`);
      others.forEach((one, at) => parts.push(at ? ", " : "; then ", make("b", {}, one.name), costInWords(one)));
      parts.push(". ");
    }
    const failing = otherEngines()
      .map((engine) => ({ name: firstOf(engine), ...scoreOf(firstOf(engine), state.tol) }))
      .filter(({ within, flown }) => within < flown);
    const [left, asked] = [true, false].map((isDefault) => failing.filter(({ name }) => ENGINE_DEFAULTS.has(FIELD.get(name).engine) === isDefault));
    const managed = [left.length && managedInWords(left), asked.length && askedInWords(asked)].filter(Boolean);
    if (managed.length) parts.push(`At the scenes' own steps, ${managed.join("; ")}.`);
    host.replaceChildren(...parts, ...stiffClause());
  });
}

/** How many throws engines manage as they come; of several that manage none, only their names. */
function managedInWords(failing) {
  const none = failing.filter(({ within }) => !within).map(({ name }) => FIELD.get(name).engine);
  if (none.length === failing.length && none.length > 2) return `left at their defaults, ${listed(none)} manage none`;
  const told = none.length > 2 ? failing.filter(({ within }) => within) : failing;
  const each = told.map(({ name, within, flown }, at) => `${FIELD.get(name).engine}${at ? "" : " manages"} ${within} of ${flown}${at ? "" : " throws"}`);
  return `left at its default, ${listed(each)}${told.length < failing.length ? `; ${listed(none)} none` : ""}`;
}

/** The same of contestants that are no defaults: the user named them, or their engines have none. */
function askedInWords(failing) {
  return `${failing.every(({ name }) => ASKED.has(name)) ? "as asked, " : ""}${listed(failing.map(({ name, within, flown }, at) => `${name}${at ? "" : " manages"} ${within} of ${flown}${at ? "" : " throws"}`))}`;
}

/** The engines that are not ours and took part in a scene. */
function otherEngines() {
  const named = [...FIELD.values()].filter((one) => !one.ours && !one.byHand).map((one) => one.engine);
  return [...new Set(named)].filter((engine) => firstOf(engine));
}

/** Who is named in the answer: the cheapest of all, then that of each other engine, three at most. */
function answering(tolerance) {
  const reached = cheapest(tolerance);
  return reached.filter(({ engine }, at) => reached.findIndex((other) => other.engine === engine) === at).slice(0, 4);
}

/** Who reaches an error on the swept scene, cheapest first: name, time of its flight, the step that did. */
function cheapest(tolerance, scene = sweptScenes()[0]) {
  const found = [];
  for (const [name, own] of groupBy(rows("sweep-work-precision.csv").filter((run) => run.scene === scene), contestantOf)) {
    if (FIELD.get(name)?.byHand) continue;
    const reaching = own.filter((run) => run.status === "ok" && run.error_m <= tolerance).sort((a, b) => a.run_us - b.run_us);
    if (reaching.length) found.push({ name, engine: FIELD.get(name).engine, run: reaching[0], whole: own.length === 1 });
  }
  return found.sort((a, b) => a.run.run_us - b.run.run_us);
}

function costInWords({ run, whole }) {
  const time = si(run.run_us / 1e6, "s", 2);
  return whole ? ` (${time} a flight, in one step)` : ` (${settingOf(run, 2)}: ${time} a flight)`;
}

/** The die beside the board: the truth and the engine that is furthest off at its default, or as asked. */
function hero(host) {
  const candidates = rows("scenes.csv").map((scene) => scene.scene).filter((scene) => DATA.films[scene]);
  if (!candidates.length) return;
  let stage = null;
  follow(["scene"], () => {
    const scene = candidates.includes(state.scene) ? state.scene : worstScene(candidates);
    stage?.stop();
    host.replaceChildren();
    const worst = worstFirst(scene);
    const ghosts = worst ? [worst.name] : [];
    host.append(make("p", { class: "hero-title" }, make("a", { href: `#scene-${scene}`, click: (event) => openScene(event, scene) }, rows("scenes.csv").find((row) => row.scene === scene).title || scene)));
    stage = player(host, scene, { ghosts: () => ghosts, id: "flight-first", label: `The die of ${scene} in flight: the truth solid${worst ? `, ${worst.name} as a frame` : ""}`, autoplay: true });
    host.append(make("p", { class: "note" }, "Solid: the truth. ", worst ? [markOf(worst.name), ` ${worst.name}${rolesOf(worst.name) ? `, ${rolesOf(worst.name)}` : ""}: up to ${si(worst.error, "m", 2)} off.`] : "Nobody is off."));
  });
}

/** The default that is furthest off in a scene, or what was asked of an engine without one; null where none is off. */
function worstFirst(scene) {
  const film = filmOf(scene);
  const off = firstFindings(scene)
    .map((row) => ({ name: contestantOf(row), error: toldValue(row) }))
    .filter(({ name }) => film.others.has(name))
    .filter(({ error }) => error !== null && Number.isFinite(error) && error > 1e-6 * film.size)
    .sort((a, b) => b.error - a.error);
  return off[0] ?? null;
}

/** What engines did in a scene by default, and of those that took part only as asked what they did so. */
function firstFindings(scene) {
  return [...findings("engine default", scene), ...findings("first method", scene).filter((row) => row.engine !== DATA.byHand && !ENGINE_DEFAULTS.has(row.engine))];
}

/** The scene to begin with: where a first one goes astray enough to be seen, and not out of the picture. */
function worstScene(candidates) {
  const ranked = candidates
    .map((scene) => ({ scene, off: (worstFirst(scene)?.error ?? 0) / filmOf(scene).size, length: filmOf(scene).t.at(-1) }))
    .map((one) => ({ ...one, rank: one.off > 0 ? Math.abs(Math.log10(one.off / 0.6)) + (one.length < 1 ? 1 : 0) : 99 }));
  return ranked.sort((a, b) => a.rank - b.rank)[0].scene;
}
