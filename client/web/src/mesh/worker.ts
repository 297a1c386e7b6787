/** Everything about meshes that takes longer than a blink, away from the page's own thread. */
import { detectFormat } from './detect';
import { decodeObj } from './decode/obj';
import { decodeOff } from './decode/off';
import { decodePly } from './decode/ply';
import { decodeStl } from './decode/stl';
import { curvature, describe, displacement } from './fields';
import { boxOf, edgesOf, firstAtPlace, relativeTo, sameTriangles, vertexNormals } from './geometry';
import { pick } from './pick';
import { makeSample } from './sample';
import type { Field, FieldKind, Format, Hit, MeshBuffers, SampleKind, Source } from './types';

interface Loaded extends Source {
  first: Uint32Array;
  normals: Float32Array;
  fields: Map<FieldKind, Float32Array>;
}

const meshes = new Map<number, Loaded>();
let lastId = 0;

function mesh(id: number): Loaded {
  const found = meshes.get(id);
  if (!found) throw new Error('the mesh is not here any more');
  return found;
}

async function decode(bytes: Uint8Array, format: Format): Promise<Source> {
  switch (format) {
    case 'glb': return (await import('./decode/glb')).decodeGlb(bytes);
    case 'drc': return (await import('./decode/draco')).decodeDraco(bytes);
    case 'ply': return decodePly(bytes);
    case 'stl': return decodeStl(bytes);
    case 'off': return decodeOff(bytes);
    case 'obj': return decodeObj(bytes);
  }
}

/** Reads a file; `origin` of the first mesh of a scene serves the others. */
async function load(file: Blob, origin?: [number, number, number]): Promise<MeshBuffers> {
  const bytes = new Uint8Array(await file.arrayBuffer());
  const format = detectFormat(bytes);
  const source = await decode(bytes, format);
  if (source.indices.length === 0) throw new Error('the file holds no triangle');
  const odd = source.positions.findIndex((value) => !Number.isFinite(value));
  if (odd >= 0) throw new Error(`coordinate ${'xyz'[odd % 3]} of vertex ${Math.floor(odd / 3)} is not a finite number`);
  const first = firstAtPlace(source.positions);
  const normals = vertexNormals(source, first);
  const box = boxOf(source.positions);
  const id = ++lastId;
  meshes.set(id, { ...source, first, normals, fields: new Map() });
  const at = origin ?? box.centre;
  return {
    id, format, vertices: source.positions.length / 3, triangles: source.indices.length / 3,
    positions: relativeTo(at, source.positions), normals: normals.slice(), indices: source.indices.slice(), colours: source.colours,
    origin: at, centre: box.centre.map((value, axis) => value - at[axis]) as [number, number, number], radius: box.radius,
  };
}

/** For clicks; what is returned goes away with its buffer. */
function keep(id: number, kind: FieldKind, field: Field): Field {
  mesh(id).fields.set(kind, field.values.slice());
  return field;
}

const calls = {
  load,
  sample: (kind: SampleKind) => makeSample(kind),
  /** Null when the meshes do not have the same vertices in the same order. */
  displacement: (before: number, after: number) =>
    sameTriangles(mesh(before), mesh(after)) ? keep(after, 'displacement', describe(displacement(mesh(before), mesh(after)))) : null,
  async distance(id: number, reference: number, origin: [number, number, number], kind: FieldKind = 'distance') {
    const { distances } = await import('./distance');
    return keep(id, kind, describe(distances(mesh(id), mesh(reference), origin)));
  },
  curvature(id: number) {
    const { normals, first } = mesh(id);
    return keep(id, 'curvature', describe(curvature(mesh(id), normals, first), true));
  },
  edges: (id: number) => edgesOf(mesh(id), mesh(id).first),
  pick: (id: number, from: number[], along: number[], kind?: FieldKind): Hit | null => pick(mesh(id), from, along, kind && mesh(id).fields.get(kind)),
  drop: (id: number) => void meshes.delete(id),
};

export type Calls = typeof calls;

function buffersIn(value: unknown, found = new Set<ArrayBuffer>()): Set<ArrayBuffer> {
  if (ArrayBuffer.isView(value)) found.add(value.buffer as ArrayBuffer);
  else if (value && typeof value === 'object') for (const part of Object.values(value)) buffersIn(part, found);
  return found;
}

self.onmessage = async ({ data: { call, name, values } }: MessageEvent<{ call: number; name: keyof Calls; values: unknown[] }>) => {
  try {
    const result = await (calls[name] as (...of: unknown[]) => unknown)(...values);
    // Handed over, not copied. The file's colours are kept by the view alone.
    self.postMessage({ call, result }, { transfer: [...buffersIn(result)] });
  } catch (error) {
    self.postMessage({ call, error: error instanceof Error ? error.message : String(error) });
  }
};
