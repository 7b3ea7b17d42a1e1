// What changed from one folder of tables to another: runs, and what they were measured on.

function changesSection(host) {
  const runs = rows("changed-runs.csv");
  const conditions = rows("changed-conditions.csv").filter((row) => row.what !== "command");
  const worse = runs.filter((row) => row.ratio > 1).sort((a, b) => b.ratio - a.ratio);
  const better = runs.filter((row) => row.ratio < 1).sort((a, b) => a.ratio - b.ratio);
  const said = [`${counted(runs.length, "run")} changed: ${worse.length} further off, ${better.length} nearer`];
  if (worse.length) said.push(`most the worse ${nameOf(worse[0])} in ${worse[0].scene}, from ${si(worse[0].max_error_m_before, "m")} to ${si(worse[0].max_error_m_after, "m")}`);
  if (better.length) said.push(`most the better ${nameOf(better[0])} in ${better[0].scene}, from ${si(better[0].max_error_m_before, "m")} to ${si(better[0].max_error_m_after, "m")}`);
  host.append(make("p", { class: "headline" }, runs.length ? `${said.join("; ")}.` : "No run changed."));
  if (conditions.length) host.append(make("dl", { class: "facts" }, conditions.map((row) => make("div", {}, make("dt", {}, row.what), make("dd", {}, `${row.value_before || "nothing"} → ${row.value_after || "nothing"}`)))));
  foldedTable(host, {
    id: "changed-runs",
    caption: "Runs that changed",
    list: [...worse, ...better, ...runs.filter((row) => !(row.ratio > 1 || row.ratio < 1))],
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
