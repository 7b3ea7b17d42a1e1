// What changed from one folder of tables to another: runs, and what they were measured on.

import { nameOf, rows } from "./data.js";
import { make } from "./dom.js";
import { counted, si, times } from "./numbers.js";
import { foldedTable } from "./table.js";

export function changesSection(host) {
  const runs = rows("changed-runs.csv");
  const conditions = rows("changed-conditions.csv").filter((row) => row.what !== "command");
  const fresh = runs.filter((row) => row.status_before === "not there");
  const gone = runs.filter((row) => row.status_after === "not there");
  const both = runs.filter((row) => !fresh.includes(row) && !gone.includes(row));
  const ratio = (row) => row.ratio ?? 1;
  const worse = both.filter((row) => ratio(row) > 1).sort((a, b) => ratio(b) - ratio(a));
  const better = both.filter((row) => ratio(row) < 1).sort((a, b) => ratio(a) - ratio(b));
  const said = [both.length ? `${counted(both.length, "run")} changed: ${worse.length} further off, ${better.length} nearer` : "No run that both have has changed"];
  if (worse.length) said.push(`most the worse ${nameOf(worse[0])} in ${worse[0].scene}, from ${si(worse[0].max_error_m_before, "m")} to ${si(worse[0].max_error_m_after, "m")}`);
  if (better.length) said.push(`most the better ${nameOf(better[0])} in ${better[0].scene}, from ${si(better[0].max_error_m_before, "m")} to ${si(better[0].max_error_m_after, "m")}`);
  const [before, after] = ["status_before", "status_after"].map((when) => (row) => ["ok", "flagged"].includes(row[when].split(":")[0]));
  const ended = both.filter((row) => before(row) && !after(row));
  const mended = both.filter((row) => !before(row) && after(row));
  if (ended.length) said.push(`${counted(ended.length, "run")} no longer finished`);
  if (mended.length) said.push(`${counted(mended.length, "run")} finished for the first time`);
  if (fresh.length) said.push(`${counted(fresh.length, "run")} only the later has`);
  if (gone.length) said.push(`${counted(gone.length, "run")} only the earlier had`);
  host.append(make("p", { class: "headline" }, runs.length ? `${said.join("; ")}.` : "No run changed."));
  if (conditions.length) host.append(make("dl", { class: "facts" }, conditions.map((row) => make("div", {}, make("dt", {}, row.what), make("dd", {}, `${row.value_before || "nothing"} → ${row.value_after || "nothing"}`)))));
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
