// Table 4.1 of the class report: which column was right, and what each mistake in the other one costs.

import { FONT, roomFor } from "./chart.js";
import { CONTESTANTS } from "./contestants.js";
import { DATA, groupBy, nameOf, numbersFound, rows } from "./data.js";
import { draw, make, whenThemeChanges } from "./dom.js";
import { fixed, given } from "./numbers.js";
import { figureTools } from "./save.js";
import { shown } from "./selection.js";
import { follow } from "./state.js";
import { foldedTable } from "./table.js";
import { showTooltip } from "./tooltip.js";

const MISTAKES = {
  impulse: "the impulse of 5 N s was treated as a constant force of 5 N",
  vertex: "the vertex was not measured from the centre of mass",
  clock: "time was read off the screen, which runs ahead of the physics steps",
};

export function courseworkSection(host) {
  const budget = rows("table-4-1-budget.csv");
  const scene = budget[0]?.scene;
  const own = budget.filter((row) => row.scene === scene);
  host.append(make("p", { class: "headline" }, courseworkHeadline(scene)));
  const hand = own.filter((row) => row.engine === DATA.byHand);
  if (hand.length) {
    const beside = own.filter((row) => row.engine !== DATA.byHand && CONTESTANTS.has(nameOf(row)));
    host.append(make("dl", { class: "facts" }, Object.entries(MISTAKES).map(([name, words]) => make("div", {}, make("dt", {}, name), make("dd", {}, words)))));
    correctionBars(host, hand, beside);
  }
  foldedTable(host, {
    id: "table-4-1",
    caption: "Table 4.1, as printed and recomputed",
    list: rows("table-4-1.csv").filter((row) => row.scene === scene && (row.engine === "exact" || row.engine === DATA.byHand)),
    key: (row) => `${nameOf(row)}-${row.t_clock_s}`,
    columns: [
      { key: "engine", label: "calculated by", words: true, show: nameOf, sort: nameOf },
      { key: "t_clock_s", label: "t on screen", unit: "s", show: (row) => given(row.t_clock_s) },
      { key: "x_m", label: "recomputed", unit: "m", words: true, show: (row) => vector(row, "") },
      { key: "calculated_x_m", label: "printed: calculated", unit: "m", words: true, show: (row) => vector(row, "calculated_") },
      { key: "application_x_m", label: "printed: application", unit: "m", words: true, show: (row) => vector(row, "application_") },
      { key: "to_calculated_m", label: "from calculated", unit: "m" },
      { key: "to_application_m", label: "from application", unit: "m" },
    ],
  });
}

/**
 * @param {Tables["table-4-1.csv"]} row
 * @param {string} prefix
 */
function vector(row, prefix) {
  return `(${["x", "y", "z"].map((axis) => fixed(row[`${prefix}${axis}_m`], 2)).join(", ")})`;
}

function courseworkHeadline(scene) {
  const [right] = numbersFound("right column", scene);
  const [wrong] = numbersFound("wrong column", scene);
  if (!right) return "Neither column of the table is the exact motion.";
  const names = { application: "Unity application", calculated: "hand calculation" };
  return `Its ${names[right.other]} was right and its ${names[wrong.other]} was not: exact motion stays within ${right.value.toFixed(3)} m of the ${right.other} positions and is up to ${wrong.value.toFixed(3)} m from the ${wrong.other} ones.`;
}

/**
 * The distance of the hand calculation from the application as its mistakes are corrected, beside the contestants shown.
 * @param {Element} host
 * @param {Tables["table-4-1-budget.csv"][]} hand
 * @param {Tables["table-4-1-budget.csv"][]} beside
 */
function correctionBars(host, hand, beside) {
  const svg = draw("svg", { class: "chart", role: "img", id: "corrections-figure", "aria-label": "Distance of the hand calculation from the application, as mistakes are corrected" });
  const box = make("figure", { class: "chart-box" }, svg, make("figcaption", {}, "Largest distance from the application’s positions: eq. 4.1 with its mistakes corrected one by one, and the contestants shown."), figureTools("corrections-figure", () => svg));
  host.append(box);
  const most = Math.max(...hand.map((row) => row.max_to_application_m));
  const render = () => {
    const width = Math.max(280, box.clientWidth || 600);
    const names = shown();
    // Contestants of the same rounded distance share a bar.
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
          { pointermove: (event) => showTooltip([`${distance} m from the application's positions`, ...own.map(barName)], event), pointerleave: () => showTooltip(null) },
          draw("rect", { x: 0, y: y - 3, width, height: 22, fill: "transparent" }),
          draw("text", { x: left - 8, y: y + 13, "text-anchor": "end", fill: "var(--ink)", "font-size": FONT }, label),
          draw("rect", { class: "point", x: left, y, width: Math.max(long, 1), height: 16, fill: row.engine === DATA.byHand ? "var(--warn)" : `var(${CONTESTANTS.get(nameOf(row)).hue})`, "fill-opacity": 0.75, "data-name": names }),
          draw("text", { x: left + long + 6, y: y + 13, fill: "var(--soft)", "font-size": FONT }, `${distance} m`),
        );
      }),
    );
  };
  follow(["show", "tol"], render);
  whenThemeChanges(render);
  new ResizeObserver(render).observe(box);
}

/**
 * The name of a bar: the hand calculation by its corrected mistakes, any other by its contestant.
 * @param {Tables["table-4-1-budget.csv"]} row
 */
function barName(row) {
  return row.engine === DATA.byHand ? row.method.replaceAll("-", " ").replaceAll("+", " + ") : nameOf(row);
}

function barLabel(own) {
  return own.length > 2 ? `${barName(own[0])}, and ${own.length - 1} contestants` : own.map(barName).join(", ");
}
