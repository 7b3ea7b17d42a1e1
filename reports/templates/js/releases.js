// What changed at which release of an engine: the ledger that `tumble releases` left.

const OF_SPEED = "time";
const CHANGE_WORDS = {
  attitude_order: "order of the attitude",
  translation_order: "order of the fall",
  spin_energy: "energy of the spin",
  max_error_m: "largest error",
  status: "status",
  method: "the method",
  [OF_SPEED]: "time of a step",
};

function releasesSections(host) {
  for (const [engine, list] of groupBy(rows("releases.csv"), (row) => row.engine)) releasesSection(host, engine, list);
}

function releasesSection(host, engine, list) {
  const changes = rows("release-changes.csv").filter((row) => row.engine === engine);
  host.append(make("p", { class: "headline" }, releasesAnswer(engine, [...new Set(list.map((row) => row.release))], changes)));
  foldedTable(host, {
    id: `release-changes-${engine}`,
    caption: `What changed at which release of ${engine}`,
    list: changes,
    key: (row) => `${row.release}-${row.method}-${row.what}`,
    columns: [
      { key: "release", label: "release", words: true, sort: (row) => list.findIndex((each) => each.release === row.release) },
      { key: "method", label: "method", words: true },
      { key: "what", label: "what", words: true, show: (row) => CHANGE_WORDS[row.what] ?? row.what },
      { key: "old", label: "it was", words: true },
      { key: "new", label: "it is", words: true },
      { key: "scenes", label: "in", words: true, show: (row) => (row.what === OF_SPEED ? "" : row.scenes) },
      { key: "notes", label: "its own notes", words: true },
    ],
  });
  foldedTable(host, {
    id: `releases-${engine}`,
    caption: `Every release of ${engine} in every scene`,
    list,
    key: (row) => `${row.release}-${row.scene}-${row.method}`,
    columns: [
      { key: "release", label: "release", words: true, sort: (row) => list.indexOf(row) },
      { key: "scene", label: "scene", words: true },
      { key: "method", label: "method", words: true },
      { key: "attitude_order", label: "order", show: (row) => (row.attitude_order === null ? "" : row.attitude_order.toFixed(1)) },
      { key: "max_error_m", label: "largest error", unit: "m", show: (row) => (row.status === "ok" ? figure(errorOf(row)) : inWords(row)) },
      { key: "spin_energy", label: "energy of the spin", words: true },
      { key: "step_ns", label: "time of a step", unit: "ns" },
      { key: "time_ratio", label: "over the newest", show: (row) => times(row.time_ratio) },
      { key: "time_ratio_low", label: "95 in 100", words: true, show: (row) => interval(row.time_ratio_low, row.time_ratio_high) },
    ],
  });
}

/** Which releases fly otherwise than the one before; their speed is another matter. */
function releasesAnswer(engine, releases, changes) {
  const physics = [...new Set(changes.filter((row) => row.what !== OF_SPEED).map((row) => row.release))];
  const span = `${engine}, ${counted(releases.length, "release")} from ${releases[0]} to ${releases.at(-1)}`;
  if (!physics.length) return `${span}: none flies otherwise than the one before it.`;
  const rest = physics.length === releases.length - 1 ? "" : "; the others do not";
  return `${span}: ${listed(physics)} ${physics.length > 1 ? "fly" : "flies"} otherwise than the one before${rest}.`;
}
