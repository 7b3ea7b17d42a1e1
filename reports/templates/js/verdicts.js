// Verdicts on runs: their signs and words, on the board, on the maps and in tables.

import { errorOf } from "./data.js";

/** @type {Record<string, [string, string]>} */
export const VERDICTS = {
  exact: ["◉", "indistinguishable from the truth"],
  within: ["●", "error acceptable"],
  beyond: ["○", "error too large"],
  flagged: ["▲", "finished, but flagged: wrong without an error message"],
  diverged: ["✕", "diverged"],
  failed: ["✕", "crashed or timed out"],
  skipped: ["·", "not supported"],
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
export const SILENT_VERDICTS = { clamped: "clamped", reset: "reset", frozen: "stopped", "lost-torque": "no torque", "under-rotated": "lags", drifting: "drifts", damped: "damped" };

/**
 * A status with its reason, in words.
 * @param {{ status: string, why: string }} run
 */
export function statusInWords(run) {
  const words = { ok: "finished", flagged: "flagged:", skipped: "not supported:", missing: "not installed:", diverged: "diverged", crashed: "crashed:", timeout: "timed out" };
  return `${words[run.status] ?? run.status} ${run.why}`.trim();
}

/**
 * The sign of a cell, so that no reader needs the colour, and what it means: from good to bad.
 * @type {Record<string, [string, string]>}
 */
export const STABILITY_VERDICTS = {
  stable: ["", "stable"],
  damped: ["↓", "loses energy that physics conserves"],
  drifting: ["↑", "energy or momentum drifts out of tolerance"],
  "under-rotated": ["↺", "rotates less than its angular velocity requires"],
  "lost-torque": ["∅", "lost its torque"],
  diverged: ["×", "diverged"],
  clamped: ["■", "a clamp hides the divergence"],
  frozen: ["◆", "stopped moving"],
  reset: ["←", "was reset to its initial state"],
  "no-return": ["?", "did not finish in the time limit"],
  refused: ["–", "refused"],
};
