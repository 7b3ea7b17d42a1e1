// What changed from one folder of tables to another: runs and conditions.

import { nameOf, rows } from "./data.js";
import { make } from "./dom.js";
import { counted, si, times } from "./numbers.js";
import { foldedTable } from "./table.js";

export function changesSection(host) {
  const runs = rows("changed-runs.csv");
  const conditions = rows("changed-conditions.csv").filter((row) => row.what !== "command");
  const added = runs.filter((row) => row.status_before === "not there");
  const removed = runs.filter((row) => row.status_after === "not there");
  const both = runs.filter((row) => !added.includes(row) && !removed.includes(row));
  const ratio = (row) => row.ratio ?? 1;
  const worse = both.filter((row) => ratio(row) > 1).sort((a, b) => ratio(b) - ratio(a));
  const better = both.filter((row) => ratio(row) < 1).sort((a, b) => ratio(a) - ratio(b));
  const clauses = [both.length ? `${counted(both.length, "run")} changed: ${worse.length} less accurate, ${better.length} more accurate` : "No run of both folders changed"];
  if (worse.length) clauses.push(`the largest loss is ${nameOf(worse[0])} in ${worse[0].scene}, from ${si(worse[0].max_error_m_before, "m")} to ${si(worse[0].max_error_m_after, "m")}`);
  if (better.length) clauses.push(`the largest gain is ${nameOf(better[0])} in ${better[0].scene}, from ${si(better[0].max_error_m_before, "m")} to ${si(better[0].max_error_m_after, "m")}`);
  const [before, after] = ["status_before", "status_after"].map((when) => (row) => ["ok", "flagged"].includes(row[when].split(":")[0]));
  const ended = both.filter((row) => before(row) && !after(row));
  const recovered = both.filter((row) => !before(row) && after(row));
  if (ended.length) clauses.push(`${counted(ended.length, "run")} no longer finish${ended.length === 1 ? "es" : ""}`);
  if (recovered.length) clauses.push(`${counted(recovered.length, "run")} now finish${recovered.length === 1 ? "es" : ""}`);
  if (added.length) clauses.push(`${counted(added.length, "run")} only in the new tables`);
  if (removed.length) clauses.push(`${counted(removed.length, "run")} only in the old tables`);
  host.append(make("p", { class: "headline" }, runs.length ? `${clauses.join("; ")}.` : "No run changed."));
  if (conditions.length) host.append(make("dl", { class: "facts" }, conditions.map((row) => make("div", {}, make("dt", {}, row.what), make("dd", {}, `${row.value_before || "none"} → ${row.value_after || "none"}`)))));
  foldedTable(host, {
    id: "changed-runs",
    caption: "Runs that changed",
    list: [...worse, ...better, ...runs.filter((row) => !worse.includes(row) && !better.includes(row))],
    key: (row) => `${row.scene}-${nameOf(row)}`,
    columns: [
      { key: "method", label: "contestant", words: true, show: nameOf, sort: nameOf },
      { key: "scene", label: "scene", words: true },
      { key: "status_before", label: "before", words: true },
      { key: "status_after", label: "after", words: true },
      { key: "max_error_m_before", label: "error before", unit: "m" },
      { key: "max_error_m_after", label: "after", unit: "m" },
      { key: "ratio", label: "ratio", show: (row) => times(row.ratio) },
    ],
  });
}
