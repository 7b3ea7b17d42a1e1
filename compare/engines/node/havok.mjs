// Havok, the WebAssembly of Babylon.js.  It has no plane: there is the top of a large box.  It has no forces but gravity:
// `push` gives the impulse of a step.  Of a pair of materials it takes one of two numbers: both are the pair's.
import { readFileSync } from "node:fs";
import { beyond, installed, scaleToOne, scaled, serve } from "./contestant.mjs";

const LIBRARY = "@babylonjs/havok/lib/esm";
const { default: initHavok } = await installed(`${LIBRARY}/HavokPhysics_es.js`);
const hk = await initHavok({
  wasmBinary: readFileSync(`${process.env.TUMBLE_ENVIRONMENT}/node_modules/${LIBRARY}/HavokPhysics.wasm`),
});
const LARGEST_SPEED = 200, LARGEST_SPIN = 100, BOUNDLESS = 1e18;
const ORIGIN = [0, 0, 0], IDENTITY = [0, 0, 0, 1];
const THROWN = [1, 2], GROUND = [2, 1]; // what a shape is, and what it touches
const ROUNDED = 1e-6; // of a moment: what single precision may lose on the way
// Half the edge of the box whose top is the plane, in diameters of the body: of one of 1000 contacts are up to 6 % of the
// diameter off.
const FAR = 200;

// Calls answer [result, value], or a result alone.
function made([result, value]) {
  if (result !== hk.Result.RESULT_OK) throw new Error("Havok refuses");
  return value;
}

// A body's shape: a box, a sphere, a cylinder, or the convex hull of the points.
function shapeOf({ shape, points }) {
  if (shape?.kind === "sphere") return made(hk.HP_Shape_CreateSphere(ORIGIN, shape.radius));
  if (shape?.kind === "box") return made(hk.HP_Shape_CreateBox(ORIGIN, IDENTITY, shape.size));
  if (shape?.kind === "disc") {
    const half = shape.thickness / 2;
    return made(hk.HP_Shape_CreateCylinder([0, 0, -half], [0, 0, half], shape.radius));
  }
  const at = hk._malloc(12 * points.length);
  new Float32Array(hk.HEAPU8.buffer, at, 3 * points.length).set(points.flat());
  const hull = made(hk.HP_Shape_CreateConvexHull(at, points.length));
  hk._free(at);
  return hull;
}

function touch(shape, { restitution, friction }, group) {
  const { MINIMUM, MAXIMUM } = hk.MaterialCombine;
  hk.HP_Shape_SetMaterial(shape, [friction, friction, restitution, MINIMUM, MAXIMUM]);
  hk.HP_Shape_SetFilterInfo(shape, group);
}

// The quaternion x y z w that turns y onto a normal.
function turnUp([x, y, z]) {
  const length = Math.hypot(1 + y, x, z);
  return length < 1e-9 ? [1, 0, 0, 0] : [z / length, 0, -x / length, (1 + y) / length];
}

const farOf = (points) => FAR * 2 * Math.max(...points.map((point) => Math.hypot(...point)));

function addPlane(world, { plane, points }) {
  const far = farOf(points);
  const shape = made(hk.HP_Shape_CreateBox([0, -far, 0], IDENTITY, [2 * far, 2 * far, 2 * far]));
  touch(shape, plane, GROUND);
  const ground = made(hk.HP_Body_Create());
  hk.HP_Body_SetShape(ground, shape);
  hk.HP_Shape_Release(shape);
  hk.HP_Body_SetMotionType(ground, hk.MotionType.STATIC);
  hk.HP_Body_SetQTransform(ground, [plane.point, turnUp(plane.normal)]);
  hk.HP_World_AddBody(world, ground, false);
  return ground;
}

function worldOf(told, manner) {
  const world = made(hk.HP_World_Create());
  hk.HP_World_SetGravity(world, told.gravity ?? ORIGIN);
  if (manner !== "defaults") {
    hk.HP_World_SetSpeedLimit(world, BOUNDLESS, BOUNDLESS);
    hk.HP_World_SetIdealStepTime(world, 0);
  }
  return world;
}

function bodyOf(told, massProperties, manner) {
  const body = made(hk.HP_Body_Create());
  if (told.plane) {
    const shape = shapeOf(told);
    touch(shape, told.plane, THROWN);
    hk.HP_Body_SetShape(body, shape);
    hk.HP_Shape_Release(shape);
  }
  hk.HP_Body_SetMotionType(body, hk.MotionType.DYNAMIC);
  hk.HP_Body_SetMassProperties(body, massProperties);
  if (manner !== "defaults") {
    hk.HP_Body_SetAngularDamping(body, 0);
    hk.HP_Body_SetActivationControl(body, hk.ActivationControl.ALWAYS_ACTIVE);
  }
  return body;
}

// Whether a place is over the box that stands for the plane, and no deeper than that.
const isOver = ({ plane, points }, x) => Math.hypot(...x.map((each, i) => each - plane.point[i])) < farOf(points);

// By how much the inverse of a moment is off, of which Havok keeps eight bits.
function lost(moment) {
  const inverse = 1 / moment, bit = 2 ** (Math.floor(Math.log2(inverse)) - 7);
  return Math.abs((Math.round(inverse / bit) * bit) / inverse - 1);
}

await serve({
  build(told, manner) {
    const { throws, mass, moments, plane } = told;
    const scale = manner === "defaults" ? 1 : scaleToOne(mass, ...moments);
    const properties = [ORIGIN, scale * mass, moments.map((each) => each / mass), IDENTITY];
    // Where there is a plane every throw has a world of its own: Havok rounds bodies together that touch something.
    const worlds = Array.from({ length: plane ? throws : 1 }, () => worldOf(told, manner));
    const bodies = Array.from({ length: throws }, () => bodyOf(told, properties, manner));
    const grounds = plane ? worlds.map((world) => addPlane(world, told)) : [];
    bodies.forEach((body, row) => hk.HP_World_AddBody(worlds[plane ? row : 0], body, false));
    const rounding = Math.max(...moments.map((moment) => lost(scale * moment)));
    return { worlds, bodies, scale, rounding, all: [...bodies, ...grounds], pushes: [] };
  },
  put({ bodies }, row, [x, y, z, w, i, j, k, ...rest]) {
    const body = bodies[row];
    hk.HP_Body_SetQTransform(body, [[x, y, z], [i, j, k, w]]);
    hk.HP_Body_SetLinearVelocity(body, rest.slice(0, 3));
    hk.HP_Body_SetAngularVelocity(body, rest.slice(3));
    hk.HP_Body_SetActivationState(body, hk.ActivationState.ACTIVE);
  },
  get({ bodies }, row) {
    const body = bodies[row], [x, [i, j, k, w]] = made(hk.HP_Body_GetQTransform(body));
    return [...x, w, i, j, k, ...made(hk.HP_Body_GetLinearVelocity(body)), ...made(hk.HP_Body_GetAngularVelocity(body))];
  },
  push({ bodies, scale, pushes }, row, force, torque) {
    pushes.push([bodies[row], scaled(scale, force), scaled(scale, torque)]);
  },
  step({ worlds, pushes }, dt) {
    for (const [body, force, torque] of pushes.splice(0)) {
      hk.HP_Body_ApplyImpulse(body, made(hk.HP_Body_GetQTransform(body))[0], scaled(dt, force));
      hk.HP_Body_ApplyAngularImpulse(body, scaled(dt, torque));
    }
    for (const world of worlds) hk.HP_World_Step(world, dt);
  },
  audit({ bodies, manner, fastest, told, held, rounding }) {
    const findings = [];
    if ((told.plane || held) && rounding > ROUNDED) {
      findings.push(["another-body", `of the inverse of a moment it keeps 8 bits: the largest error is ${(100 * rounding).toPrecision(2)} %`]);
    }
    if (told.plane && bodies.some((body) => !isOver(told, made(hk.HP_Body_GetQTransform(body))[0]))) {
      findings.push(["other", `it is further than ${farOf(told.points).toPrecision(3)} m from the plane's point, where the box ends that stands for the plane`]);
    }
    if (manner !== "defaults") return findings;
    findings.push(["damped", "w is damped, by 0.1 a second"]);
    return [...findings, ...beyond("|v|", "m/s", fastest[0], LARGEST_SPEED), ...beyond("|w|", "rad/s", fastest[1], LARGEST_SPIN)];
  },
  end({ worlds, all }) {
    all.forEach((body) => hk.HP_Body_Release(body));
    worlds.forEach((world) => hk.HP_World_Release(world));
  },
});
