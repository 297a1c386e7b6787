import type { Field, Source } from './types';

/** Numbers about values, and the ends of their colour map: what 99 of 100 vertices are within. */
export function describe(values: Float32Array, signed = false): Field {
  let smallest = Infinity, largest = -Infinity, sum = 0, squares = 0;
  for (const value of values) {
    if (value < smallest) smallest = value;
    if (value > largest) largest = value;
    sum += value;
    squares += value * value;
  }
  const high = quantile(signed ? values.map(Math.abs) : values, signed ? 0.95 : 0.99) || largest || 1;
  const low = signed ? -high : 0;
  return { values, low, high, smallest, largest, mean: sum / values.length, rms: Math.sqrt(squares / values.length) };
}

function quantile(values: Float32Array, share: number): number {
  const sorted = values.slice().sort();
  return sorted[Math.min(sorted.length - 1, Math.floor(share * sorted.length))];
}

/** How far each vertex went. The meshes have the same vertices in the same order. */
export function displacement(before: Source, after: Source): Float32Array {
  const a = before.positions, b = after.positions;
  const values = new Float32Array(a.length / 3);
  for (let v = 0, k = 0; v < values.length; v++, k += 3) values[v] = Math.hypot(b[k] - a[k], b[k + 1] - a[k + 1], b[k + 2] - a[k + 2]);
  return values;
}

/** Mean curvature, in one over the file's unit: how fast the normal turns along the edges; positive where the surface bulges. */
export function curvature({ positions, indices }: Source, normals: Float32Array, first: Uint32Array): Float32Array {
  const sums = new Float64Array(first.length), counts = new Uint32Array(first.length);
  for (let k = 0; k < indices.length; k++) {
    const a = first[indices[k]], b = first[indices[k % 3 === 2 ? k - 2 : k + 1]];
    let turned = 0, squared = 0;
    for (let axis = 0; axis < 3; axis++) {
      const along = positions[3 * b + axis] - positions[3 * a + axis];
      turned += (normals[3 * b + axis] - normals[3 * a + axis]) * along;
      squared += along * along;
    }
    if (squared === 0) continue;
    for (const v of [a, b]) {
      sums[v] += turned / squared;
      counts[v]++;
    }
  }
  return Float32Array.from(first, (v) => (counts[v] ? sums[v] / counts[v] : 0));
}
