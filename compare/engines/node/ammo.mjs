// ammo.js, which is Bullet.  States are those of the bodies themselves: motion states are a tick late.
import { installed, serve } from "./contestant.mjs";

const { default: initAmmo } = await installed("ammojs-typed/ammo/ammo.js");
const ammo = await initAmmo();
const NEVER_SLEEPS = 4; // DISABLE_DEACTIVATION
const GYROSCOPIC = 2; // the only flag of btRigidBodyFlags for it that this Bullet knows: explicitly, up to 100 N m
const LARGEST_BITS = 20; // the largest moment is 2^-20 there, and its torque 100 N m at 1e4 rad/s
const NOTHING = 0; // of collision groups and masks
const [first, second] = [new ammo.btVector3(), new ammo.btVector3()];
const [pose, turn] = [new ammo.btTransform(), new ammo.btQuaternion(0, 0, 0, 1)];
const set = (vector, [x, y, z]) => (vector.setValue(x, y, z), vector);

await serve({
  build({ throws, mass, moments, gravity = [0, 0, 0] }, manner) {
    const configuration = new ammo.btDefaultCollisionConfiguration();
    const dispatcher = new ammo.btCollisionDispatcher(configuration);
    const broadphase = new ammo.btDbvtBroadphase(), solver = new ammo.btSequentialImpulseConstraintSolver();
    const world = new ammo.btDiscreteDynamicsWorld(dispatcher, broadphase, solver, configuration);
    world.setGravity(set(first, gravity));
    // Motion depends on ratios of masses, moments and forces alone: so small, no torque is ever cut to its 100 N m.
    const scale = manner === "defaults" ? 1 : 2 ** -(Math.ceil(Math.log2(Math.max(...moments))) + LARGEST_BITS);
    const shape = new ammo.btSphereShape(1);
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
      world.addRigidBody(body, NOTHING, NOTHING);
      return body;
    });
    return { world, bodies, scale, made: [...bodies, world, solver, broadphase, dispatcher, configuration] };
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
