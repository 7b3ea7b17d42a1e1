// Vectors and quaternions as arrays: (x, y, z) and (w, x, y, z).

/**
 * The product of two quaternions.
 * @param {Quaternion} p
 * @param {Quaternion} q
 */
export function product(p, q) {
  const [pw, px, py, pz] = p;
  const [qw, qx, qy, qz] = q;
  return [
    pw * qw - px * qx - py * qy - pz * qz,
    pw * qx + px * qw + py * qz - pz * qy,
    pw * qy - px * qz + py * qw + pz * qx,
    pw * qz + px * qy - py * qx + pz * qw,
  ];
}

export function dot(a, b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

export function cross(a, b) {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}

export function minus(a, b) {
  return [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
}

/** The unit normal of a face whose corners go round counter-clockwise from outside. */
export function normalOf(corners) {
  const across = corners.length > 3 ? [minus(corners[2], corners[0]), minus(corners[3], corners[1])] : [minus(corners[1], corners[0]), minus(corners[2], corners[0])];
  const normal = cross(...across);
  const length = Math.hypot(...normal) || 1;
  return normal.map((value) => value / length);
}

/**
 * A vector rotated by a unit quaternion.
 * @param {Quaternion} q
 * @param {Vector} v
 */
export function rotated(q, v) {
  const [w, x, y, z] = q;
  const t = cross([x, y, z], v).map((value) => 2 * value);
  const u = cross([x, y, z], t);
  return [0, 1, 2].map((i) => v[i] + w * t[i] + u[i]);
}

export function unit(vector) {
  const length = Math.hypot(...vector);
  return vector.map((value) => value / length);
}
