// The stage: bodies drawn on a canvas in parallel projection, the nearer over the farther.

import { colourOf } from "./contestants.js";
import { styleOf } from "./dom.js";
import { placedPoints, pointsOf, truthAt } from "./film.js";
import { cross, dot, minus, normalOf, unit } from "./vectors.js";

export const TOWARDS_EYE = unit([0.55, 0.5, 1.0]);
export const RIGHTWARDS = unit(cross([0, 1, 0], TOWARDS_EYE));
export const UPWARDS = cross(TOWARDS_EYE, RIGHTWARDS);
const LIGHT = unit([0.3, 1.0, 0.55]);

const PIPS = {
  1: [[2, 2]],
  2: [[1, 1], [3, 3]],
  3: [[1, 1], [2, 2], [3, 3]],
  4: [[1, 1], [3, 3], [1, 3], [3, 1]],
  5: [[1, 1], [3, 3], [1, 3], [3, 1], [2, 2]],
  6: [[1, 1], [3, 3], [1, 3], [3, 1], [1, 2], [3, 2]],
};

// Opposite faces of a die add up to seven; faces come in opposite pairs.
const PIPS_OF_FACE = [1, 6, 2, 5, 3, 4];
const ARROW_SHARE = 0.25; // of the film, after the impulse

/** A camera that looks at a centre [m], at a scale [px/m]. */
function camera(centre, scaleOf, width, height) {
  return (point) => {
    const away = minus(point, centre);
    return [width / 2 + scaleOf * dot(away, RIGHTWARDS), height / 2 - scaleOf * dot(away, UPWARDS), dot(away, TOWARDS_EYE)];
  };
}

/**
 * What is drawn: a film at a time, with these contestants beside the truth (or alone, without it).
 * @typedef {{ film: Film, time: number, names: string[], magnified: number, alone: boolean }} Moment
 * magnified: how many times larger the contestants' deviations are drawn
 */

/**
 * Draw a moment on a canvas; returns where the vertices are seen [px].
 * @param {HTMLCanvasElement} canvas
 * @param {Moment} moment
 */
export function drawMoment(canvas, moment) {
  const ratio = Math.min(2, window.devicePixelRatio || 1);
  const [width, height] = [canvas.clientWidth, canvas.clientHeight];
  if (!width) return null;
  if (canvas.width !== Math.round(width * ratio)) [canvas.width, canvas.height] = [Math.round(width * ratio), Math.round(height * ratio)];
  const pen = /** @type {CanvasRenderingContext2D} */ (canvas.getContext("2d"));
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.clearRect(0, 0, width, height);
  return drawWith(pen, width, height, moment);
}

/**
 * The same with any pen, on width by height [px].
 * @param {CanvasRenderingContext2D | import("./svg-pen.js").SvgPen} pen
 * @param {number} width
 * @param {number} height
 * @param {Moment} moment
 */
export function drawWith(pen, width, height, { film, time, names, magnified, alone }) {
  const truth = truthAt(film, time);
  const points = placedPoints(film.points, truth);
  const view = viewOf(film, truth, width, height);
  drawGround(pen, film, view, truth);
  drawPath(pen, film, view);
  for (const act of film.loads) if (act.kind === "tether") drawTether(pen, film, view, act, truth);
  if (!alone) drawBody(pen, film, points, view);
  /** @type {Record<string, Vector[]>} */
  const seen = { truth: points.map(view) };
  for (const name of names) {
    const own = pointsOf(film, name, time, truth);
    if (!own) continue;
    const moved = own.map((point, vertex) => point.map((value, i) => points[vertex][i] + magnified * (value - points[vertex][i])));
    if (alone) drawBody(pen, film, moved, view);
    else drawGhost(pen, film, moved, view, colourOf(name), 0.12 / names.length);
    seen[name] = moved.map(view);
  }
  for (const act of film.loads) if (act.kind === "impulse") drawArrow(pen, film, view, act, time);
  return seen;
}

/**
 * The camera follows the true centre, and shows a little more than the body.
 * @param {Film} film
 */
function viewOf(film, truth, width, height) {
  return camera(truth.x, Math.min(width, height) / (2.9 * film.size), width, height);
}

function polygon(pen, corners) {
  pen.beginPath();
  corners.forEach(([x, y], at) => (at ? pen.lineTo(x, y) : pen.moveTo(x, y)));
  pen.closePath();
}

/**
 * A solid body: its faces shaded by their angle to the light, with a die's pips on a box.
 * @param {Film} film
 */
function drawBody(pen, film, points, view) {
  const seen = points.map(view);
  if (!film.faces.length) return drawCloud(pen, film, seen);
  const centre = [0, 1, 2].map((i) => points.reduce((sum, point) => sum + point[i], 0) / points.length);
  const faces = film.faces
    .map((face, number) => ({ face, number, normal: outwards(face.map((vertex) => points[vertex]), centre) }))
    .filter(({ normal }) => dot(normal, TOWARDS_EYE) > 0)
    .map((each) => ({ ...each, depth: each.face.reduce((sum, vertex) => sum + seen[vertex][2], 0) / each.face.length }))
    .sort((a, b) => a.depth - b.depth);
  const dark = matchMedia("(prefers-color-scheme: dark)").matches;
  for (const { face, number, normal } of faces) {
    const lit = (1 + dot(normal, LIGHT)) / 2;
    pen.fillStyle = `hsl(212 18% ${dark ? 24 + 42 * lit : 46 + 46 * lit}%)`;
    pen.strokeStyle = pen.fillStyle;
    pen.lineWidth = 1;
    const corners = face.map((vertex) => seen[vertex]);
    polygon(pen, corners);
    pen.fill();
    pen.stroke();
    if (film.body.shape === "box") drawPips(pen, corners, PIPS_OF_FACE[number], dark);
  }
  const front = new Set(faces.map(({ number }) => number));
  drawEdges(pen, film, seen, (edge) => edge.faces.some((face) => front.has(face)), styleOf("--ink"), 1);
}

/** The outward normal, also of a face that was turned inside out. */
function outwards(corners, centre) {
  const normal = normalOf(corners);
  const out = minus(corners[0], centre);
  // A face through the middle, of a disc without thickness, looks as its corners go.
  return dot(normal, out) < -1e-9 * Math.hypot(...out) ? normal.map((value) => -value) : normal;
}

function drawPips(pen, corners, count, dark) {
  const across = [corners[1][0] - corners[0][0], corners[1][1] - corners[0][1]];
  const along = [corners[3][0] - corners[0][0], corners[3][1] - corners[0][1]];
  pen.fillStyle = dark ? "#0b0e11" : "#20262c";
  for (const [u, v] of PIPS[count]) {
    pen.beginPath();
    for (let step = 0; step < 12; step += 1) {
      const [a, b] = [u / 4 + 0.075 * Math.cos((step * Math.PI) / 6), v / 4 + 0.075 * Math.sin((step * Math.PI) / 6)];
      const [x, y] = [corners[0][0] + a * across[0] + b * along[0], corners[0][1] + a * across[1] + b * along[1]];
      step ? pen.lineTo(x, y) : pen.moveTo(x, y);
    }
    pen.fill();
  }
}

/**
 * @param {Film} film
 */
function drawEdges(pen, film, seen, wanted, colour, width) {
  pen.strokeStyle = colour;
  pen.lineWidth = width;
  pen.lineJoin = "round";
  pen.beginPath();
  for (const edge of film.edges) {
    if (!wanted(edge)) continue;
    const [a, b] = edge.ends.map((vertex) => seen[vertex]);
    pen.moveTo(a[0], a[1]);
    pen.lineTo(b[0], b[1]);
  }
  pen.stroke();
}

function drawCloud(pen, film, seen, colour = styleOf("--ink")) {
  pen.fillStyle = colour;
  for (const [x, y] of seen) {
    pen.beginPath();
    pen.arc(x, y, 3, 0, 2 * Math.PI);
    pen.fill();
  }
}

/**
 * A contestant: its edges in its colour, and a veil of it, thin enough to leave the truth visible.
 * @param {Film} film
 */
function drawGhost(pen, film, points, view, colour, veil) {
  const seen = points.map(view);
  if (!film.faces.length) return drawCloud(pen, film, seen, colour);
  pen.fillStyle = colour;
  pen.globalAlpha = veil;
  for (const face of film.faces) {
    polygon(pen, face.map((vertex) => seen[vertex]));
    pen.fill();
  }
  pen.globalAlpha = 0.95;
  drawEdges(pen, film, seen, () => true, colour, 1.8);
  pen.globalAlpha = 1;
}

/**
 * The floor as a grid, where the scene has one.
 * @param {Film} film
 */
function drawGround(pen, film, view, truth) {
  const floor = film.loads.find((act) => act.kind === "floor");
  if (!floor) return;
  const normal = [floor.u, floor.v, floor.w];
  const [side, other] = planeAxes(normal);
  const height = dot(minus(truth.x, [floor.x_m, floor.y_m, floor.z_m]), normal);
  const foot = truth.x.map((value, i) => value - height * normal[i]);
  const cellSize = film.size;
  pen.strokeStyle = styleOf("--rule");
  pen.lineWidth = 1;
  pen.beginPath();
  for (let at = -3; at <= 3; at += 1) {
    for (const [a, b] of [[side, other], [other, side]]) {
      const begin = view(foot.map((value, i) => value + cellSize * (at * a[i] - 3 * b[i])));
      const end = view(foot.map((value, i) => value + cellSize * (at * a[i] + 3 * b[i])));
      pen.moveTo(begin[0], begin[1]);
      pen.lineTo(end[0], end[1]);
    }
  }
  pen.stroke();
}

function planeAxes(normal) {
  const side = unit(cross(normal, Math.abs(normal[0]) < 0.9 ? [1, 0, 0] : [0, 0, 1]));
  return [side, cross(normal, side)];
}

/**
 * The path of the true centre.
 * @param {Film} film
 */
function drawPath(pen, film, view) {
  pen.strokeStyle = styleOf("--soft");
  pen.globalAlpha = 0.45;
  pen.lineWidth = 1;
  pen.setLineDash([2, 4]);
  pen.beginPath();
  film.truth.forEach((frame, at) => {
    const [x, y] = view([frame[0], frame[1], frame[2]]);
    at ? pen.lineTo(x, y) : pen.moveTo(x, y);
  });
  pen.stroke();
  pen.setLineDash([]);
  pen.globalAlpha = 1;
}

function drawTether(pen, film, view, act, truth) {
  const [end] = placedPoints([[act.u, act.v, act.w]], truth).map(view);
  const anchor = view([act.x_m, act.y_m, act.z_m]);
  pen.strokeStyle = styleOf("--warn");
  pen.lineWidth = 1.5;
  pen.beginPath();
  pen.moveTo(end[0], end[1]);
  pen.lineTo(anchor[0], anchor[1]);
  pen.stroke();
  pen.fillStyle = styleOf("--warn");
  pen.beginPath();
  pen.arc(anchor[0], anchor[1], 4, 0, 2 * Math.PI);
  pen.fill();
}

/** An impulse: an arrow to its point, for a while after it. */
function drawArrow(pen, film, view, act, time) {
  const since = (time - act.t_s) / (film.end || 1);
  if (since < 0 || since > ARROW_SHARE) return;
  const direction = unit([act.u, act.v, act.w]);
  const tip = view([act.x_m, act.y_m, act.z_m]);
  const tail = view([act.x_m, act.y_m, act.z_m].map((value, i) => value - 1.1 * film.size * direction[i]));
  pen.globalAlpha = 1 - since / ARROW_SHARE;
  pen.strokeStyle = styleOf("--warn");
  pen.fillStyle = styleOf("--warn");
  pen.lineWidth = 3;
  pen.beginPath();
  pen.moveTo(tail[0], tail[1]);
  pen.lineTo(tip[0], tip[1]);
  pen.stroke();
  const along = Math.atan2(tip[1] - tail[1], tip[0] - tail[0]);
  polygon(pen, [0, 2.6, -2.6].map((turn) => [tip[0] + (turn ? 12 : 0) * Math.cos(along + turn), tip[1] + (turn ? 12 : 0) * Math.sin(along + turn)]));
  pen.fill();
  pen.globalAlpha = 1;
}
