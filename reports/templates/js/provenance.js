// How it was measured: the engines and their settings, the machine, and the files.

import { DATA, nameOf, rows } from "./data.js";
import { make } from "./dom.js";
import { counted, listed } from "./numbers.js";
import { foldedTable } from "./table.js";
import { statusInWords } from "./verdicts.js";

export function provenanceSection(host) {
  const engines = rows("engines.csv");
  const here = engines.filter((engine) => engine.status === "ok");
  const names = [...new Set(here.map((engine) => engine.engine.split("@")[0]))];
  const engineCount = names.length < here.length ? `${counted(here.length, "release")} of ${listed(names)}` : `${counted(here.length, "engine")} at the releases below`;
  host.append(make("p", { class: "headline" }, `${engineCount}, each in its own process. Every vertex is compared with a truth that no engine was used to compute.`));
  foldedTable(host, {
    id: "engines",
    caption: "Engines: release, methods, and what was switched off for a fair comparison",
    list: engines,
    key: (row) => row.engine,
    columns: [
      { key: "engine", label: "engine", words: true },
      { key: "version", label: "release", words: true, show: (row) => row.version || statusInWords(row) },
      { key: "precision", label: "precision", words: true },
      { key: "methods", label: "methods", words: true },
      { key: "features", label: "forces", words: true, show: (row) => row.features || "none" },
      { key: "switched_off", label: "switched off", words: true, show: (row) => row.switched_off || "none" },
    ],
  });
  const flagged = rows("runs.csv").filter((run) => run.status === "flagged");
  foldedTable(host, {
    id: "audit",
    caption: "Flagged runs: wrong without an error message",
    list: flagged,
    key: (row) => `${row.scene}-${nameOf(row)}`,
    columns: [
      { key: "scene", label: "scene", words: true },
      { key: "method", label: "contestant", words: true, show: nameOf, sort: nameOf },
      { key: "why", label: "what was found", words: true },
      { key: "max_error_m", label: "largest error", unit: "m" },
    ],
  });
  const conditions = rows("conditions.csv");
  host.append(make("dl", { class: "facts", id: "conditions" }, conditions.map((row) => make("div", {}, make("dt", {}, row.what), make("dd", {}, row.what === "command" ? make("code", {}, row.value) : row.value)))));
  host.append(make("p", { class: "note" }, `Run times are those of the engines’ native loops on this machine; all other numbers are the same on every run. Made from ${listed(DATA.files)}.`));
}
