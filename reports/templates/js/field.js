// Who takes part: one colour and one mark each on every figure, and who of them is shown.

// Okabe and Ito's colours, told apart by colour-blind readers; DATA.places says which is whose, on every page the same.
const HUES = ["--hue-1", "--hue-2", "--hue-3", "--hue-4", "--hue-5", "--hue-6"];
// Units about the origin; a contestant's mark is its own within its engine, so colour is never all.
const MARKS = [
  "M-1,0A1,1,0,1,1,1,0A1,1,0,1,1,-1,0Z",
  "M-.9,-.9L.9,-.9L.9,.9L-.9,.9Z",
  "M0,-1.15L1.1,.85L-1.1,.85Z",
  "M0,-1.3L1.1,0L0,1.3L-1.1,0Z",
  "M0,1.15L1.1,-.85L-1.1,-.85Z",
  "M-.35,-1.1L.35,-1.1L.35,-.35L1.1,-.35L1.1,.35L.35,.35L.35,1.1L-.35,1.1L-.35,.35L-1.1,.35L-1.1,-.35L-.35,-.35Z",
];
const CROSS = "M-1,-1L1,1M-1,1L1,-1";
const DASHES = ["", "7 3", "2 3", "9 3 2 3", "5 2 5 2 1 2", "1 2"];

/** Everybody in any table, by name: engine, method, manner (tuned, defaults, held), colour, mark and dash. */
const FIELD = field();

function field() {
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
function brokenName(name) {
  const [engine, ...rest] = name.split(":");
  return rest.length ? [`${engine}:`, make("wbr"), rest.join(":")] : [name];
}

function colourOf(name) {
  return styleOf(FIELD.get(name)?.hue ?? "--soft");
}

/** How a mark is filled: there are more engines than colours, and those that share one differ in this. */
function inkOf(name) {
  const one = FIELD.get(name);
  const hue = `var(${one?.hue ?? "--soft"})`;
  const edge = { stroke: hue, "stroke-width": 0.5 };
  return [{ fill: hue }, { fill: "var(--paper)", ...edge }, { fill: hue, "fill-opacity": 0.4, ...edge }][Math.min(one?.round ?? 0, 2)];
}

/** A contestant's mark as a small picture. */
function markOf(name, size = 12) {
  const one = FIELD.get(name);
  return draw(
    "svg",
    { viewBox: "-1.6 -1.6 3.2 3.2", width: size, height: size, class: "mark", "aria-hidden": "true" },
    draw("path", { d: one?.mark ?? MARKS[0], ...inkOf(name) }),
  );
}

/** What an engine does where its user sets nothing, by engine; of those that took part so. */
const ENGINE_DEFAULTS = new Map(findings("engine default").map((row) => [row.engine, contestantOf(row)]).filter(([, name]) => FIELD.has(name)));

/** Who took part because the user named them. */
const ASKED = new Set(findings("named method").map(contestantOf));

/** Its default, or, of an engine without one, its first contestant. */
const firstOf = (engine) => ENGINE_DEFAULTS.get(engine) ?? [...FIELD.values()].find((one) => one.engine === engine && RUNS.has(one.name))?.name;

const RUNS = groupBy(rows("runs.csv"), contestantOf);

/** How many scenes a contestant finished within the tolerance, and the sum of its errors' digits. */
function scoreOf(name, tolerance) {
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

/** An engine's best: within the tolerance in most scenes, of those the one of smallest errors; null if none flew. */
function bestOf(engine, tolerance) {
  const own = [...FIELD.values()].filter((one) => one.engine === engine && one.manner === "tuned" && !one.byHand);
  const ranked = own
    .map((one) => ({ name: one.name, ...scoreOf(one.name, tolerance) }))
    .filter((one) => one.flown)
    .sort((a, b) => b.within - a.within || a.digits - b.digits);
  return ranked[0]?.name ?? null;
}

/** Engines' defaults and bests: who is shown unless the reader asks for others. */
function leading(tolerance = state.tol) {
  const names = [];
  for (const engine of new Set([...FIELD.values()].filter((one) => !one.byHand).map((one) => one.engine))) {
    names.push(firstOf(engine), bestOf(engine, tolerance));
  }
  names.push(...answering(tolerance).map(({ name }) => name)); // who is named in the answer has a row
  const found = [...new Set(names.filter(Boolean))];
  return found.length ? found : [...FIELD.keys()]; // tables of a sweep or of maps alone know no defaults
}

const PRESETS = {
  best: ["defaults and bests", () => leading()],
  engines: ["engines", () => everyone((one) => !one.ours && !one.byHand)],
  ours: ["ours", () => everyone((one) => one.ours)],
  tuned: ["tuned", () => everyone((one) => one.manner === "tuned")],
  defaults: ["as shipped", () => everyone((one) => one.manner === "defaults")],
  held: ["force held", () => everyone((one) => one.manner === "held")],
  all: ["all", () => everyone(() => true)],
  none: ["none", () => []],
};

function everyone(wanted) {
  return [...FIELD.values()].filter(wanted).map((one) => one.name);
}

/** The names that are shown now, on every figure. */
function shown() {
  const named = state.show.split(",").filter((name) => FIELD.has(name));
  return new Set((PRESETS[state.show] ?? (named.length ? [, () => named] : PRESETS.best))[1]());
}

/** Show these alone. */
function show(names) {
  choose({ show: [...names].join(",") || "none" });
}

/** The chips that say who is shown; each filters every figure. */
function chips(host) {
  const buttons = Object.entries(PRESETS)
    .filter(([key, [, names]]) => key === "none" || names().length)
    .map(([key, [label]]) => make("button", { type: "button", class: "chip", "data-show": key, click: () => choose({ show: key }) }, label));
  host.append(make("span", { class: "chips-title" }, "shown in every figure:"), ...buttons);
  follow(["show"], () => buttons.forEach((button) => button.setAttribute("aria-pressed", button.dataset.show === state.show)));
}

// Who the pointer rests on, in whatever figure: all figures mark the same one.
let picked = "";
const pickers = new Set();
function pick(name) {
  if (name === picked) return;
  picked = name;
  for (const act of pickers) act();
}
