// What leaving out pays: the time of a step with what a scene has no use for, over the time without.

import { contestantOf, nameOf, numbersFound, rows } from "./data.js";
import { make } from "./dom.js";
import { interval, times } from "./numbers.js";
import { foldedTable } from "./table.js";

export function ablationSection(host) {
  const all = rows("ablation.csv");
  const [first] = numbersFound("left out").sort((a, b) => b.value - a.value);
  host.append(make("p", { class: "headline" }, first ? `In ${first.scene}, which has no use for most of it, ${contestantOf(first)} would take ${times(first.value)} as long a step if it left nothing out.` : "Nobody's step is measurably cheaper for what is left out."));
  foldedTable(host, {
    id: "ablation",
    caption: "Time of a step with what the scene has no use for, and without",
    list: all,
    key: (row) => `${row.scene}-${nameOf(row)}-${row.feature}`,
    columns: [
      { key: "method", label: "contestant", words: true, show: nameOf, sort: nameOf },
      { key: "feature", label: "kept", words: true, show: (row) => row.feature || row.why },
      { key: "cpu_ns_per_step_with", label: "with", unit: "ns" },
      { key: "cpu_ns_per_step_without", label: "without", unit: "ns" },
      { key: "ratio", label: "ratio", show: (row) => times(row.ratio) },
      { key: "ratio_low", label: "95 in 100", words: true, show: (row) => interval(row.ratio_low, row.ratio_high) },
      { key: "max_difference_m", label: "motions apart", unit: "m" },
    ],
  });
}
