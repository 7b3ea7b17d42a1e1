// What changed at which release of an engine, from the tables of `tumble releases`.

import { chart } from "./chart.js";
import { contestantOf, errorOf, groupBy, rows } from "./data.js";
import { draw, make } from "./dom.js";
import { counted, figure, interval, listed, si, times } from "./numbers.js";
import { foldedTable } from "./table.js";
import { statusInWords } from "./verdicts.js";

const OF_SPEED = "time";

const CHANGE_WORDS = {
  attitude_order: "order of attitude",
  translation_order: "order of translation",
  spin_energy: "spin energy",
  max_error_m: "largest error",
  status: "status",
  method: "method",
  [OF_SPEED]: "time per step",
};

export function releasesSections(host) {
  for (const [engine, list] of groupBy(rows("releases.csv"), (row) => row.engine)) releasesSection(host, engine, list);
}

/**
 * @param {Element} host
 * @param {string} engine
 * @param {Tables["releases.csv"][]} list
 */
function releasesSection(host, engine, list) {
  const changes = rows("release-changes.csv").filter((row) => row.engine === engine);
  const releases = [...new Set(list.map((row) => row.release))];
  host.append(make("p", { class: "headline" }, releasesAnswer(engine, releases, changes)));
  releaseCharts(host, engine, list, releases, changes);
  foldedTable(host, {
    id: `release-changes-${engine}`,
    caption: `Changes between releases of ${engine}`,
    list: changes,
    key: (row) => `${row.release}-${row.method}-${row.what}`,
    columns: [
      { key: "release", label: "release", words: true, sort: (row) => list.findIndex((each) => each.release === row.release) },
      { key: "method", label: "method", words: true },
      { key: "what", label: "what", words: true, show: (row) => CHANGE_WORDS[row.what] ?? row.what },
      { key: "old", label: "before", words: true },
      { key: "new", label: "after", words: true },
      { key: "scenes", label: "scenes", words: true, show: (row) => (row.what === OF_SPEED ? "" : row.scenes) },
      { key: "notes", label: "release notes", words: true },
    ],
  });
  foldedTable(host, {
    id: `releases-${engine}`,
    caption: `All runs of ${engine}`,
    list,
    key: (row) => `${row.release}-${row.scene}-${row.method}`,
    columns: [
      { key: "release", label: "release", words: true, sort: (row) => list.indexOf(row) },
      { key: "scene", label: "scene", words: true },
      { key: "method", label: "method", words: true },
      { key: "attitude_order", label: "order", show: (row) => (row.attitude_order === null ? "" : row.attitude_order.toFixed(1)) },
      { key: "max_error_m", label: "largest error", unit: "m", show: (row) => (row.status === "ok" ? figure(errorOf(row)) : statusInWords(row)) },
      { key: "spin_energy", label: "spin energy", words: true },
      { key: "step_ns", label: "time per step", unit: "ns" },
      { key: "time_ratio", label: "ratio to newest", show: (row) => times(row.time_ratio) },
      { key: "time_ratio_low", label: "95 % interval", words: true, show: (row) => interval(row.time_ratio_low, row.time_ratio_high) },
    ],
  });
}

/**
 * The order of attitude and the largest error in each scene against the release; a dashed line where one changed.
 * @param {Element} host
 * @param {string} engine
 * @param {Tables["releases.csv"][]} list
 * @param {string[]} releases
 * @param {Tables["release-changes.csv"][]} changes
 */
function releaseCharts(host, engine, list, releases, changes) {
  const box = make("div", { class: "multiples" });
  host.append(box);
  const changed = new Set(changes.filter((row) => row.what !== OF_SPEED).map((row) => releases.indexOf(row.release)));
  const under = ({ X, area }) => [...changed].map((at) => draw("line", { x1: X.place(at - 0.5), x2: X.place(at - 0.5), y1: area.top, y2: area.bottom, stroke: "var(--warn)", "stroke-dasharray": "3 4" }));
  const of = (own, y) => own.map((row) => ({ x: releases.indexOf(row.release), y: y(row), plain: row.status === "ok", lines: releaseTooltip(row) })).filter((point) => point.y > 0 && Number.isFinite(point.y)).sort((a, b) => a.x - b.x);
  const series = (own, y) => [...groupBy(own, contestantOf)].map(([name, runs]) => ({ name, points: of(runs, y) }));
  const x = { label: `release of ${engine}`, ticks: releases.map((_, at) => at), show: (at) => releases[at] };
  const range = [-0.5, releases.length - 0.5];
  const scenes = [...groupBy(list, (row) => row.scene)];
  const ordered = scenes.find(([, own]) => own.some((row) => row.attitude_order !== null));
  if (ordered)
    chart(box, {
      id: `release-orders-${engine}`,
      label: `Order of attitude of each method of ${engine} against its release, in ${ordered[0]}`,
      x,
      y: { label: `order of attitude, ${ordered[0]}`, ticks: [0, 1, 2, 3, 4, 5, 6, 7, 8], show: String },
      series: series(ordered[1], (row) => row.attitude_order),
      under,
      range,
    });
  for (const [scene, own] of scenes)
    chart(box, {
      id: `release-errors-${engine}-${scene}`,
      label: `Largest vertex error of each method of ${engine} against its release, in ${scene}`,
      x,
      y: { label: `largest vertex error, ${scene}`, log: true, show: (value) => si(value, "m", 1) },
      series: series(own, errorOf),
      under,
      range,
    });
  host.append(make("p", { class: "note" }, "Dashed line: results differ from those of the previous release."));
}

/**
 * @param {Tables["releases.csv"]} row
 */
function releaseTooltip(row) {
  return [`${row.release}, ${row.scene}`, `error ${figure(errorOf(row))} m`, row.attitude_order === null ? "" : `order ${row.attitude_order.toFixed(1)}`, row.status === "ok" ? "" : statusInWords(row)].filter(Boolean);
}

/**
 * Which releases behave differently from the previous one; speed does not count.
 * @param {string} engine
 * @param {string[]} releases
 * @param {Tables["release-changes.csv"][]} changes
 */
function releasesAnswer(engine, releases, changes) {
  const physics = [...new Set(changes.filter((row) => row.what !== OF_SPEED).map((row) => row.release))];
  const span = `${engine}, ${counted(releases.length, "release")} from ${releases[0]} to ${releases.at(-1)}`;
  if (!physics.length) return `${span}: each behaves like the previous one.`;
  return `${span}: ${listed(physics)} ${physics.length > 1 ? "behave" : "behaves"} differently from the previous release.`;
}
