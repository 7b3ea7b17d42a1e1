// Verdicts on runs: their signs and words, on the board, on the maps and in tables.

import { errorOf } from "./data.js";

/** @type {Record<string, [string, string]>} */
export const VERDICTS = {
  exact: ["◉", "cannot be told from the truth"],
  within: ["●", "finished, within the tolerance"],
  beyond: ["○", "finished, beyond the tolerance"],
  flagged: ["▲", "finished, but something went wrong silently"],
  diverged: ["✕", "blew up"],
  failed: ["✕", "crashed or timed out"],
  skipped: ["·", "cannot fly this scene"],
};

/**
 * The verdict on a run under a tolerance [m], as a key of VERDICTS.
 * @param {Tables["runs.csv"]} run
 * @param {number} tolerance
 */
export function verdictOf(run, tolerance) {
  const kind = run.status;
  if (kind === "skipped" || kind === "missing") return "skipped";
  if (kind === "diverged") return "diverged";
  if (kind === "crashed" || kind === "timeout") return "failed";
  const error = errorOf(run);
  if (error === null) return "skipped";
  if (kind === "flagged") return "flagged";
  if (run.max_error_m !== null && run.max_error_m <= (run.resolution_m ?? 0)) return "exact";
  return error <= tolerance ? "within" : "beyond";
}

/** How strongly a cell is coloured: a step for each decade that its error is below the tolerance, or above it. */
export function tintOf(kind, ratio) {
  if (!["exact", "within", "beyond"].includes(kind)) return "";
  const decades = Math.min(12, Math.max(1, Math.ceil(Math.abs(Math.log10(ratio || 1e-12)))));
  return `${kind === "beyond" ? "above" : "below"}-${decades}`;
}

/**
 * Verdicts on runs that ended with finite numbers which physics does not allow, as a cell has room for them.
 * @type {Record<string, string>}
 */
export const SILENT_VERDICTS = { clamped: "clamped", reset: "reset", frozen: "froze", "lost-torque": "no torque", "under-rotated": "lags", drifting: "drifts", damped: "damped" };

/**
 * A status in the words of a person.
 * @param {{ status: string, why: string }} run
 */
export function statusInWords(run) {
  const words = { ok: "finished", flagged: "finished, but", skipped: "cannot:", missing: "not installed:", diverged: "blew up", crashed: "crashed:", timeout: "took too long" };
  return `${words[run.status] ?? run.status} ${run.why}`.trim();
}

/**
 * The sign of a cell, so that no reader needs the colour, and what it means: from good to bad.
 * @type {Record<string, [string, string]>}
 */
export const STABILITY_VERDICTS = {
  stable: ["", "stable"],
  damped: ["↓", "loses energy that physics keeps"],
  drifting: ["↑", "energy or momentum leaves its band"],
  "under-rotated": ["↺", "turns less than its angular velocity says"],
  "lost-torque": ["∅", "lost its torque"],
  diverged: ["×", "blew up"],
  clamped: ["■", "a clamp hides the blow-up"],
  frozen: ["◆", "froze"],
  reset: ["←", "was reset to a start"],
  "no-return": ["?", "no return in the time given"],
  refused: ["–", "refused"],
};
