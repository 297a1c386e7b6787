import type { Source } from './types';

/** For every vertex the first one at its place: files with seams, and all STL files, repeat positions. */
export function firstAtPlace(positions: Float64Array): Uint32Array {
  const vertices = positions.length / 3;
  let slots = 16;
  while (slots < vertices * 2) slots *= 2;
  const table = new Int32Array(slots).fill(-1);
  const words = new Int32Array(positions.buffer, positions.byteOffset, positions.length * 2);
  const first = new Uint32Array(vertices);
  for (let v = 0; v < vertices; v++) {
    let hash = 0;
    for (let k = 6 * v; k < 6 * v + 6; k++) hash = Math.imul(hash ^ words[k], 0x9e3779b1) ^ (hash >>> 15);
    let slot = (hash ^ (hash >>> 13)) & (slots - 1);
    for (; ; slot = (slot + 1) & (slots - 1)) {
      const other = table[slot];
      if (other < 0) { table[slot] = v; first[v] = v; break; }
      if (positions[3 * other] === positions[3 * v] && positions[3 * other + 1] === positions[3 * v + 1] &&
          positions[3 * other + 2] === positions[3 * v + 2]) { first[v] = other; break; }
    }
  }
  return first;
}

/** Unit normals of vertices: the mean of the triangles around, by area. */
export function vertexNormals({ positions, indices }: Source, first: Uint32Array): Float32Array {
  const sums = new Float64Array(positions.length);
  for (let k = 0; k < indices.length; k += 3) {
    const a = first[indices[k]] * 3, b = first[indices[k + 1]] * 3, c = first[indices[k + 2]] * 3;
    const ux = positions[b] - positions[a], uy = positions[b + 1] - positions[a + 1], uz = positions[b + 2] - positions[a + 2];
    const vx = positions[c] - positions[a], vy = positions[c + 1] - positions[a + 1], vz = positions[c + 2] - positions[a + 2];
    const x = uy * vz - uz * vy, y = uz * vx - ux * vz, z = ux * vy - uy * vx;
    for (const at of [a, b, c]) { sums[at] += x; sums[at + 1] += y; sums[at + 2] += z; }
  }
  const normals = new Float32Array(positions.length);
  for (let v = 0; v < first.length; v++) {
    const at = first[v] * 3;
    const length = Math.hypot(sums[at], sums[at + 1], sums[at + 2]) || 1;
    for (let axis = 0; axis < 3; axis++) normals[3 * v + axis] = sums[at + axis] / length;
  }
  return normals;
}

/** Every edge once, as pairs of vertices. */
export function edgesOf({ indices }: Source, first: Uint32Array): Uint32Array {
  const edges = new Uint32Array(indices.length * 2);
  let size = 0;
  const next = new Int32Array(indices.length).fill(-1);
  const head = new Int32Array(first.length).fill(-1);
  for (let k = 0; k < indices.length; k++) {
    const a = first[indices[k]], b = first[indices[k % 3 === 2 ? k - 2 : k + 1]];
    const low = Math.min(a, b), high = Math.max(a, b);
    let known = head[low];
    while (known >= 0 && edges[2 * known + 1] !== high) known = next[known];
    if (known >= 0) continue;
    edges[2 * size] = low;
    edges[2 * size + 1] = high;
    next[size] = head[low];
    head[low] = size++;
  }
  return edges.slice(0, 2 * size);
}

export interface Box { centre: [number, number, number]; radius: number }

export function boxOf(positions: Float64Array): Box {
  const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  for (let k = 0; k < positions.length; k++) {
    const axis = k % 3, value = positions[k];
    if (value < low[axis]) low[axis] = value;
    if (value > high[axis]) high[axis] = value;
  }
  const centre = low.map((value, axis) => (value + high[axis]) / 2) as [number, number, number];
  return { centre, radius: Math.hypot(...low.map((value, axis) => high[axis] - value)) / 2 || 1 };
}

/** Relative to an origin, so that single precision keeps what is far from zero. */
export function relativeTo(origin: readonly number[], positions: Float64Array): Float32Array {
  const relative = new Float32Array(positions.length);
  for (let k = 0; k < positions.length; k++) relative[k] = positions[k] - origin[k % 3];
  return relative;
}

export const sameTriangles = (a: Source, b: Source) =>
  a.positions.length === b.positions.length && a.indices.length === b.indices.length && a.indices.every((index, k) => index === b.indices[k]);
