import { firstAtPlace, vertexNormals } from './geometry';
import type { SampleKind, Source } from './types';

/** Made-up scans for people without one: a shape, and the same with the noise of a scanner. */
export interface Sample { noisy: string; clean: string }

export function makeSample(kind: SampleKind): Sample {
  const shape = kind === 'machined' ? machinedPart(64) : knot(420, 56);
  return { noisy: toObj(withNoise(shape, 0.25), kind), clean: toObj(shape, kind) };
}

/** A die of 80 mm: flat faces that meet a ball along sharp circles, with a boss, a bowl or a step in each. Edges of the mesh run along the creases. */
function machinedPart(cells: number): Source {
  const half = 40, ball = 52, rim = Math.sqrt(ball * ball - half * half) / half;
  const ring = Math.round(cells * 0.41) / (cells / 2), inner = (Math.round(ring * cells * 0.28) * 2) / cells;
  const points: number[] = [], triangles: number[] = [], known = new Map<string, number>();
  const vertex = (face: number, i: number, j: number) => {
    const u = (2 * i) / cells - 1, v = (2 * j) / cells - 1;
    const side = Math.max(Math.abs(u), Math.abs(v)), length = Math.hypot(u, v) || 1;
    const round = [u / length, v / length];
    const t = Math.max(0, (side - ring) / (1 - ring));
    const radius = side <= ring ? (rim * side) / ring : rim;
    const [x, y] = [0, 1].map((k) => (radius * round[k] * (1 - t) + [u, v][k] * t) * half);
    let point = [x, y, half];
    if (side > ring) { const far = Math.hypot(...point); point = point.map((value) => (value * ball) / far); }
    else point[2] += relief(face, side / inner, 2 / cells / inner);
    return place(face, point);
  };
  const place = (face: number, [x, y, z]: number[]) => {
    const turned = [[x, y, z], [-x, y, -z], [z, y, -x], [-z, y, x], [x, z, -y], [x, -z, y]][face];
    const key = turned.map((value) => Math.round(value * 1e4)).join();
    if (!known.has(key)) { known.set(key, points.length / 3); points.push(...turned); }
    return known.get(key)!;
  };
  for (let face = 0; face < 6; face++) {
    for (let i = 0; i < cells; i++) {
      for (let j = 0; j < cells; j++) {
        const [a, b, c, d] = [vertex(face, i, j), vertex(face, i + 1, j), vertex(face, i + 1, j + 1), vertex(face, i, j + 1)];
        const falling = (i < cells / 2) === (j < cells / 2);
        triangles.push(...(falling ? [a, b, c, a, c, d] : [a, b, d, b, c, d]));
      }
    }
  }
  return { positions: Float64Array.from(points), indices: Uint32Array.from(triangles) };
}

/** Height above the face; `at` counts from its middle to the rim of the relief (1), `cell` is a cell of the mesh. Walls slope over three cells. */
function relief(face: number, at: number, cell: number): number {
  if (face === 2) return at < 1 ? 9 * Math.sqrt(1 - at * at) : 0;
  if (face % 2 === 1) return at < 1 ? -8 * (1 - at * at) : 0;
  return (face === 0 ? 6 : -6) * Math.max(0, Math.min(1, (1 + 1.5 * cell - at) / (3 * cell)));
}

/** A trefoil whose tube swells and thins; free-form all over. */
function knot(along: number, around: number): Source {
  const positions = new Float64Array(along * around * 3), indices = new Uint32Array(along * around * 6);
  const curve = (t: number) => [Math.sin(t) + 2 * Math.sin(2 * t), Math.cos(t) - 2 * Math.cos(2 * t), -1.4 * Math.sin(3 * t)];
  const cross = (a: number[], b: number[]) => [0, 1, 2].map((k) => a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3]);
  const unit = (a: number[]) => a.map((value) => value / Math.hypot(...a));
  for (let i = 0; i < along; i++) {
    const t = (2 * Math.PI * i) / along;
    const at = curve(t), ahead = curve(t + 1e-3), behind = curve(t - 1e-3);
    const tangent = unit(ahead.map((value, k) => value - behind[k]));
    const bend = ahead.map((value, k) => value + behind[k] - 2 * at[k]);
    const side = unit(cross(tangent, bend)), up = cross(side, tangent);
    for (let j = 0; j < around; j++) {
      const angle = (2 * Math.PI * j) / around;
      const thick = 0.62 + 0.12 * Math.sin(6 * t) + 0.05 * Math.cos(3 * angle + 12 * t);
      for (let k = 0; k < 3; k++) positions[3 * (i * around + j) + k] = 15 * (at[k] + thick * (Math.cos(angle) * up[k] + Math.sin(angle) * side[k]));
      const next = ((i + 1) % along) * around, turn = (j + 1) % around;
      indices.set([i * around + j, i * around + turn, next + turn, i * around + j, next + turn, next + j], 6 * (i * around + j));
    }
  }
  return { positions, indices };
}

/** Gaussian noise along the normals, `amount` mean edge lengths; the same every time. */
function withNoise(shape: Source, amount: number): Source {
  const { positions, indices } = shape;
  const normals = vertexNormals(shape, firstAtPlace(positions));
  let lengths = 0, seed = 20061108;
  for (let k = 0; k < indices.length; k++) {
    const a = indices[k] * 3, b = indices[k % 3 === 2 ? k - 2 : k + 1] * 3;
    lengths += Math.hypot(positions[b] - positions[a], positions[b + 1] - positions[a + 1], positions[b + 2] - positions[a + 2]);
  }
  const random = () => {
    seed = (Math.imul(seed, 1664525) + 1013904223) >>> 0;
    return (seed + 0.5) / 2 ** 32;
  };
  const noisy = positions.slice();
  for (let k = 0; k < noisy.length; k += 3) {
    const by = amount * (lengths / indices.length) * Math.sqrt(-2 * Math.log(random())) * Math.cos(2 * Math.PI * random());
    for (let axis = 0; axis < 3; axis++) noisy[k + axis] += by * normals[k + axis];
  }
  return { positions: noisy, indices };
}

function toObj({ positions, indices }: Source, name: string): string {
  const lines = [`# A made-up scan for Burnish, in millimetres`, `o ${name}`];
  for (let k = 0; k < positions.length; k += 3) lines.push(`v ${[0, 1, 2].map((axis) => positions[k + axis].toFixed(5)).join(' ')}`);
  for (let k = 0; k < indices.length; k += 3) lines.push(`f ${indices[k] + 1} ${indices[k + 1] + 1} ${indices[k + 2] + 1}`);
  return lines.join('\n') + '\n';
}
