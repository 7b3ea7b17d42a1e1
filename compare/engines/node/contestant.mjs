// What the engines of npm share: lines of JSON (docs/programs.md), what is installed, and forces held over a step.
import { createInterface } from "node:readline";
import { pathToFileURL } from "node:url";

// A module of the environment that `tumble engines --install` made, by its path below node_modules.
export const installed = (path) => import(pathToFileURL(`${process.env.TUMBLE_ENVIRONMENT}/node_modules/${path}`));

// An engine is { build(told, manner) -> world, put(world, row, state), get(world, row) -> state, step(world, dt) } and,
// where it has them, { cannot(told) -> why, or "" }, { push(world, row, force, torque) }, { audit(world) }, { end(world) }.
// Forces are world axes.
export async function serve(engine) {
  let world, told, manner, start, flown;
  const forced = () => Boolean(told.tethers || told.drag || told.floor);
  const make = () => ({ ...engine.build(told, manner), told, manner, held: forced(), longest: 0, fastest: [0, 0] });
  const get = () => Array.from({ length: told.throws }, (_, row) => engine.get(world, row));
  const verbs = {
    build(question) {
      [told, manner] = [question, question.method.split("+")[1] ?? ""];
      if (forced() && !manner) return { skipped: `it has none of these laws; ${told.method}+held is given their force once a step` };
      if (told.shape?.kind === "disc" && !told.shape.thickness) return { skipped: "it has no disc without thickness" };
      if (engine.cannot?.(told)) return { skipped: engine.cannot(told) };
      [world, flown] = [make(), 0];
    },
    write({ states }) {
      if (told.plane && flown) { // what an engine keeps of a contact lives in its world: a new one has none
        engine.end?.(world);
        world = make();
      }
      states.forEach((state, row) => engine.put(world, row, state));
      [world.longest, world.fastest, flown] = [0, [0, 0], 0];
      start = get();
    },
    advance({ n, dt }) {
      const begun = process.hrtime.bigint();
      for (let i = 0; i < n; i++) {
        if (world.held) {
          for (let row = 0; row < told.throws; row++) engine.push(world, row, ...wrench(told, engine.get(world, row)));
        }
        engine.step(world, dt);
      }
      const ns = Number(process.hrtime.bigint() - begun);
      if (n) world.longest = Math.max(world.longest, dt);
      flown += n;
      return { ns };
    },
    read() {
      const states = get();
      for (const [at, from] of [[0, 7], [1, 10]]) {
        const speeds = states.map((state) => Math.hypot(...state.slice(from, from + 3)));
        world.fastest[at] = Math.max(world.fastest[at], ...speeds);
      }
      return { states };
    },
    audit() {
      const { states } = verbs.read();
      const findings = engine.audit?.(world) ?? [];
      states.forEach((state, row) => {
        const stood = flown && [0, 1, 2, 7, 8, 9].every((i) => state[i] === start[row][i]);
        if (stood && state.slice(7, 10).some(Boolean)) findings.push(["frozen", `throw ${row} did not move at all`]);
      });
      return { findings };
    },
    end() {
      engine.end?.(world);
      world = undefined;
    },
  };
  for await (const line of createInterface({ input: process.stdin })) {
    const question = JSON.parse(line);
    process.stdout.write(JSON.stringify(verbs[question.do](question) ?? {}) + "\n");
  }
}

// The power of two that takes the smallest of masses and moments to about one, for engines that take small ones for
// nothing: motion depends on ratios only, and a power of two changes no bit of it.
export const scaleToOne = (...massesAndMoments) => 2 ** -Math.ceil(Math.log2(Math.min(...massesAndMoments)));

// Whether a speed has reached the limit that an engine cuts it to.
export function* beyond(what, unit, largest, limit) {
  if (largest >= limit * (1 - 1e-6)) yield ["clamped", `clamped: ${what} reached ${largest.toPrecision(4)} ${unit}; the limit is ${limit.toPrecision(4)}`];
}

const add = (a, b) => a.map((each, i) => each + b[i]);
export const scaled = (s, a) => a.map((each) => s * each);
const dot = (a, b) => a.reduce((sum, each, i) => sum + each * b[i], 0);
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];

// v + 2 (w n + n x n) x v, of q = (w, n).
function turned(q, vector) {
  const n = q.slice(1);
  const once = cross(n, vector);
  return add(vector, scaled(2, add(scaled(q[0], once), cross(n, once))));
}

// The sum of the scene's laws (docs/scene.md) and its torque about the centre of mass, world axes.
export function wrench({ tethers = [], drag, floor, points }, state) {
  const [x, q, v, w] = [state.slice(0, 3), state.slice(3, 7), state.slice(7, 10), state.slice(10)];
  let [force, torque] = drag ? [scaled(-drag.linear, v), scaled(-drag.angular, w)] : [[0, 0, 0], [0, 0, 0]];
  const act = (point, law) => {
    const lever = turned(q, point);
    const pull = law(add(x, lever), add(v, cross(w, lever)));
    [force, torque] = [add(force, pull), add(torque, cross(lever, pull))];
  };
  for (const { point, anchor, stiffness, damping, rest_length: rest } of tethers) {
    act(point, (p, speed) => {
      const d = add(p, scaled(-1, anchor));
      if (!rest) return add(scaled(-stiffness, d), scaled(-damping, speed));
      const length = Math.hypot(...d);
      if (!length) return [0, 0, 0];
      const along = scaled(1 / length, d);
      return scaled(-(stiffness * (length - rest) + damping * dot(speed, along)), along);
    });
  }
  for (const point of floor ? points : []) {
    act(point, (p, speed) => {
      const height = dot(floor.normal, p) - floor.height;
      if (height >= 0) return [0, 0, 0];
      return scaled(Math.max(0, -floor.stiffness * height - floor.damping * dot(floor.normal, speed)), floor.normal);
    });
  }
  return [force, torque];
}
