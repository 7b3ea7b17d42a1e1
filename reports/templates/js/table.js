// Tables that the reader sorts, filters and saves; each row has an address.

import { make } from "./dom.js";
import { counted, figure } from "./numbers.js";
import { csvOf, saveAs } from "./save.js";
import { copyLinkButton, state } from "./state.js";

/**
 * Put a table into host; what it saves is its rows as their file has them.
 * @template Row
 * @param {Element} host
 * @param {ShownTable<Row>} options id: of the table and, with key(row), of each row
 */
function dataTable(host, { id, caption, columns, list, key, file = id }) {
  if (!list.length) return;
  /** @type {{ column: ShownColumn<Row> | null, down: boolean }} */
  let sorted = { column: null, down: false };
  let words = "";
  const body = make("tbody");
  const heads = columns.map((column) =>
    make(
      "th",
      { scope: "col", class: column.words ? "words" : "" },
      make("button", { type: "button", class: "sort", click: () => sortBy(column) }, column.label, column.unit ? make("span", { class: "unit" }, ` ${column.unit}`) : ""),
    ),
  );
  const find = make("input", {
    type: "search",
    class: "find",
    placeholder: "filter rows",
    "aria-label": `Filter the rows of ${caption}`,
    input: () => {
      words = find.value.toLowerCase();
      fill();
    },
  });
  const count = make("span", { class: "note", role: "status" });
  const save = make("button", { type: "button", "aria-label": `Save ${caption} as CSV`, click: () => saveAs(`${file}.csv`, new Blob([csvOf(chosenRows())], { type: "text/csv" })) }, "CSV");

  function textOf(row) {
    return Object.values(row).join(" ").toLowerCase();
  }
  function chosenRows() {
    const chosen = words ? list.filter((row) => textOf(row).includes(words)) : [...list];
    const { column } = sorted;
    if (column) {
      const value = column.sort ?? ((row) => row[column.key]);
      const way = sorted.down ? -1 : 1;
      chosen.sort((a, b) => {
        const [x, y] = [value(a), value(b)];
        if (x === y) return 0;
        if (x === null || x === undefined || x === "") return 1; // empty cells come last in both directions
        if (y === null || y === undefined || y === "") return -1;
        return (x < y ? -1 : 1) * way;
      });
    }
    return chosen;
  }
  function fill() {
    const current = chosenRows();
    body.replaceChildren(
      ...current.map((row) =>
        make(
          "tr",
          { id: `${id}-${key(row)}` },
          columns.map((column, at) => {
            const shownCell = column.show ? column.show(row) : row[column.key];
            const content = typeof shownCell === "number" ? figure(shownCell) : (shownCell ?? "");
            const parts = at === 0 ? [content, copyLinkButton(`${id}-${key(row)}`)] : [content];
            return make(at === 0 ? "th" : "td", { scope: at === 0 ? "row" : null, class: column.words ? "words" : "" }, parts);
          }),
        ),
      ),
    );
    count.textContent = current.length === list.length ? "" : `${current.length} of ${counted(list.length, "row")}`;
  }
  function sortBy(column) {
    sorted = { column, down: sorted.column === column ? !sorted.down : false };
    heads.forEach((head, at) => {
      if (columns[at] === column) head.setAttribute("aria-sort", sorted.down ? "descending" : "ascending");
      else head.removeAttribute("aria-sort");
    });
    fill();
  }

  fill();
  host.append(
    make("div", { class: "tools table-tools" }, list.length > 6 ? find : "", count, copyLinkButton(id), save),
    make(
      "div",
      { class: "wide", tabindex: "0", role: "region", "aria-label": caption },
      make("table", { id, class: "data" }, make("caption", { class: "unseen" }, caption), make("thead", {}, make("tr", {}, heads)), body),
    ),
  );
}

/**
 * A folded table: made when it is opened.
 * @template Row
 * @param {Element} host
 * @param {ShownTable<Row>} options
 */
export function foldedTable(host, options) {
  if (!options.list.length) return;
  const fold = make("details", { class: "fold", id: `fold-${options.id}` }, make("summary", {}, options.caption));
  let made = false;
  const fill = () => {
    if (made || !fold.open) return;
    made = true;
    dataTable(fold, options);
  };
  fold.addEventListener("toggle", fill);
  if (state.at.startsWith(options.id)) {
    fold.open = true;
    fill();
  }
  host.append(fold);
}
