// Jolt.  Its gyroscopic torque is asked for; damping, limits of speed and sleep are off; masses are those of a body that
// it does not take for nothing.  Without a plane a body has the box around its points for a shape, by which Jolt sees
// whether it moves; it collides with nothing.
import { beyond, installed, scaleToOne, serve } from "./contestant.mjs";

const { default: initJolt } = await installed("jolt-physics/dist/jolt-physics.wasm-compat.js");
const jolt = await initJolt();
const BOUNDLESS = 3e38, LAYER = 0, GROUND = 1;
const LARGEST_SPEED = 500, LARGEST_SPIN = 15 * Math.PI;
// Moments whose root of squares is no larger it takes for nothing, and flies a sphere of 1 m [kg m2].
const LEAST_MOMENTS = 1e-6;
// Values that are handed over for the length of a call.
const [first, second, position, rotation] = [new jolt.Vec3(), new jolt.Vec3(), new jolt.RVec3(), new jolt.Quat(0, 0, 0, 1)];

// Margins of contacts are lengths for bodies of 1 m [m]: here they are shares of the diameter.
const LOOK_AHEAD = 0.02, LEFT_BELOW = 0.001, LARGEST_PLANE = 1e6;

// Two layers: bodies collide with the plane alone.
function settings(throws) {
  const made = new jolt.JoltSettings();
  made.mMaxBodies = throws + 8;
  made.mMaxWorkerThreads = 0;
  const pairs = new jolt.ObjectLayerPairFilterTable(2);
  pairs.EnableCollision(LAYER, GROUND);
  const layers = new jolt.BroadPhaseLayerInterfaceTable(2, 2);
  for (const layer of [LAYER, GROUND]) layers.MapObjectToBroadPhaseLayer(layer, new jolt.BroadPhaseLayer(layer));
  made.mObjectLayerPairFilter = pairs;
  made.mBroadPhaseLayerInterface = layers;
  made.mObjectVsBroadPhaseLayerFilter = new jolt.ObjectVsBroadPhaseLayerFilterTable(layers, 2, pairs, 2);
  return made;
}

// What touches the plane: a box, a sphere, a cylinder, or the convex hull of the points; none is rounded.  A hull's centre of mass is
// its own: it is moved to the body's.
function shapeOf({ shape, points }) {
  if (shape?.kind === "sphere") return new jolt.SphereShape(shape.radius);
  if (shape?.kind === "disc") {
    first.Set(0, 0, 0);
    rotation.Set(Math.SQRT1_2, 0, 0, Math.SQRT1_2); // its axis is y
    const disc = new jolt.CylinderShapeSettings(shape.thickness / 2, shape.radius, 0);
    return new jolt.RotatedTranslatedShapeSettings(first, rotation, disc).Create().Get();
  }
  if (shape?.kind === "hull") {
    const hull = new jolt.ConvexHullShapeSettings();
    hull.mMaxConvexRadius = 0;
    points.forEach((point) => (first.Set(...point), hull.mPoints.push_back(first)));
    const shape = hull.Create().Get(), centre = shape.GetCenterOfMass();
    first.Set(-centre.GetX(), -centre.GetY(), -centre.GetZ());
    return new jolt.OffsetCenterOfMassShape(shape, first);
  }
  first.Set(...[0, 1, 2].map((axis) => Math.max(...points.map((point) => Math.abs(point[axis])))));
  return new jolt.BoxShape(first, 0);
}

// The pair's restitution is the larger of two, its friction their geometric mean: both have the pair's numbers.
function touch(made, { restitution, friction }) {
  made.mRestitution = restitution;
  made.mFriction = friction;
}

// The plane, and where it is; contacts are solved as well as Jolt can, but where it is as it ships.
function addPlane(system, { plane, points }, manner) {
  position.Set(...plane.point);
  first.Set(...plane.normal);
  const shape = new jolt.PlaneShape(new jolt.Plane(first, 0), null, LARGEST_PLANE);
  const made = new jolt.BodyCreationSettings(shape, position, jolt.Quat.prototype.sIdentity(), jolt.EMotionType_Static, GROUND);
  touch(made, plane);
  const ground = system.GetBodyInterface().CreateBody(made);
  system.GetBodyInterface().AddBody(ground.GetID(), jolt.EActivation_DontActivate);
  if (manner === "defaults") return;
  const contacts = system.GetPhysicsSettings(), diameter = 2 * Math.max(...points.map((point) => Math.hypot(...point)));
  contacts.mMinVelocityForRestitution = 0;
  contacts.mSpeculativeContactDistance = LOOK_AHEAD * diameter;
  contacts.mPenetrationSlop = LEFT_BELOW * diameter;
  system.SetPhysicsSettings(contacts);
}

function body(mass, moments, told, manner) {
  const shape = shapeOf(told);
  position.Set(0, 0, 0);
  rotation.Set(0, 0, 0, 1);
  const made = new jolt.BodyCreationSettings(shape, position, rotation, jolt.EMotionType_Dynamic, LAYER);
  made.mOverrideMassProperties = jolt.EOverrideMassProperties_MassAndInertiaProvided;
  made.mMassPropertiesOverride.mMass = mass;
  first.Set(...moments);
  made.mMassPropertiesOverride.mInertia = jolt.Mat44.prototype.sScaleVec3(first);
  if (told.plane) touch(made, told.plane);
  if (manner !== "defaults") {
    made.mApplyGyroscopicForce = true;
    made.mLinearDamping = made.mAngularDamping = 0;
    made.mMaxLinearVelocity = made.mMaxAngularVelocity = BOUNDLESS;
    made.mAllowSleeping = false;
  }
  return made;
}

await serve({
  build(told, manner) {
    const { throws, mass, moments, gravity = [0, 0, 0] } = told;
    const scale = manner === "defaults" ? 1 : scaleToOne(mass, ...moments);
    const world = new jolt.JoltInterface(settings(throws));
    const system = world.GetPhysicsSystem(), interfaceOf = system.GetBodyInterface();
    first.Set(...gravity);
    system.SetGravity(first);
    if (told.plane) addPlane(system, told, manner);
    const bodies = Array.from({ length: throws }, () => {
      const one = interfaceOf.CreateBody(body(scale * mass, moments.map((each) => scale * each), told, manner));
      interfaceOf.AddBody(one.GetID(), jolt.EActivation_Activate);
      return one;
    });
    return { world, bodies, interfaceOf, scale };
  },
  put({ bodies, interfaceOf }, row, [x, y, z, w, i, j, k, ...rest]) {
    const id = bodies[row].GetID();
    position.Set(x, y, z);
    rotation.Set(i, j, k, w);
    interfaceOf.SetPositionAndRotation(id, position, rotation, jolt.EActivation_Activate);
    first.Set(...rest.slice(0, 3));
    second.Set(...rest.slice(3));
    interfaceOf.SetLinearAndAngularVelocity(id, first, second);
    bodies[row].ResetForce();
    bodies[row].ResetTorque();
  },
  get({ bodies }, row) {
    const one = bodies[row];
    // What they return lies in one place: each is read before the next is asked for.
    const parts = [];
    for (const part of [() => one.GetPosition(), () => one.GetRotation(), () => one.GetLinearVelocity(), () => one.GetAngularVelocity()]) {
      const value = part();
      if (value.GetW) parts.push(value.GetW());
      parts.push(value.GetX(), value.GetY(), value.GetZ());
    }
    return parts;
  },
  push({ bodies, scale }, row, force, torque) {
    first.Set(...force.map((each) => scale * each));
    second.Set(...torque.map((each) => scale * each));
    bodies[row].AddForce(first);
    bodies[row].AddTorque(second);
  },
  step({ world }, dt) {
    world.Step(dt, 1);
  },
  audit({ manner, fastest, told }) {
    if (manner !== "defaults") return [];
    const findings = [["damped", "v and w are damped, times 1 - 0.05 dt"]];
    findings.push(...beyond("|v|", "m/s", fastest[0], LARGEST_SPEED), ...beyond("|w|", "rad/s", fastest[1], LARGEST_SPIN));
    if (Math.hypot(...told.moments) <= LEAST_MOMENTS) {
      findings.push(["another-body", "moments as small are nothing to Jolt: it turns a sphere of 1 m instead"]);
    }
    return findings;
  },
  end({ world }) {
    jolt.destroy(world);
  },
});
