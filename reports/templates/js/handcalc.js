// Table 4.1 of the class report: which column was right, and what each mistake of the other costs.

const MISTAKES = {
  impulse: "the impulse of 5 N s was taken for a constant force of 5 N",
  vertex: "the vertex was not taken from the centre of mass",
  clock: "time was read off the screen, and physics moves in steps behind it",
};
function reportSection(host) {
  const budget = rows("table-4-1-budget.csv");
  const scene = budget[0]?.scene;
  const own = budget.filter((row) => row.scene === scene);
  host.append(make("p", { class: "headline" }, reportHeadline(scene)));
  const hand = own.filter((row) => row.engine === DATA.byHand);
  if (hand.length) {
    const beside = own.filter((row) => row.engine !== DATA.byHand && FIELD.has(nameOf(row)));
    host.append(make("dl", { class: "facts" }, Object.entries(MISTAKES).map(([name, words]) => make("div", {}, make("dt", {}, name), make("dd", {}, words)))));
    mendingBars(host, hand, beside);
  }
  foldedTable(host, {
    id: "table-4-1",
    caption: "Table 4.1, as printed and recomputed",
    list: rows("table-4-1.csv").filter((row) => row.scene === scene && (row.engine === "exact" || row.engine === DATA.byHand)),
    key: (row) => `${nameOf(row)}-${row.t_clock_s}`,
    columns: [
      { key: "engine", label: "by", words: true, show: nameOf, sort: nameOf },
      { key: "t_clock_s", label: "t on screen", unit: "s", show: (row) => given(row.t_clock_s) },
      { key: "x_m", label: "recomputed", unit: "m", words: true, show: (row) => vector(row, "") },
      { key: "calculated_x_m", label: "printed: calculated", unit: "m", words: true, show: (row) => vector(row, "calculated_") },
      { key: "application_x_m", label: "printed: application", unit: "m", words: true, show: (row) => vector(row, "application_") },
      { key: "to_calculated_m", label: "from the calculated", unit: "m" },
      { key: "to_application_m", label: "from the application", unit: "m" },
    ],
  });
}

function vector(row, prefix) {
  return `(${["x", "y", "z"].map((axis) => fixed(row[`${prefix}${axis}_m`], 2)).join(", ")})`;
}

function reportHeadline(scene) {
  const [right] = findings("right column", scene);
  const [wrong] = findings("wrong column", scene);
  if (!right) return "Neither column of the table is the exact motion.";
  const names = { application: "Unity application", calculated: "hand calculation" };
  return `Its ${names[right.other]} was right and its ${names[wrong.other]} was not: exact motion stays within ${right.value.toFixed(3)} m of the ${right.other} positions and comes as far as ${wrong.value.toFixed(3)} m from the ${wrong.other} ones.`;
}

/** How far the hand calculation is from the application as its mistakes are mended, and whoever is shown beside it. */
function mendingBars(host, hand, beside) {
  const svg = draw("svg", { class: "chart", role: "img", id: "mending-figure", "aria-label": "Distance of the hand calculation from the application, as mistakes are mended" });
  const box = make("figure", { class: "chart-box" }, svg, make("figcaption", {}, "Largest distance from the application's positions: of eq. 4.1 as its mistakes are mended, and of whoever is shown."), figureTools("mending-figure", () => svg));
  host.append(box);
  const most = Math.max(...hand.map((row) => row.max_to_application_m));
  const render = () => {
    const width = Math.max(280, box.clientWidth || 600);
    const names = shown();
    // Those whose distance reads the same share a bar.
    const alike = groupBy([...hand, ...beside.filter((row) => names.has(nameOf(row)))], (row) => row.max_to_application_m.toFixed(3));
    const bars = [...alike].map(([distance, own]) => ({ distance, own, label: barLabel(own) }));
    const left = roomFor(bars.map(({ label }) => label), width);
    svg.setAttribute("viewBox", `0 0 ${width} ${22 * bars.length + 6}`);
    svg.replaceChildren(
      ...bars.map(({ distance, own, label }, at) => {
        const [row] = own;
        const y = 4 + 22 * at;
        const long = ((width - left - 70) * row.max_to_application_m) / most;
        const names = own.map(nameOf).join(" ");
        return draw(
          "g",
          { pointermove: (event) => tell([`${distance} m from the application's positions`, ...own.map(barName)], event), pointerleave: () => tell(null) },
          draw("rect", { x: 0, y: y - 3, width, height: 22, fill: "transparent" }),
          draw("text", { x: left - 8, y: y + 13, "text-anchor": "end", fill: "var(--ink)", "font-size": FONT }, label),
          draw("rect", { class: "point", x: left, y, width: Math.max(long, 1), height: 16, fill: row.engine === DATA.byHand ? "var(--warn)" : `var(${FIELD.get(nameOf(row)).hue})`, "fill-opacity": 0.75, "data-name": names }),
          draw("text", { x: left + long + 6, y: y + 13, fill: "var(--soft)", "font-size": FONT }, `${distance} m`),
        );
      }),
    );
  };
  follow(["show", "tol"], render);
  whenThemeChanges(render);
  new ResizeObserver(render).observe(box);
}

/** Whose bar it is: the hand calculation by the mistakes that are mended in it. */
function barName(row) {
  return row.engine === DATA.byHand ? row.method.replaceAll("-", " ").replaceAll("+", " + ") : nameOf(row);
}

function barLabel(own) {
  return own.length > 2 ? `${barName(own[0])}, and ${own.length - 1} contestants` : own.map(barName).join(", ");
}

/** The body whose rotation nobody repairs, beside one that stays rigid, both in flight. */
function matrixSection(host) {
  const [bent] = findings("edge stretch")
    .map((row) => ({ scene: row.scene, name: contestantOf(row), film: filmOf(row.scene), off: row.value }))
    .filter(({ name, film }) => film?.body.shape === "box" && film.others.get(name)?.vertices)
    .sort((a, b) => Math.abs(Math.log(a.off / 1.5)) - Math.abs(Math.log(b.off / 1.5)));
  if (!bent) return false;
  const { scene, name, film, off } = bent;
  const rigid = name.replace("matrix", "quaternion");
  host.append(
    make("p", { class: "headline" }, `It stops being one: in ${scene} ${name} ends with an edge ${off.toFixed(2)} times as long as it was, with the same step with which ${film.others.has(rigid) ? rigid : "the truth"} keeps the die whole.`),
  );
  const pair = make("div", { class: "pair" });
  const clock = new Clock(film, "matrix", film.t.at(-1)); // at the end, where the difference is
  for (const [who, words] of [[name, "the matrix, nobody mends it"], [rigid, "the quaternion, set to length 1 each step"]]) {
    if (!film.others.has(who)) continue;
    const box = make("figure");
    pair.append(box);
    player(box, scene, { ghosts: () => [who], id: `flight-alone-${who.replaceAll(":", "-")}`, label: `${who} in ${scene}`, alone: true, controls: who === name, clock });
    box.append(make("figcaption", {}, markOf(who), ` ${who}: ${words}`));
  }
  host.append(pair);
  return true;
}
