// ammo.js, which is Bullet.  States are those of the bodies themselves: motion states are a tick late.
import { installed, scaled, serve } from "./contestant.mjs";

const { default: initAmmo } = await installed("ammojs-typed/ammo/ammo.js");
const ammo = await initAmmo();
const NEVER_SLEEPS = 4; // DISABLE_DEACTIVATION
const GYROSCOPIC = 2; // the only flag of btRigidBodyFlags for it that this Bullet knows: explicitly, up to 100 N m
const LARGEST_BITS = 20; // the largest moment is 2^-20 there, and its torque 100 N m at 1e4 rad/s
const NOTHING = 0, THROWN = 1, GROUND = 2; // of collision groups and masks
const ITERATIONS = 50; // of its solver, where there is a plane; it has 10 unless told otherwise
const [first, second] = [new ammo.btVector3(), new ammo.btVector3()];
const [pose, turn] = [new ammo.btTransform(), new ammo.btQuaternion(0, 0, 0, 1)];
const set = (vector, [x, y, z]) => (vector.setValue(x, y, z), vector);

// What touches the plane: a box, a sphere, a cylinder, or the convex hull of the points.  The margin, of 4 cm unless told
// otherwise, lies inside of all of them but a hull, and outside of that.
function shapeOf({ shape, points }, manner) {
  if (!shape) return new ammo.btSphereShape(1);
  const { kind, size, radius, thickness } = shape;
  if (kind === "sphere") return new ammo.btSphereShape(radius);
  const makers = {
    box: () => new ammo.btBoxShape(set(first, scaled(1 / 2, size))),
    disc: () => new ammo.btCylinderShapeZ(set(first, [radius, radius, thickness / 2])),
    hull: () => new ammo.btConvexHullShape(),
  };
  const made = makers[kind]();
  if (kind === "hull") points.forEach((point) => made.addPoint(set(first, point), true));
  if (manner !== "defaults") made.setMargin(kind === "hull" ? 0 : Math.min(...(size ?? [thickness])) / 20);
  return made;
}

// The plane.  Bullet multiplies two materials: it has 1 and 1, and the body what the pair has.
function groundOf({ plane }, manner) {
  const shape = new ammo.btStaticPlaneShape(set(first, plane.normal), 0);
  pose.setIdentity();
  pose.setOrigin(set(first, plane.point));
  const info = new ammo.btRigidBodyConstructionInfo(0, new ammo.btDefaultMotionState(pose), shape, set(second, [0, 0, 0]));
  const body = new ammo.btRigidBody(info);
  body.setRestitution(manner === "defaults" ? plane.restitution : 1);
  body.setFriction(manner === "defaults" ? plane.friction : 1);
  return body;
}

await serve({
  build(told, manner) {
    const { throws, mass, moments, plane, gravity = [0, 0, 0] } = told;
    const configuration = new ammo.btDefaultCollisionConfiguration();
    const dispatcher = new ammo.btCollisionDispatcher(configuration);
    const broadphase = new ammo.btDbvtBroadphase(), solver = new ammo.btSequentialImpulseConstraintSolver();
    const world = new ammo.btDiscreteDynamicsWorld(dispatcher, broadphase, solver, configuration);
    world.setGravity(set(first, gravity));
    // Motion depends on ratios of masses, moments and forces alone: so small, no torque is ever cut to its 100 N m.
    const scale = manner === "defaults" ? 1 : 2 ** -(Math.ceil(Math.log2(Math.max(...moments))) + LARGEST_BITS);
    const ground = plane ? [groundOf(told, manner)] : [];
    ground.forEach((one) => world.addRigidBody(one, GROUND, THROWN));
    if (plane && manner !== "defaults") {
      const solving = world.getSolverInfo();
      solving.m_numIterations = ITERATIONS;
      solving.m_splitImpulse = true; // what takes a body out of the plane gives it no speed
      solving.m_splitImpulsePenetrationThreshold = 0;
    }
    const shape = shapeOf(told, manner);
    pose.setIdentity();
    const bodies = Array.from({ length: throws }, () => {
      const state = new ammo.btDefaultMotionState(pose);
      const info = new ammo.btRigidBodyConstructionInfo(
        scale * mass, state, shape, set(second, moments.map((moment) => scale * moment)));
      const body = new ammo.btRigidBody(info);
      if (manner !== "defaults") {
        body.setActivationState(NEVER_SLEEPS);
        body.setFlags(GYROSCOPIC);
      }
      if (plane) {
        body.setRestitution(plane.restitution);
        body.setFriction(plane.friction);
        if (manner !== "defaults") body.setContactProcessingThreshold(0); // ahead of a contact it brakes, with no rebound
      }
      world.addRigidBody(body, plane ? THROWN : NOTHING, plane ? GROUND : NOTHING);
      return body;
    });
    return { world, bodies, scale, made: [...bodies, ...ground, world, solver, broadphase, dispatcher, configuration] };
  },
  put({ bodies }, row, [x, y, z, w, i, j, k, ...rest]) {
    const body = bodies[row];
    turn.setValue(i, j, k, w);
    pose.setOrigin(set(first, [x, y, z]));
    pose.setRotation(turn);
    body.setLinearVelocity(set(first, rest.slice(0, 3)));
    body.setAngularVelocity(set(second, rest.slice(3)));
    body.setCenterOfMassTransform(pose); // and with it the inertia tensor in world axes
    body.clearForces();
    body.activate(true);
  },
  get({ bodies }, row) {
    const body = bodies[row], at = body.getCenterOfMassTransform();
    const parts = [];
    for (const part of [() => at.getOrigin(), () => at.getRotation(), () => body.getLinearVelocity(), () => body.getAngularVelocity()]) {
      const value = part();
      if (value.w) parts.push(value.w());
      parts.push(value.x(), value.y(), value.z());
    }
    return parts;
  },
  push({ bodies, scale }, row, force, torque) {
    bodies[row].applyCentralForce(set(first, force.map((each) => scale * each)));
    bodies[row].applyTorque(set(second, torque.map((each) => scale * each)));
  },
  step({ world }, dt) {
    world.stepSimulation(dt, 0);
  },
  end({ made }) {
    made.forEach((each) => ammo.destroy(each));
  },
});
