// How long a step each contestant bears: measured limits beside theory's, maps, and extreme cases.

// What stands in a cell, so that nobody needs the colour, and what it means: from good to bad.
const STABILITY = {
  stable: ["", "stable"],
  damped: ["↓", "loses energy that physics keeps"],
  drifting: ["↑", "energy or momentum leaves its band"],
  "under-rotated": ["↺", "turns less than its angular velocity says"],
  "lost-torque": ["∅", "lost its torque"],
  diverged: ["×", "blew up"],
  clamped: ["■", "a clamp hides the blow-up"],
  frozen: ["◆", "froze"],
  reset: ["←", "was reset to a start"],
  "no-return": ["?", "no return in the time given"],
  refused: ["–", "refused"],
};

function stableSections(host) {
  const scenes = [...new Set(rows("limits.csv").map((row) => row.scene))];
  const box = make("div", { class: "multiples" });
  host.append(make("p", { class: "headline" }, stableHeadline()), box);
  for (const scene of scenes) limitChart(box, scene);
  for (const scene of scenes) mapsOf(host, scene);
  for (const scene of scenes) limitTable(host, scene);
  extremeTable(host);
}

function stableHeadline() {
  const [most] = findings("longest step").sort((a, b) => b.value - a.value);
  const [least] = findings("shortest step").sort((a, b) => a.value - b.value);
  if (!most) return "How long a step each contestant bears on its stiffest spring.";
  const beyond = rows("limits.csv").find((row) => row.scene === least.scene && nameOf(row) === nameOf(least)).beyond;
  return `With ω the stiffest mode's rate, ${nameOf(most)} bears steps of up to ω·dt = ${figure(most.value)} (${most.scene}) and ${nameOf(least)} of ${figure(least.value)} (${least.scene}); beyond that: ${STABILITY[beyond]?.[1] ?? beyond}.`;
}

/** One scene's limits: a mark where each was measured, a bar where theory puts it. */
function limitChart(host, scene) {
  const limits = rows("limits.csv").filter((row) => row.scene === scene && row.w_dt_limit > 0 && FIELD.has(contestantOf(row)));
  if (!limits.length) return;
  const id = `limits-${scene}`;
  const svg = draw("svg", { class: "chart", role: "img", id: `${id}-figure`, "aria-label": `Largest stable step of each contestant in ${scene}, in radians of the stiffest mode` });
  const box = make("figure", { class: "chart-box" }, make("figcaption", {}, rows("scenes.csv").find((row) => row.scene === scene)?.title ?? scene), svg, figureTools(`${id}-figure`, () => svg));
  host.append(box);
  const render = () => {
    const names = shown();
    const own = limits.filter((row) => names.has(contestantOf(row))).sort((a, b) => b.w_dt_limit - a.w_dt_limit);
    const width = Math.max(280, box.clientWidth || 400);
    const height = 46 + 20 * own.length;
    const area = { left: roomFor(own.map(contestantOf), width), right: width - 20 };
    const finite = limits.flatMap((row) => [row.w_dt_limit, row.theory_w_dt]).filter((value) => value > 0 && Number.isFinite(value));
    const X = scale({ log: true }, [Math.min(0.5, ...finite) / 1.3, Math.max(4, ...finite) * 1.6], [area.left, area.right]);
    svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
    const parts = [0.1, 0.3, 1, 3, 10, 30, 100, 1000, 10000]
      .filter((value) => X.place(value) >= area.left && X.place(value) <= area.right)
      .flatMap((value) => [
        draw("line", { x1: X.place(value), x2: X.place(value), y1: 4, y2: height - 36, stroke: "var(--rule)" }),
        draw("text", { x: X.place(value), y: height - 22, "text-anchor": "middle", fill: "var(--soft)", "font-size": FONT }, given(value)),
      ]);
    parts.push(draw("text", { x: (area.left + area.right) / 2, y: height - 5, "text-anchor": "middle", fill: "var(--soft)", "font-size": FONT }, "largest stable step, ω·dt [rad]"));
    own.forEach((row, at) => parts.push(limitLine(row, 14 + 20 * at, area, X)));
    svg.replaceChildren(...parts);
  };
  follow(["show", "tol"], render);
  whenThemeChanges(render);
  new ResizeObserver(render).observe(box);
}

function limitLine(row, y, area, X) {
  const name = contestantOf(row);
  const hue = `var(${FIELD.get(name).hue})`;
  const endless = !Number.isFinite(row.w_dt_limit);
  const at = endless ? area.right : X.place(row.w_dt_limit);
  const said = [name, `measured ω·dt = ${figure(row.w_dt_limit)}`, row.theory_w_dt ? `theory ${figure(row.theory_w_dt)}` : "", endless ? "no limit" : `then ${STABILITY[row.beyond]?.[1] ?? row.beyond}`].filter(Boolean);
  return draw(
    "g",
    { "data-name": name, pointermove: (event) => tell(said, event), pointerleave: () => tell(null) },
    draw("rect", { x: 0, y: y - 10, width: area.right + 20, height: 20, fill: "transparent" }),
    draw("text", { x: area.left - 10, y: y + 4, "text-anchor": "end", fill: "var(--ink)", "font-size": FONT - 0.5 }, name),
    draw("line", { x1: area.left, x2: at, y1: y, y2: y, stroke: hue, "stroke-width": 2, "stroke-dasharray": FIELD.get(name).dash }),
    row.theory_w_dt > 0 && Number.isFinite(row.theory_w_dt) ? draw("line", { x1: X.place(row.theory_w_dt), x2: X.place(row.theory_w_dt), y1: y - 9, y2: y + 9, stroke: "var(--ink)", "stroke-width": 2.5 }) : "",
    endless ? draw("path", { d: `M${at - 6},${y - 5}L${at + 2},${y}L${at - 6},${y + 5}`, fill: "none", stroke: hue, "stroke-width": 2 }) : draw("path", { class: "point", transform: `translate(${at} ${y}) scale(4)`, d: FIELD.get(name).mark, ...inkOf(name) }),
  );
}

/** The maps of a scene: to the right the step, upwards what makes the scene stiff; those that are alike are one. */
function mapsOf(host, scene) {
  const cells = rows("stability.csv").filter((row) => row.scene === scene);
  if (new Set(cells.map((row) => row.value)).size < 2) return;
  const fold = make("details", { class: "fold", id: `maps-${scene}` }, make("summary", {}, `Maps of ${scene}: step by ${cells[0].parameter}`));
  fold.addEventListener("toggle", () => fold.open && fold.children.length === 1 && fillMaps(fold, cells), { once: true });
  host.append(fold);
}

function fillMaps(fold, cells) {
  const box = make("div", { class: "maps" });
  const alike = new Map();
  for (const [name, own] of groupBy(cells, contestantOf)) {
    if (own.length < 2) continue; // it refused: there is nothing to map
    const key = own.map((row) => `${row.value} ${row.dt_s} ${row.verdict}`).join();
    if (!alike.has(key)) alike.set(key, { names: [], own });
    alike.get(key).names.push(name);
  }
  const theory = new Map(rows("limits.csv").filter((row) => row.scene === cells[0].scene).map((row) => [contestantOf(row), row]));
  const seen = new Set(cells.map((row) => row.verdict));
  fold.append(make("p", { class: "key" }, Object.entries(STABILITY).filter(([word]) => seen.has(word)).map(([word, [sign, meaning]]) => make("span", {}, make("span", { class: `swatch s-${word}` }, sign || "\u00a0"), ` ${meaning}`))), box);
  follow(["show", "tol"], () => {
    const wanted = shown();
    const maps = [...alike.values()].map(({ names, own }) => ({ names: names.filter((name) => wanted.has(name)), own })).filter(({ names }) => names.length);
    box.replaceChildren(...maps.map(({ names, own }) => mapOf(names, own, theory.get(names[0]))));
    if (!maps.length) box.append(make("p", { class: "note" }, "Nobody shown has a map here: choose others above."));
  });
}

function mapOf(names, cells, limit) {
  const values = [...new Set(cells.map((row) => row.value))].sort((a, b) => b - a);
  const longest = new Map(values.map((value) => [value, Math.max(...cells.filter((row) => row.value === value).map((row) => row.dt_s))]));
  const side = 14;
  const columns = (row) => Math.round(Math.log2(longest.get(row.value) / row.dt_s));
  const wide = Math.max(...cells.map(columns)) + 1;
  const broad = Math.max(wide * side, 90);
  const id = `map-${cells[0].scene}-${names[0].replaceAll(":", "-")}`;
  const svg = draw("svg", { id, role: "img", viewBox: `-44 0 ${broad + 48} ${values.length * side + 18}`, width: broad + 48, "aria-label": `Stability of ${names.join(", ")}` });
  const taken = new Map(values.map((value) => [value, cells.filter((row) => row.value === value).map(columns).sort((a, b) => a - b)]));
  for (const row of cells) {
    // Where few steps were flown a cell reaches half way to its neighbours.
    const [column, flown] = [columns(row), taken.get(row.value)];
    const at = flown.indexOf(column);
    const later = at + 1 < flown.length ? (flown[at + 1] - column) / 2 : 0.5;
    const sooner = at > 0 ? (column - flown[at - 1]) / 2 : 0.5;
    const [x, y, width] = [(wide - 0.5 - column - later) * side, values.indexOf(row.value) * side, (later + sooner) * side];
    svg.append(
      draw(
        "g",
        { pointermove: (event) => tell([names.join(", "), `${row.parameter} ${figure(row.value)}, step ${figure(row.dt_s)} s`, STABILITY[row.verdict]?.[1] ?? row.verdict, row.max_error_m === null ? "" : `${figure(row.max_error_m)} m off`].filter(Boolean), event), pointerleave: () => tell(null) },
        draw("rect", { x, y, width: width - 1, height: side - 1, class: `s-${row.verdict}` }),
        draw("text", { x: (wide - 0.5 - column) * side - 0.5, y: y + side - 4, "text-anchor": "middle", "font-size": 10, fill: "var(--ink)" }, STABILITY[row.verdict]?.[0] ?? ""),
      ),
    );
  }
  values.forEach((value, at) => svg.append(draw("text", { x: -4, y: at * side + side - 4, "text-anchor": "end", "font-size": 9, fill: "var(--soft)" }, figure(value, 2))));
  if (limit?.theory_w_dt > 0 && Number.isFinite(limit.theory_w_dt)) {
    const own = cells.filter((row) => row.value === limit.value);
    const most = Math.max(...own.map((row) => row.dt_s)) * limit.w_rad_s;
    const x = (wide - 1 - Math.log2(most / limit.theory_w_dt)) * side + side / 2;
    svg.append(draw("path", { d: `M${x},0V${values.length * side}`, stroke: "var(--ink)", "stroke-width": 2.5 }));
  }
  svg.append(draw("text", { x: (wide * side) / 2, y: values.length * side + 13, "text-anchor": "middle", "font-size": 10, fill: "var(--soft)" }, "longer steps →"));
  return make("figure", { class: "map" }, svg, make("figcaption", {}, names.join(", ")), figureTools(id, () => svg));
}

function limitTable(host, scene) {
  foldedTable(host, {
    id: `limits-${scene}`,
    caption: `Largest steps in ${scene}`,
    list: rows("limits.csv").filter((row) => row.scene === scene),
    key: (row) => nameOf(row),
    columns: [
      { key: "method", label: "contestant", words: true, show: nameOf, sort: nameOf },
      { key: "w_dt_limit", label: "limit of ω·dt", show: (row) => figure(row.w_dt_limit) },
      { key: "theory_w_dt", label: "theory", show: (row) => figure(row.theory_w_dt) },
      { key: "beyond", label: "then", words: true, show: (row) => STABILITY[row.beyond]?.[1] ?? row.beyond },
      { key: "dt_stable_s", label: "bounded to", unit: "s" },
      { key: "dt_1pct_s", label: "within 1 %", unit: "s" },
      { key: "dt_1mm_s", label: "within 1 mm", unit: "s" },
      { key: "note", label: "", words: true },
    ],
  });
}

function extremeTable(host) {
  foldedTable(host, {
    id: "extremes",
    caption: "Extreme cases: what becomes of each",
    list: rows("extremes.csv"),
    key: (row) => `${row.scene}-${nameOf(row)}`,
    columns: [
      { key: "scene", label: "case", words: true, show: (row) => row.title || row.scene, sort: (row) => row.scene },
      { key: "method", label: "contestant", words: true, show: nameOf, sort: nameOf },
      { key: "verdict", label: "result", words: true, show: (row) => STABILITY[row.verdict]?.[1] ?? row.verdict },
      { key: "max_error_m", label: "error", unit: "m" },
      { key: "times_limit", label: "over what the truth can tell" },
      { key: "why", label: "why", words: true },
    ],
  });
}
