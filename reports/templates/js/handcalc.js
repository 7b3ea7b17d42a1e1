// Table 4.1 of the class report: which column was right, and what each mistake of the other costs.

const MISTAKES = {
  impulse: "the impulse of 5 N s was taken for a constant force of 5 N",
  vertex: "the vertex was not taken from the centre of mass",
  clock: "time was read off the screen, and physics moves in steps behind it",
};
// One column is called right where the exact motion is so many times nearer to it than to the other.
const NEARER = 10;

function reportSection(host) {
  const budget = rows("table-4-1-budget.csv");
  const scene = budget[0]?.scene;
  const own = budget.filter((row) => row.scene === scene);
  const exact = own.find((row) => row.engine === "exact");
  host.append(make("p", { class: "headline" }, exact ? reportHeadline(exact) : "The exact motion was not worked out."));
  const hand = own.filter((row) => row.engine === DATA.byHand);
  if (hand.length) {
    host.append(make("dl", { class: "facts" }, Object.entries(MISTAKES).map(([name, words]) => make("div", {}, make("dt", {}, name), make("dd", {}, words)))));
    mendingBars(host, hand);
  }
  foldedTable(host, {
    id: "table-4-1",
    caption: "Table 4.1, as printed and recomputed",
    list: rows("table-4-1.csv").filter((row) => row.scene === scene && (row.engine === "exact" || row.engine === DATA.byHand)),
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
  return `(${["x", "y", "z"].map((axis) => row[`${prefix}${axis}_m`].toFixed(2).replace("-", MINUS)).join(", ")})`;
}

function reportHeadline({ max_to_application_m: shownAt, max_to_calculated_m: calculated }) {
  let who = "Neither column of the table is the exact motion";
  if (shownAt * NEARER < calculated) who = "Its Unity application was right and its hand calculation was not";
  else if (calculated * NEARER < shownAt) who = "Its hand calculation was right and its Unity application was not";
  return `${who}: exact motion stays within ${shownAt.toFixed(3)} m of the application's positions and comes as far as ${calculated.toFixed(3)} m from the calculated ones.`;
}

/** How far the hand calculation is from the application as its mistakes are mended, one by one and together. */
function mendingBars(host, hand) {
  const svg = draw("svg", { class: "chart", role: "img", id: "mending-figure", "aria-label": "Distance of the hand calculation from the application, as mistakes are mended" });
  const box = make("figure", { class: "chart-box" }, svg, make("figcaption", {}, "Largest distance of eq. 4.1 from the application's positions."), figureTools("mending-figure", () => svg));
  host.append(box);
  const most = Math.max(...hand.map((row) => row.max_to_application_m));
  const render = () => {
    const width = Math.max(280, box.clientWidth || 600);
    const left = Math.min(200, width * 0.45);
    svg.setAttribute("viewBox", `0 0 ${width} ${22 * hand.length + 6}`);
    svg.replaceChildren(
      ...hand.map((row, at) => {
        const y = 4 + 22 * at;
        const long = ((width - left - 70) * row.max_to_application_m) / most;
        return draw(
          "g",
          {},
          draw("text", { x: left - 8, y: y + 13, "text-anchor": "end", fill: "var(--ink)", "font-size": FONT }, row.method.replaceAll("-", " ").replaceAll("+", " + ")),
          draw("rect", { class: "point", x: left, y, width: Math.max(long, 1), height: 16, fill: "var(--warn)", "fill-opacity": 0.75 }),
          draw("text", { x: left + long + 6, y: y + 13, fill: "var(--soft)", "font-size": FONT }, `${row.max_to_application_m.toFixed(3)} m`),
        );
      }),
    );
  };
  render();
  new ResizeObserver(render).observe(box);
}

/** The body whose rotation nobody repairs, beside one that stays rigid, both in flight. */
function matrixSection(host) {
  const bent = Object.keys(DATA.films)
    .map((scene) => ({ scene, film: filmOf(scene) }))
    .flatMap(({ scene, film }) => [...film.others].filter(([, one]) => one.vertices).map(([name, one]) => ({ scene, name, film, off: stretch(film, one.vertices.at(-1)) })))
    .filter(({ film, off }) => film.body.shape === "box" && Number.isFinite(off))
    .sort((a, b) => Math.abs(Math.log(a.off / 1.5)) - Math.abs(Math.log(b.off / 1.5)))[0];
  if (!bent) return false;
  const { scene, name, film, off } = bent;
  const rigid = name.replace("matrix", "quaternion");
  host.append(
    make("p", { class: "headline" }, `It stops being one: in ${scene} ${name} ends with an edge ${off.toFixed(2)} times as long as it was, with the same step with which ${film.others.has(rigid) ? rigid : "the truth"} keeps the die whole.`),
  );
  const pair = make("div", { class: "pair" });
  for (const [who, words] of [[name, "the matrix, nobody mends it"], [rigid, "the quaternion, set to length 1 each step"]]) {
    if (!film.others.has(who)) continue;
    const box = make("figure");
    pair.append(box);
    player(box, scene, { ghosts: () => [who], label: `${who} in ${scene}`, alone: true, controls: who === name });
    box.append(make("figcaption", {}, markOf(who), ` ${who}: ${words}`));
  }
  host.append(pair);
  return true;
}

/** The edge that is furthest from its true length, over that length. */
function stretch(film, vertices) {
  let worst = 1;
  for (const { ends: [a, b] } of film.edges) {
    const own = Math.hypot(...[0, 1, 2].map((i) => vertices[3 * a + i] - vertices[3 * b + i]));
    const ratio = own / Math.hypot(...minus(film.points[a], film.points[b]));
    if (Math.abs(Math.log(ratio)) > Math.abs(Math.log(worst))) worst = ratio;
  }
  return worst;
}
