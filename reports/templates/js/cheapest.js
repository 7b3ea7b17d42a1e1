// Which contestant reaches an error at the lowest cost, from the sweep.

import { CONTESTANTS } from "./contestants.js";
import { contestantOf, groupBy, rows } from "./data.js";
import { figure, given, si } from "./numbers.js";

/** The contestants that the answer names: the cheapest of all, then those of at most three other engines. */
export function namedInAnswer(tolerance) {
  const reached = cheapest(tolerance);
  return reached.filter(({ engine }, at) => reached.findIndex((other) => other.engine === engine) === at).slice(0, 4);
}

/** The contestants that reach an error in the swept scene, cheapest first, each with its cheapest run. */
export function cheapest(tolerance, scene = sweptScenes()[0]) {
  const found = [];
  for (const [name, own] of groupBy(rows("sweep-work-precision.csv").filter((run) => run.scene === scene), contestantOf)) {
    if (CONTESTANTS.get(name)?.byHand) continue;
    const reaching = own.filter((run) => run.status === "ok" && run.error_m !== null && run.error_m <= tolerance).sort((a, b) => a.run_us - b.run_us);
    if (reaching.length) found.push({ name, engine: CONTESTANTS.get(name).engine, run: reaching[0], whole: own.length === 1 });
  }
  return found.sort((a, b) => a.run.run_us - b.run.run_us);
}

export function costInWords({ run, whole }) {
  const time = si(run.run_us / 1e6, "s", 2);
  return whole ? ` (${time} a run, in one step)` : ` (${settingOf(run, 2)}: ${time} a run)`;
}

export function sweptScenes() {
  return [...new Set(rows("sweep-work-precision.csv").map((run) => run.scene))];
}

/**
 * The step of a run, or the tolerance under which it chose its steps.
 * @param {{ dt_s: number | null, tolerance: number | null }} run
 */
export function settingOf(run, digits = 3) {
  return run.tolerance === null ? `step ${figure(run.dt_s, digits)} s` : `tolerance ${given(Number(run.tolerance.toPrecision(digits)))}`;
}
