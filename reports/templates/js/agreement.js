// Common errors: contestants that agree with each other far better than with the truth.

import { FONT, scale } from "./chart.js";
import { CONTESTANTS } from "./contestants.js";
import { nameOf, numbersFound, rows } from "./data.js";
import { draw, make, whenThemeChanges } from "./dom.js";
import { figure, si } from "./numbers.js";
import { figureTools } from "./save.js";
import { shown } from "./selection.js";
import { follow } from "./state.js";
import { foldedTable } from "./table.js";
import { showTooltip } from "./tooltip.js";

/**
 * @param {Tables["agreement.csv"]} row
 * @param {"a" | "b"} side
 */
function pairOf(row, side) {
  return nameOf({ engine: row[`engine_${side}`], method: row[`method_${side}`] });
}

export function agreementSection(host) {
  const pairs = rows("agreement.csv");
  const apart = numbersFound("agreement distance").map((row) => ({ ...row, error: numbersFound("agreement error", row.scene)[0].value }));
  const [best] = apart.sort((a, b) => a.value / a.error - b.value / b.error);
  host.append(
    make(
      "p",
      { class: "headline" },
      best
        ? `No: in ${best.scene} ${nameOf(best)} and ${best.other} agree ${best.value ? `to ${si(best.value, "m", 2)}` : "to the last digit"}, and both are ${si(best.error, "m", 2)} from the truth.`
        : "No two engines agree with each other better than with the truth.",
    ),
  );
  if (best) agreementBars(host, apart);
  foldedTable(host, {
    id: "agreement",
    caption: "Pairs that agree far better with each other than with the truth",
    list: pairs,
    key: (row) => `${row.scene}-${pairOf(row, "a")}-${pairOf(row, "b")}`,
    columns: [
      { key: "scene", label: "scene", words: true },
      { key: "a", label: "first", words: true, show: (row) => pairOf(row, "a"), sort: (row) => pairOf(row, "a") },
      { key: "b", label: "second", words: true, show: (row) => pairOf(row, "b"), sort: (row) => pairOf(row, "b") },
      { key: "apart_m", label: "difference", unit: "m" },
      { key: "error_a_m", label: "error of first", unit: "m" },
      { key: "error_b_m", label: "error of second", unit: "m" },
    ],
  });
}

/** For each scene: the difference between two engines, and the larger of their errors. */
function agreementBars(host, apart) {
  const svg = draw("svg", { class: "chart", role: "img", id: "agreement-figure", "aria-label": "Distance of two engines from each other and from the truth, by scene" });
  const box = make("figure", { class: "chart-box" }, svg, make("figcaption", {}, "○ difference between the two engines, ● the larger of their errors."), figureTools("agreement-figure", () => svg));
  host.append(box);
  const render = () => {
    const width = Math.max(280, box.clientWidth || 600);
    const engines = new Set([...shown()].map((name) => CONTESTANTS.get(name).engine));
    const best = apart.filter((row) => engines.has(row.engine) && engines.has(row.other.split(":")[0])).sort((a, b) => b.error - a.error);
    const height = 30 + 19 * Math.max(1, best.length);
    const area = { left: 130, right: width - 14 };
    svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
    if (!best.length) {
      svg.replaceChildren(draw("text", { x: 0, y: 20, fill: "var(--soft)", "font-size": FONT + 1 }, "No two of the engines shown agree better with each other than with the truth: choose more above."));
      return;
    }
    const least = Math.max(1e-18, Math.min(...best.map((row) => row.value || 1e-17)));
    const X = scale({ log: true }, [least / 2, Math.max(...best.map((row) => row.error)) * 2], [area.left, area.right]);
    svg.replaceChildren(
      ...X.ticks.flatMap((value) => [
        draw("line", { x1: X.place(value), x2: X.place(value), y1: 2, y2: height - 22, stroke: "var(--rule)" }),
        ...(Math.round(Math.log10(value)) % 3 ? [] : [draw("text", { x: X.place(value), y: height - 6, "text-anchor": "middle", fill: "var(--soft)", "font-size": FONT }, si(value, "m", 1))]),
      ]),
      ...best.map((row, at) => {
        const y = 12 + 19 * at;
        const [near, far] = [X.place(Math.max(row.value, least)), X.place(row.error)];
        const lines = [row.scene, `${nameOf(row)} and ${row.other}`, `${figure(row.value)} m apart, error ${figure(row.error)} m`];
        return draw(
          "g",
          { pointermove: (event) => showTooltip(lines, event), pointerleave: () => showTooltip(null) },
          draw("rect", { x: 0, y: y - 9, width, height: 18, fill: "transparent" }),
          draw("text", { x: area.left - 8, y: y + 4, "text-anchor": "end", fill: "var(--ink)", "font-size": FONT }, row.scene),
          draw("line", { x1: near, x2: far, y1: y, y2: y, stroke: "var(--soft)" }),
          draw("circle", { class: "point", cx: near, cy: y, r: 4.5, fill: "var(--paper)", stroke: "var(--ink)" }),
          draw("circle", { class: "point", cx: far, cy: y, r: 5, fill: "var(--warn)" }),
        );
      }),
    );
  };
  follow(["show", "tol"], render);
  whenThemeChanges(render);
  new ResizeObserver(render).observe(box);
}
