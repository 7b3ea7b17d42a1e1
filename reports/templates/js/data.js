// The tables and films of the page: all figures are drawn from these.

/** @type {PageData} */
export const DATA = JSON.parse(document.getElementById("data")?.textContent ?? "");
const NUMBERS = { Infinity: Infinity, "-Infinity": -Infinity, NaN: NaN };

/**
 * Rows of a table, as objects of its columns; none where the page has no such table.
 * @template {keyof Tables} Name
 * @param {Name} name
 * @returns {Tables[Name][]}
 */
export function rows(name) {
  const table = DATA.tables[name];
  if (!table) return [];
  table.rows ??= Array.from({ length: table.length }, (_, at) =>
    Object.fromEntries(table.columns.map((column) => [column, cell(table.values[column], at)])),
  );
  return table.rows;
}

/** One cell: words are stored once each, numbers that JSON does not know by name, empty cells as null. */
function cell(column, at) {
  if (column.words) return column.words[column.at[at]];
  const value = column.numbers ? column.numbers[column.at[at]] : column[at];
  return typeof value === "string" && value in NUMBERS ? NUMBERS[value] : value;
}

/**
 * ENGINE:METHOD[@TOLERANCE] of any row that has both.
 * @param {{ engine: string, method?: string }} row
 */
export function nameOf(row) {
  return row.method ? `${row.engine}:${row.method}` : row.engine;
}

/**
 * The contestant of a row, whatever its tolerance.
 * @param {{ engine: string, method?: string }} row
 */
export function contestantOf(row) {
  return row.method ? `${row.engine}:${row.method.split("@")[0]}` : row.engine;
}

/**
 * A run's largest error [m], or the resolution of the reference where that is larger; null where there is none.
 * @param {{ max_error_m: number | null, resolution_m?: number | null }} row
 */
export function errorOf(row) {
  return row.max_error_m === null ? null : Math.max(row.max_error_m, row.resolution_m ?? 0);
}

/**
 * The rows of findings.csv of a name, of one scene or of all.
 * @param {FindingName} name
 * @param {string} [scene]
 */
export function findings(name, scene) {
  return rows("findings.csv").filter((row) => row.finding === name && (scene === undefined || row.scene === scene));
}

/**
 * Those of them that have a number.
 * @param {FindingName} name
 * @param {string} [scene]
 * @returns {(Tables["findings.csv"] & { value: number })[]}
 */
export function numbersFound(name, scene) {
  return /** @type {any} */ (findings(name, scene).filter((row) => row.value !== null));
}

/**
 * A finding's number, or the resolution of the reference where that is larger; null where there is none.
 * @param {Tables["findings.csv"]} row
 */
export function findingValue(row) {
  return row.value === null ? null : Math.max(row.value, row.resolution ?? 0);
}

/**
 * Items by key, in the order in which the keys come.
 * @template Item
 * @template Key
 * @param {Iterable<Item>} list
 * @param {(item: NoInfer<Item>) => Key} key
 * @returns {Map<Key, Item[]>}
 */
export function groupBy(list, key) {
  const groups = new Map();
  for (const item of list) {
    const own = key(item);
    if (!groups.has(own)) groups.set(own, []);
    groups.get(own).push(item);
  }
  return groups;
}
