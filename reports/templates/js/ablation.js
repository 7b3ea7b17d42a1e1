// What unneeded features cost: the time of a step with a feature that a scene does not need, over the time without.

import { contestantOf, nameOf, numbersFound, rows } from "./data.js";
import { make } from "./dom.js";
import { interval, times } from "./numbers.js";
import { foldedTable } from "./table.js";

export function ablationSection(host) {
  const all = rows("ablation.csv");
  const [first] = numbersFound("feature overhead").sort((a, b) => b.value - a.value);
  host.append(make("p", { class: "headline" }, first ? `In ${first.scene}, which needs few features, a step of ${contestantOf(first)} takes ${times(first.value)} as long with all features on.` : "No contestant is measurably faster with features off."));
  foldedTable(host, {
    id: "ablation",
    caption: "Time per step with and without features that the scene does not need",
    list: all,
    key: (row) => `${row.scene}-${nameOf(row)}-${row.feature}`,
    columns: [
      { key: "method", label: "contestant", words: true, show: nameOf, sort: nameOf },
      { key: "feature", label: "feature", words: true, show: (row) => row.feature || row.why },
      { key: "cpu_ns_per_step_with", label: "with", unit: "ns" },
      { key: "cpu_ns_per_step_without", label: "without", unit: "ns" },
      { key: "ratio", label: "ratio", show: (row) => times(row.ratio) },
      { key: "ratio_low", label: "95 % interval", words: true, show: (row) => interval(row.ratio_low, row.ratio_high) },
      { key: "max_difference_m", label: "largest difference of positions", unit: "m" },
    ],
  });
}
