// Where smaller steps make it worse: rounding, that of single precision most of all.

/** Who of those shown gets worse below a step, with that step; nothing where nobody does. */
function worsening(host, scene) {
  const found = findings("optimal step", scene);
  if (!found.length) return;
  const reached = new Map(rows("sweep-orders.csv").filter((row) => row.scene === scene).map((row) => [nameOf(row), row]));
  const said = make("p", { class: "note", id: `worse-below-${scene}` });
  host.append(said);
  follow(["show"], () => {
    const names = shown();
    const own = found.filter((row) => names.has(nameOf(row)));
    said.replaceChildren(own.length ? `Smaller steps make it worse: ${own.map((row) => worseBelow(row, reached.get(nameOf(row)))).join("; ")}.` : "");
  });
}

function worseBelow(found, row) {
  const single = row.precision === "single" ? ", in single precision," : "";
  return `${nameOf(found)}${single} below ${si(found.value, "s")}, where it is ${si(row.best_error_m, "m")} off, ${si(row.finest_error_m, "m")} at ${si(row.finest_dt_s, "s")}`;
}
