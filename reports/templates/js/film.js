// Films: where the truth and the contestants are at any time, from the frames on the page.

import { DATA, rows } from "./data.js";
import { dot, normalOf, product } from "./vectors.js";

/** @type {Map<string, Film | null>} */
const films = new Map();

/**
 * The film of a scene, unpacked at the first call; null where there is none.
 * @param {string} scene
 */
export function filmOf(scene) {
  if (!films.has(scene)) films.set(scene, DATA.films[scene] ? readFilm(scene, DATA.films[scene]) : null);
  return films.get(scene) ?? null;
}

function floats(text) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  return new Float32Array(bytes.buffer);
}

/** Frames of `width` numbers each. */
function frames(text, width) {
  const values = floats(text);
  return Array.from({ length: values.length / width }, (_, at) => values.subarray(at * width, (at + 1) * width));
}

/**
 * @param {string} scene
 * @param {PackedFilm} packed
 * @returns {Film}
 */
function readFilm(scene, packed) {
  const ofScene = (row) => row.scene === scene;
  const loads = rows("loads.csv").filter(ofScene);
  const points = rows("points.csv").filter(ofScene).map((row) => [row.x_m, row.y_m, row.z_m]);
  const faces = rows("faces.csv").filter(ofScene).map((row) => row.vertices.split(" ").map(Number));
  return {
    scene,
    t: packed.t,
    end: packed.t[packed.t.length - 1],
    body: rows("bodies.csv").filter(ofScene)[0],
    points,
    size: Math.max(...points.map((point) => Math.hypot(...point))),
    faces,
    edges: edgesOf(points, faces),
    loads,
    impulseFrames: new Set(loads.filter((load) => load.kind === "impulse" && load.t_s > 0).map((load) => packed.t.indexOf(load.t_s))),
    truth: frames(packed.truth, 16),
    limit: packed.limit,
    runs: new Map(Object.entries(packed.runs).map(([name, run]) => [name, readRun(run, points.length)])),
  };
}

/**
 * @param {PackedRun} run
 * @param {number} vertices
 * @returns {FilmRun}
 */
function readRun(run, vertices) {
  return {
    frames: frames(run.frames, 10),
    momentum: run.momentum ? frames(run.momentum, 3) : null,
    vertices: run.vertices ? frames(run.vertices, 3 * vertices) : null,
  };
}

/**
 * The frame before a time and how far it is to the next, 0 to 1.
 * @param {Film} film
 * @param {number} time
 */
export function frameAt(film, time) {
  const { t } = film;
  if (time >= film.end) return [t.length - 2, 1];
  let at = 0;
  while (at < t.length - 2 && t[at + 1] <= time) at += 1;
  return [at, Math.max(0, (time - t[at]) / (t[at + 1] - t[at]))];
}

/** Cubic through two values and slopes; where an impulse ends the interval, the slope after it does not count. */
function hermite(p, m, q, n, h, s, impulse) {
  const end = impulse ? (2 * (q - p)) / h - m : n;
  const [s2, s3] = [s * s, s * s * s];
  return (2 * s3 - 3 * s2 + 1) * p + (s3 - 2 * s2 + s) * h * m + (3 * s2 - 2 * s3) * q + (s3 - s2) * h * end;
}

/**
 * The truth at a time: x, unit q.
 * @returns {{ x: Vector, q: Quaternion }}
 * @param {Film} film
 * @param {number} time
 */
export function truthAt(film, time) {
  const [at, s] = frameAt(film, time);
  const [a, b] = [film.truth[at], film.truth[at + 1]];
  if (!b) return { x: [...a.subarray(0, 3)], q: [...a.subarray(3, 7)] };
  const h = film.t[at + 1] - film.t[at];
  const impulse = film.impulseFrames.has(at + 1);
  const x = [0, 1, 2].map((i) => hermite(a[i], a[7 + i], b[i], b[7 + i], h, s, impulse));
  const [da, db] = [rateOf(a), rateOf(b)];
  const q = [0, 1, 2, 3].map((i) => hermite(a[3 + i], da[i], b[3 + i], db[i], h, s, impulse));
  const length = Math.hypot(...q);
  return { x, q: q.map((value) => value / length) };
}

/** q' = w q / 2, w in world axes. */
function rateOf(frame) {
  const [qw, qx, qy, qz] = frame.subarray(3, 7);
  const [wx, wy, wz] = frame.subarray(10, 13);
  return [
    -(wx * qx + wy * qy + wz * qz) / 2,
    (wx * qw + wy * qz - wz * qy) / 2,
    (wy * qw + wz * qx - wx * qz) / 2,
    (wz * qw + wx * qy - wy * qx) / 2,
  ];
}

/**
 * The body's points at a pose.
 * @param {Vector[]} points
 * @param {{ x: Vector, q: Quaternion }} pose
 * @returns {Vector[]}
 */
export function placedPoints(points, { x, q: [w, a, b, c] }) {
  const m = [
    [1 - 2 * (b * b + c * c), 2 * (a * b - w * c), 2 * (a * c + w * b)],
    [2 * (a * b + w * c), 1 - 2 * (a * a + c * c), 2 * (b * c - w * a)],
    [2 * (a * c - w * b), 2 * (b * c + w * a), 1 - 2 * (a * a + b * b)],
  ];
  return points.map((p) => m.map((row, i) => x[i] + row[0] * p[0] + row[1] * p[1] + row[2] * p[2]));
}

/**
 * Where a contestant's points are: the truth moved by its own deviation, interpolated between frames.
 * @param {Film} film
 * @param {string} name
 * @param {number} time
 */
export function pointsOf(film, name, time, truth = truthAt(film, time)) {
  const one = film.runs.get(name);
  const [at, s] = frameAt(film, time);
  if (!one || at >= one.frames.length || (s > 0 && at + 1 >= one.frames.length)) return null;
  if (one.vertices) {
    const [a, b] = [one.vertices[at], one.vertices[Math.min(at + 1, one.vertices.length - 1)]];
    return deformedPoints(film, a, b, at, s, truth);
  }
  const a = one.frames[at];
  const b = one.frames[Math.min(at + 1, one.frames.length - 1)];
  const x = truth.x.map((value, i) => value + (1 - s) * a[i] + s * b[i]);
  return placedPoints(film.points, { x, q: product(relativeAt(one, at, s), truth.q) });
}

/**
 * q q_true^-1 of a contestant, a share s of the way from one frame to the next.
 * @param {FilmRun} one
 * @param {number} at
 * @param {number} s
 */
export function relativeAt(one, at, s) {
  const a = one.frames[at];
  const b = one.frames[Math.min(at + 1, one.frames.length - 1)];
  const sign = a[3] * b[3] + a[4] * b[4] + a[5] * b[5] + a[6] * b[6] < 0 ? -1 : 1;
  const relative = [0, 1, 2, 3].map((i) => (1 - s) * a[3 + i] + sign * s * b[3 + i]);
  const length = Math.hypot(...relative) || 1;
  return relative.map((value) => value / length);
}

/**
 * A body that is no longer rigid: its vertices' deviations from the truth, in proportion between two frames.
 * @param {Film} film
 */
function deformedPoints(film, a, b, at, s, truth) {
  const true_a = placedPoints(film.points, truthAt(film, film.t[at]));
  const true_b = placedPoints(film.points, truthAt(film, film.t[Math.min(at + 1, film.t.length - 1)]));
  return placedPoints(film.points, truth).map((point, vertex) =>
    point.map((value, i) => value + (1 - s) * (a[3 * vertex + i] - true_a[vertex][i]) + s * (b[3 * vertex + i] - true_b[vertex][i])),
  );
}

/**
 * The edges to draw: those between faces that are not in one plane.
 * @param {Vector[]} points
 * @param {number[][]} faces
 * @returns {Edge[]}
 */
function edgesOf(points, faces) {
  const normals = faces.map((face) => normalOf(face.map((vertex) => points[vertex])));
  const seen = new Map();
  faces.forEach((face, number) =>
    face.forEach((vertex, at) => {
      const next = face[(at + 1) % face.length];
      const key = vertex < next ? `${vertex} ${next}` : `${next} ${vertex}`;
      if (!seen.has(key)) seen.set(key, []);
      seen.get(key).push(number);
    }),
  );
  const edges = [];
  for (const [key, [a, b]] of seen) {
    const flat = b !== undefined && dot(normals[a], normals[b]) > 0.999;
    if (!flat) edges.push({ ends: key.split(" ").map(Number), faces: [a, b ?? a] });
  }
  return edges;
}
