// node engine.mjs; command = ["node", "engine.mjs"]
import { createInterface } from "node:readline";

const product = (p, q) => [
  p[0] * q[0] - p[1] * q[1] - p[2] * q[2] - p[3] * q[3], p[0] * q[1] + p[1] * q[0] + p[2] * q[3] - p[3] * q[2],
  p[0] * q[2] + p[2] * q[0] + p[3] * q[1] - p[1] * q[3], p[0] * q[3] + p[3] * q[0] + p[1] * q[2] - p[2] * q[1],
];
const conjugate = (q) => [q[0], -q[1], -q[2], -q[3]];

function step(s, { moments: [A, B, C], gravity = [0, 0, 0] }, dt) {
  const q = s.slice(3, 7);
  const [, a, b, c] = product(product(conjugate(q), [0, ...s.slice(10)]), q);
  const body = [0, a + dt * (B - C) / A * b * c, b + dt * (C - A) / B * c * a, c + dt * (A - B) / C * a * b];
  const w = product(product(q, body), conjugate(q)).slice(1);
  const speed = Math.hypot(...w), part = speed ? Math.sin(dt / 2 * speed) / speed : 0;
  const turned = product([Math.cos(dt / 2 * speed), ...w.map((each) => part * each)], q);
  const length = Math.hypot(...turned);
  const v = gravity.map((g, i) => s[7 + i] + dt * g);
  return [...v.map((each, i) => s[i] + dt * each), ...turned.map((each) => each / length), ...v, ...w];
}

let body, states;
const verbs = {
  build: (message) => void (body = message),
  write: (message) => void (states = message.states),
  advance: ({ n, dt }) => {
    const started = process.hrtime.bigint();
    states = states.map((state) => {
      for (let i = 0; i < n; i++) state = step(state, body, dt);
      return state;
    });
    return { ns: Number(process.hrtime.bigint() - started) };
  },
  read: () => ({ states }), // JSON.stringify writes null for what is not finite
};
for await (const line of createInterface({ input: process.stdin })) {
  const message = JSON.parse(line);
  process.stdout.write(JSON.stringify(verbs[message.do]?.(message) ?? {}) + "\n");
}
