import type { Hit, Source } from './types';

/** The first triangle that a ray meets. One look at every triangle is quick enough for a click. */
export function pick({ positions, indices }: Source, from: readonly number[], along: readonly number[], values?: Float32Array): Hit | null {
  let nearest = Infinity, triangle = -1, u = 0, v = 0;
  const [dx, dy, dz] = along;
  for (let k = 0; k < indices.length; k += 3) {
    const a = indices[k] * 3, b = indices[k + 1] * 3, c = indices[k + 2] * 3;
    const ax = positions[a], ay = positions[a + 1], az = positions[a + 2];
    const ux = positions[b] - ax, uy = positions[b + 1] - ay, uz = positions[b + 2] - az;
    const vx = positions[c] - ax, vy = positions[c + 1] - ay, vz = positions[c + 2] - az;
    const px = dy * vz - dz * vy, py = dz * vx - dx * vz, pz = dx * vy - dy * vx;
    const determinant = ux * px + uy * py + uz * pz;
    if (determinant === 0) continue;
    const tx = from[0] - ax, ty = from[1] - ay, tz = from[2] - az;
    const s = (tx * px + ty * py + tz * pz) / determinant;
    if (s < 0 || s > 1) continue;
    const qx = ty * uz - tz * uy, qy = tz * ux - tx * uz, qz = tx * uy - ty * ux;
    const t = (dx * qx + dy * qy + dz * qz) / determinant;
    if (t < 0 || s + t > 1) continue;
    const distance = (vx * qx + vy * qy + vz * qz) / determinant;
    if (distance > 0 && distance < nearest) { nearest = distance; triangle = k / 3; u = s; v = t; }
  }
  if (triangle < 0) return null;
  const corners = [0, 1, 2].map((k) => indices[3 * triangle + k]);
  const weights = [1 - u - v, u, v];
  return {
    triangle,
    vertex: corners[weights.indexOf(Math.max(...weights))],
    position: [0, 1, 2].map((axis) => from[axis] + nearest * along[axis]) as Hit['position'],
    value: values && corners.reduce((sum, corner, k) => sum + weights[k] * values[corner], 0),
  };
}
