// cannon-es.  Without a plane a body has no shape; damping, 0.01 of v and w unless told otherwise, is off.
import { installed, serve } from "./contestant.mjs";

const { Body, Box, ContactMaterial, Cylinder, Material, Plane, Quaternion, Sphere, Vec3, World } = await installed("cannon-es/dist/cannon-es.js");

const THROWN = 1, GROUND = 2; // of collision groups and masks
const SIDES = 64; // of the prism that stands for a disc, of 8 unless told otherwise
// Of its solver, where there is a plane: how many iterations at most, of 10 unless told otherwise, and at what change of
// the impulses it is done [N s a kg].
const ITERATIONS = 100, TOLERANCE = 1e-9;

// A contact is a spring and a damper over some steps: here one so stiff that it is rigid [N/m a kg], and so many steps
// that what comes out of the plane gains no speed.
const STIFFNESS = 1e12, RELAXATION = 100;
const hard = (mass) => ({
  contactEquationStiffness: STIFFNESS * mass, contactEquationRelaxation: RELAXATION,
  frictionEquationStiffness: STIFFNESS * mass, frictionEquationRelaxation: RELAXATION,
});

// What touches the plane, and how it is turned: a disc is a prism about y.
function addShape(body, { kind, radius, size, thickness }) {
  if (kind === "sphere") body.addShape(new Sphere(radius));
  else if (kind === "box") body.addShape(new Box(new Vec3(...size.map((edge) => edge / 2))));
  else body.addShape(new Cylinder(radius, radius, thickness, SIDES), new Vec3(), new Quaternion(Math.SQRT1_2, 0, 0, Math.SQRT1_2));
}

// The plane, whose normal is its z axis, with the pair's coefficients; as it ships two materials are multiplied.
function addPlane(world, { plane, mass }, manner) {
  const material = new Material(manner === "defaults" ? plane : {});
  if (manner !== "defaults") {
    world.addContactMaterial(new ContactMaterial(material, material, { ...plane, ...hard(mass) }));
    [world.solver.iterations, world.solver.tolerance] = [ITERATIONS, TOLERANCE * mass];
  }
  const ground = new Body({ mass: 0, shape: new Plane(), material, position: new Vec3(...plane.point) });
  ground.quaternion.setFromVectors(new Vec3(0, 0, 1), new Vec3(...plane.normal));
  [ground.collisionFilterGroup, ground.collisionFilterMask] = [GROUND, THROWN];
  world.addBody(ground);
  return material;
}

await serve({
  cannot: ({ shape }) => (shape?.kind === "hull" ? "its convex hulls need faces, which a program does not receive" : ""),
  build(told, manner) {
    const { throws, mass, moments, plane, shape, gravity = [0, 0, 0] } = told;
    // Where there is a plane every throw has a world of its own: the solver is done when it is done with all.
    const worlds = Array.from({ length: plane ? throws : 1 }, () => new World({ gravity: new Vec3(...gravity) }));
    const bodies = Array.from({ length: throws }, (_, row) => {
      const world = worlds[plane ? row : 0];
      const body = new Body(manner === "defaults" ? { mass } : { mass, linearDamping: 0, angularDamping: 0 });
      if (plane) {
        addShape(body, shape);
        body.material = addPlane(world, told, manner);
        [body.collisionFilterGroup, body.collisionFilterMask] = [THROWN, GROUND];
      }
      body.inertia.set(...moments);
      body.invInertia.set(...moments.map((moment) => 1 / moment));
      world.addBody(body);
      return body;
    });
    return { worlds, bodies };
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
  step({ worlds }, dt) {
    for (const world of worlds) world.step(dt);
  },
  audit({ manner }) {
    return manner === "defaults" ? [["damped", "v and w are damped, times 0.99^dt"]] : [];
  },
});
