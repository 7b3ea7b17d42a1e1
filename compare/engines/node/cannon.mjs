// cannon-es.  A body without a shape; damping, 0.01 of v and w unless told otherwise, is off.
import { installed, serve } from "./contestant.mjs";

const { Body, Vec3, World } = await installed("cannon-es/dist/cannon-es.js");

await serve({
  build({ throws, mass, moments, gravity = [0, 0, 0] }, manner) {
    const world = new World({ gravity: new Vec3(...gravity) });
    const bodies = Array.from({ length: throws }, () => {
      const body = new Body(manner === "defaults" ? { mass } : { mass, linearDamping: 0, angularDamping: 0 });
      body.inertia.set(...moments);
      body.invInertia.set(...moments.map((moment) => 1 / moment));
      world.addBody(body);
      return body;
    });
    return { world, bodies };
  },
  put({ bodies }, row, [x, y, z, w, i, j, k, ...rest]) {
    const body = bodies[row];
    body.position.set(x, y, z);
    body.quaternion.set(i, j, k, w);
    body.velocity.set(...rest.slice(0, 3));
    body.angularVelocity.set(...rest.slice(3));
    body.force.setZero();
    body.torque.setZero();
    body.updateInertiaWorld(true);
  },
  get({ bodies }, row) {
    const { position: x, quaternion: q, velocity: v, angularVelocity: w } = bodies[row];
    return [x.x, x.y, x.z, q.w, q.x, q.y, q.z, v.x, v.y, v.z, w.x, w.y, w.z];
  },
  push({ bodies }, row, force, torque) {
    bodies[row].force.set(...force);
    bodies[row].torque.set(...torque);
  },
  step({ world }, dt) {
    world.step(dt);
  },
  audit({ manner }) {
    return manner === "defaults" ? [["damped", "v and w are damped, times 0.99^dt"]] : [];
  },
});
