// The polhode: the angular momentum in body axes, a curve on the ellipsoid of constant energy.

import { CONTESTANTS } from "./contestants.js";
import { draw, make } from "./dom.js";
import { filmOf, frameAt, relativeAt, truthAt } from "./film.js";
import { clockOf } from "./player.js";
import { figureTools } from "./save.js";
import { RIGHTWARDS, TOWARDS_EYE, UPWARDS } from "./stage.js";
import { follow } from "./state.js";
import { dot, product, rotated } from "./vectors.js";

const STEPS = 600; // of a curve: a film's frames alone would be corners

/**
 * Put the polhode of a scene into host; nothing for a body of three equal moments.
 * @param {Element} host
 * @param {Film} film
 * @param {() => string[]} ghosts
 */
export function polhode(host, film, ghosts) {
  const { scene } = film;
  const { i1_kg_m2: i1, i2_kg_m2: i2, i3_kg_m2: i3 } = film.body;
  const moments = [i1, i2, i3];
  // After the last impulse only torques change it; an earlier impulse would put it on another ellipsoid.
  const from = film.t[Math.max(0, ...film.impulseFrames)];
  const instants = Array.from({ length: STEPS + 1 }, (_, step) => from + ((film.end - from) * step) / STEPS);
  const along = (name) => instants.flatMap((time) => [momentumAt(film, name, time) ?? []]).filter((l) => l.length);
  const truth = along(null);
  const energy = truth[0].reduce((sum, l, i) => sum + (l * l) / (2 * moments[i]), 0);
  if (!(energy > 0) || new Set(moments).size === 1) return;
  const axes = moments.map((moment) => Math.sqrt(2 * energy * moment));
  const largest = Math.max(...axes);
  const size = 260;
  const svg = draw("svg", { class: "polhode", viewBox: `0 0 ${size} ${size}`, role: "img", id: `polhode-${scene}`, "aria-label": `Angular momentum in body axes on the ellipsoid of the energy, ${scene}` });
  const look = (l) => [size / 2 + (dot(l, RIGHTWARDS) * 0.44 * size) / largest, size / 2 - (dot(l, UPWARDS) * 0.44 * size) / largest];
  const inFront = (l) => dot([l[0] / moments[0], l[1] / moments[1], l[2] / moments[2]], TOWARDS_EYE) >= 0;
  const path = (points, attributes) => draw("path", { d: `M${points.map((l) => look(l).map((value) => value.toFixed(1)).join(",")).join("L")}`, fill: "none", ...attributes });

  svg.append(path(silhouette(axes), { fill: "var(--ink)", "fill-opacity": 0.05, stroke: "var(--soft)", "stroke-width": 1 }));
  for (const flat of [0, 1, 2]) {
    const [a, b] = [0, 1, 2].filter((axis) => axis !== flat);
    const ring = Array.from({ length: 61 }, (_, step) => {
      const l = [0, 0, 0];
      l[a] = axes[a] * Math.cos((step * Math.PI) / 30);
      l[b] = axes[b] * Math.sin((step * Math.PI) / 30);
      return l;
    });
    svg.append(path(ring, { stroke: "var(--rule)", "stroke-width": 1 }));
  }
  axes.forEach((length, axis) => {
    const tip = [0, 0, 0];
    tip[axis] = length * 1.06;
    const [x, y] = look(tip);
    svg.append(draw("text", { x, y: y + 4, "text-anchor": "middle", fill: "var(--soft)", "font-size": 11 }, `${axis + 1}`));
  });
  const curves = draw("g");
  const dots = draw("g");
  svg.append(curves, dots);
  const clock = clockOf(film);

  function curveOf(points, colour, width, name) {
    return runsOf(points, inFront).map(({ front, list }) =>
      path(list, { stroke: colour, "stroke-width": width, "stroke-opacity": front ? 1 : 0.3, "data-name": name, "stroke-linecap": "round" }),
    );
  }
  function render() {
    curves.replaceChildren(
      ...ghosts().flatMap((name) => {
        const own = film.runs.get(name)?.momentum ? along(name) : [];
        return own.length > 1 ? curveOf(own, `var(${CONTESTANTS.get(name).hue})`, 1.6, name) : [];
      }),
      ...curveOf(truth, "var(--ink)", 2.6, "truth"),
    );
    moveDots();
  }
  function moveDots() {
    const points = [
      ["truth", momentumAt(film, null, clock.time), "var(--ink)"],
      ...ghosts().map((name) => [name, film.runs.get(name)?.momentum && momentumAt(film, name, clock.time), `var(${CONTESTANTS.get(name)?.hue})`]),
    ];
    dots.replaceChildren(
      ...points
        .filter(([, l]) => l)
        .reverse()
        .map(([name, l, colour]) => draw("circle", { cx: look(l)[0].toFixed(1), cy: look(l)[1].toFixed(1), r: name === "truth" ? 5 : 4, fill: colour, stroke: "var(--paper)" })),
    );
  }
  clock.followers.add(moveDots);
  host.append(make("figure", { class: "chart-box" }, svg, make("figcaption", {}, "Angular momentum in body axes. A correct simulation stays on one closed curve; without the gyroscopic term it stands still or spirals away."), figureTools(`polhode-${scene}`, () => svg)));
  follow(["show", "tol"], render);
}

/**
 * The angular momentum in body axes: in world axes it changes slowly, so there it is interpolated between frames.
 * @param {Film} film
 * @param {string | null} name
 * @param {number} time
 */
function momentumAt(film, name, time) {
  const [at, s] = frameAt(film, time);
  const own = name && film.runs.get(name);
  const world = (frame) => {
    const truth = film.truth[frame];
    const l = own ? own.momentum?.[frame] : truth?.subarray(13, 16);
    if (!l || !truth) return null;
    const attitude = truth.subarray(3, 7);
    return rotated(own ? product(own.frames[frame].subarray(3, 7), attitude) : attitude, [...l]);
  };
  const [a, b] = [world(at), world(s > 0 ? at + 1 : at)];
  if (!a || !b) return null;
  const { q } = truthAt(film, time);
  const [qw, qx, qy, qz] = own ? product(relativeAt(own, at, s), q) : q;
  return rotated([qw, -qx, -qy, -qz], a.map((value, i) => (1 - s) * value + s * b[i]));
}

/** The visible outline of the ellipsoid. */
function silhouette(axes) {
  // The outline is where the normal looks past the eye: the image of a circle under a 2 x 2 root of A.
  const across = RIGHTWARDS.map((value, i) => value * axes[i]);
  const up = UPWARDS.map((value, i) => value * axes[i]);
  const [a, b, c] = [dot(across, across), dot(across, up), dot(up, up)];
  const [p, q, r] = [Math.sqrt(a), b / Math.sqrt(a), Math.sqrt(Math.max(0, c - (b * b) / a))];
  return Array.from({ length: 91 }, (_, step) => {
    const [x, y] = [Math.cos((step * Math.PI) / 45), Math.sin((step * Math.PI) / 45)];
    const [u, v] = [p * x, q * x + r * y];
    return [0, 1, 2].map((i) => u * RIGHTWARDS[i] + v * UPWARDS[i]);
  });
}

/** Stretches of points for which a question has one answer, each begun where the last one ended. */
function runsOf(points, ask) {
  /** @type {{ front: boolean, list: Vector[] }[]} */
  const found = [];
  for (const point of points) {
    const front = ask(point);
    const last = found.at(-1);
    if (last && last.front === front) last.list.push(point);
    else found.push({ front, list: last ? [...last.list.slice(-1), point] : [point] });
  }
  return found.filter(({ list }) => list.length > 1);
}
