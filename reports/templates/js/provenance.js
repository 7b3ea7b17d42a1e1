// How it was measured: the engines with what was switched off in them, the machine, and the files.

import { DATA, nameOf, rows } from "./data.js";
import { make } from "./dom.js";
import { counted, listed } from "./numbers.js";
import { foldedTable } from "./table.js";
import { statusInWords } from "./verdicts.js";

export function provenanceSection(host) {
  const engines = rows("engines.csv");
  const here = engines.filter((engine) => engine.status === "ok");
  const names = [...new Set(here.map((engine) => engine.engine.split("@")[0]))];
  const who = names.length < here.length ? `${counted(here.length, "release")} of ${listed(names)}` : `${counted(here.length, "engine")} at the releases below`;
  host.append(make("p", { class: "headline" }, `${who}, each in a process of its own, every vertex held against a truth that no engine had a part in.`));
  foldedTable(host, {
    id: "engines",
    caption: "Engines: release, methods, and what was switched off to be fair",
    list: engines,
    key: (row) => row.engine,
    columns: [
      { key: "engine", label: "engine", words: true },
      { key: "version", label: "release", words: true, show: (row) => row.version || statusInWords(row) },
      { key: "precision", label: "precision", words: true },
      { key: "methods", label: "methods", words: true },
      { key: "features", label: "force laws", words: true, show: (row) => row.features || "none" },
      { key: "switched_off", label: "switched off", words: true, show: (row) => row.switched_off || "nothing" },
    ],
  });
  const flagged = rows("runs.csv").filter((run) => run.status === "flagged");
  foldedTable(host, {
    id: "audit",
    caption: "What went wrong silently",
    list: flagged,
    key: (row) => `${row.scene}-${nameOf(row)}`,
    columns: [
      { key: "scene", label: "scene", words: true },
      { key: "method", label: "contestant", words: true, show: nameOf, sort: nameOf },
      { key: "why", label: "what the audit found", words: true },
      { key: "max_error_m", label: "largest error", unit: "m" },
    ],
  });
  const conditions = rows("conditions.csv");
  host.append(make("dl", { class: "facts", id: "conditions" }, conditions.map((row) => make("div", {}, make("dt", {}, row.what), make("dd", {}, row.what === "command" ? make("code", {}, row.value) : row.value)))));
  host.append(make("p", { class: "note" }, `Times are of engines' native loops on this machine; all else is the same on every run. Made from ${listed(DATA.files)}.`));
}
