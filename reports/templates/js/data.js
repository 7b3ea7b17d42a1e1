// The tables as the page carries them, and the films: all that is drawn comes from here.

export const DATA = JSON.parse(document.getElementById("data").textContent);
const NUMBERS = { Infinity: Infinity, "-Infinity": -Infinity, NaN: NaN };

/** Rows of a table, as objects of its columns; none where the page has no such table. */
export function rows(name) {
  const table = DATA.tables[name];
  if (!table) return [];
  table.rows ??= Array.from({ length: table.length }, (_, at) =>
    Object.fromEntries(table.columns.map((column) => [column, cell(table.values[column], at)])),
  );
  return table.rows;
}

/** One cell: words are stored once each, numbers JSON does not know by their names, empty cells as null. */
function cell(column, at) {
  if (column.words) return column.words[column.at[at]];
  const value = column.numbers ? column.numbers[column.at[at]] : column[at];
  return typeof value === "string" && value in NUMBERS ? NUMBERS[value] : value;
}

/** ENGINE:METHOD[@TOLERANCE] of any row that has both. */
export function nameOf(row) {
  return row.method ? `${row.engine}:${row.method}` : row.engine;
}

/** The contestant a row is of, whatever its tolerance. */
export function contestantOf(row) {
  return row.method ? `${row.engine}:${row.method.split("@")[0]}` : row.engine;
}

/** A run's error as it can be told: not below the truth's limit [m]; null where there is none. */
export function errorOf(row) {
  return row.max_error_m === null ? null : Math.max(row.max_error_m, row.resolution_m ?? 0);
}

/** What was found: the rows of findings.csv of that name, of one scene or of all. */
export function findings(name, scene = null) {
  return rows("findings.csv").filter((row) => row.finding === name && (scene === null || row.scene === scene));
}

/** A finding's number as it can be told: not below the truth's limit. */
export function findingValue(row) {
  return row.value === null ? null : Math.max(row.value, row.resolution ?? 0);
}

export function groupBy(list, key) {
  const found = new Map();
  for (const item of list) {
    const own = key(item);
    if (!found.has(own)) found.set(own, []);
    found.get(own).push(item);
  }
  return found;
}
