// Rapier.  One substep, so that a step is dt, but four where there is a plane; its limits of 400 m/s and pi/4 a step
// cannot be lifted from JavaScript.
import { readFileSync } from "node:fs";
import { beyond, installed, serve } from "./contestant.mjs";

const PACKAGE = "@dimforge/rapier3d-compat"; // its module has another name in older releases
const { module } = JSON.parse(readFileSync(`${process.env.TUMBLE_ENVIRONMENT}/node_modules/${PACKAGE}/package.json`));
const { default: rapier } = await installed(`${PACKAGE}/${module}`);
await rapier.init();
const LARGEST_SPEED = 400, LARGEST_TURN = Math.PI / 4;
const vector = ([x, y, z]) => ({ x, y, z });
const ORIGIN = vector([0, 0, 0]), IDENTITY = { x: 0, y: 0, z: 0, w: 1 };

const GROUND = 0x00010002, THROWN = 0x00020001; // groups: what it is, and what it touches

// What touches the plane: a box, a sphere, a cylinder, or the convex hull of the points.
function shapeOf({ shape, points }) {
  if (shape.kind === "sphere") return rapier.ColliderDesc.ball(shape.radius);
  if (shape.kind === "box") return rapier.ColliderDesc.cuboid(...shape.size.map((edge) => edge / 2));
  if (shape.kind === "disc") {
    const disc = rapier.ColliderDesc.cylinder(shape.thickness / 2, shape.radius); // its axis is y
    return disc.setRotation({ x: Math.SQRT1_2, y: 0, z: 0, w: Math.SQRT1_2 });
  }
  return rapier.ColliderDesc.convexHull(new Float32Array(points.flat()));
}

// A shape with the pair's coefficients: Rapier takes the mean of two materials.
const touching = (desc, { restitution, friction }, groups) =>
  desc.setRestitution(restitution).setFriction(friction).setDensity(0).setCollisionGroups(groups);

await serve({
  build(told, manner) {
    const { throws, mass, moments, plane, points, gravity = [0, 0, 0] } = told;
    const world = new rapier.World(vector(gravity)), diameter = 2 * Math.max(...points.map((point) => Math.hypot(...point)));
    if (manner !== "defaults" && !plane) world.numSolverIterations = 1;
    if (manner !== "defaults" && plane) world.lengthUnit = diameter; // its margins are shares of it
    if (plane) {
      const ground = new rapier.ColliderDesc(new rapier.HalfSpace(vector(plane.normal)));
      world.createCollider(touching(ground, plane, GROUND).setTranslation(...plane.point));
    }
    const bodies = Array.from({ length: throws }, () => {
      const desc = rapier.RigidBodyDesc.dynamic().setAdditionalMassProperties(mass, ORIGIN, vector(moments), IDENTITY);
      if (manner !== "defaults" && plane) desc.setSoftCcdPrediction(diameter); // how far ahead it looks for the plane
      const body = world.createRigidBody(desc.setCanSleep(manner === "defaults"));
      if (plane) world.createCollider(touching(shapeOf(told), plane, THROWN), body);
      return body;
    });
    return { world, bodies };
  },
  put({ bodies }, row, [x, y, z, w, i, j, k, ...rest]) {
    const body = bodies[row];
    body.setTranslation({ x, y, z }, true);
    body.setRotation({ x: i, y: j, z: k, w }, true);
    body.setLinvel(vector(rest.slice(0, 3)), true);
    body.setAngvel(vector(rest.slice(3)), true);
    body.resetForces(true);
    body.resetTorques(true);
  },
  get({ bodies }, row) {
    const body = bodies[row];
    const [x, q, v, w] = [body.translation(), body.rotation(), body.linvel(), body.angvel()];
    return [x.x, x.y, x.z, q.w, q.x, q.y, q.z, v.x, v.y, v.z, w.x, w.y, w.z];
  },
  push({ bodies }, row, force, torque) {
    const body = bodies[row];
    body.resetForces(true);
    body.resetTorques(true);
    body.addForce(vector(force), true);
    body.addTorque(vector(torque), true);
  },
  step({ world }, dt) {
    world.timestep = dt;
    world.step();
  },
  audit({ fastest, longest }) {
    if (!longest) return [];
    const spin = beyond("|w|", "rad/s", fastest[1], LARGEST_TURN / longest);
    return [...beyond("|v|", "m/s", fastest[0], LARGEST_SPEED), ...spin];
  },
  end({ world }) {
    world.free();
  },
});
