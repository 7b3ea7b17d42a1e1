// The readings of a scene's sensors, folded: each contestant's over the true ones, and a table of their errors.

import { chart } from "./chart.js";
import { contestantOf, groupBy, nameOf, rows } from "./data.js";
import { draw, make } from "./dom.js";
import { figure, finite, given } from "./numbers.js";
import { state } from "./state.js";
import { foldedTable } from "./table.js";
import { statusInWords } from "./verdicts.js";

const QUANTITIES = [
  { name: "specific force", unit: "m/s²", columns: ["ax_m_s2", "ay_m_s2", "az_m_s2"] },
  { name: "angular velocity", unit: "rad/s", columns: ["wx_rad_s", "wy_rad_s", "wz_rad_s"] },
];

/**
 * @param {Element} host
 * @param {string} scene
 */
export function sensorFold(host, scene) {
  const list = rows("sensors.csv").filter((row) => row.scene === scene);
  const errors = rows("sensor-errors.csv").filter((row) => row.scene === scene);
  if (!errors.length) return;
  const id = `sensors-${scene}`;
  const fold = make("details", { class: "fold", id }, make("summary", {}, `Sensors of ${scene}: what an IMU on the body reads`));
  let made = false;
  const fill = () => {
    if (made || !fold.open) return;
    made = true;
    fold.append(make("p", { class: "note" }, "Specific force is acceleration less gravity, along the sensor's axes: 0 in free fall at the centre of mass. The thick grey line is the true reading."));
    for (const [sensor, own] of groupBy(list, (row) => row.sensor)) for (const quantity of QUANTITIES) reading(fold, `${id}-${sensor}`, sensor, quantity, own);
    errorTable(fold, scene, errors);
  };
  fold.addEventListener("toggle", fill);
  host.append(fold);
  if (state.at.startsWith(id)) fold.open = true;
  fill();
}

/** The magnitude of one quantity of one sensor over time: that of every contestant, and the true one. */
function reading(host, id, sensor, { name, unit, columns }, list) {
  const vector = (row, prefix) => columns.map((column) => row[`${prefix}${column}`]);
  const read = list.filter((row) => vector(row, "").every(finite));
  if (!read.length) return;
  const graph = make("div", { class: "graph" });
  host.append(graph);
  const inWords = (values) => `(${values.map((value) => figure(value, 4)).join(", ")}) ${unit}`;
  const point = (row) => {
    const [seen, true_] = [vector(row, ""), vector(row, "true_")];
    const lines = [`t = ${given(row.t_s)} s`, `reads ${inWords(seen)}`];
    if (true_.every(finite)) lines.push(`true ${inWords(true_)}`, `off by ${figure(Math.hypot(...seen.map((value, at) => value - true_[at])), 2)} ${unit}`);
    return { x: row.t_s, y: Math.hypot(...seen), plain: true, lines };
  };
  const true_ = [...new Map(list.filter((row) => vector(row, "true_").every(finite)).map((row) => [row.t_s, Math.hypot(...vector(row, "true_"))]))].sort(([a], [b]) => a - b);
  chart(graph, {
    id: `${id}-${name.replace(" ", "-")}`,
    label: `Magnitude of the ${name} that the sensor ${sensor} reads, ${unit}`,
    x: { label: "time [s]", show: given },
    y: { label: `${sensor}: ${name}, magnitude [${unit}]`, show: given },
    series: [...groupBy(read, contestantOf)].map(([contestant, own]) => ({ name: contestant, points: own.map(point) })),
    under: ({ X, Y }) => trueCurve(true_, X, Y),
    height: 240,
  });
}

function trueCurve(points, X, Y) {
  if (points.length < 2) return [];
  const line = points.map(([x, y]) => `${X.place(x).toFixed(1)},${Y.place(y).toFixed(1)}`).join("L");
  return [draw("path", { d: `M${line}`, fill: "none", stroke: "var(--ink)", "stroke-width": 5, "stroke-opacity": 0.25, "stroke-linejoin": "round" })];
}

/**
 * @param {Element} host
 * @param {string} scene
 * @param {Tables["sensor-errors.csv"][]} list
 */
function errorTable(host, scene, list) {
  foldedTable(host, {
    id: `sensor-errors-${scene}`,
    caption: `Errors of the sensors of ${scene}`,
    list,
    key: (row) => `${nameOf(row)}-${row.sensor}-${row.quantity}`,
    columns: [
      { key: "method", label: "contestant", words: true, show: nameOf, sort: nameOf },
      { key: "sensor", label: "sensor", words: true },
      { key: "quantity", label: "quantity", words: true },
      { key: "reading", label: "read by", words: true },
      { key: "status", label: "result", words: true, show: (row) => statusInWords(row) },
      { key: "max_error", label: "largest error", show: (row) => (finite(row.max_error) ? `${row.max_error <= (row.resolution ?? 0) ? `≤ ${figure(row.resolution)}` : figure(row.max_error)} ${row.unit === "1" ? "" : row.unit}` : "") },
      { key: "true_max", label: "largest true reading", show: (row) => (finite(row.true_max) ? `${figure(row.true_max)} ${row.unit === "1" ? "" : row.unit}` : "") },
      { key: "left_out", label: "instants left out", show: (row) => (row.left_out === null ? "" : String(row.left_out)) },
    ],
  });
}
