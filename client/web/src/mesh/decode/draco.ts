import type { Source } from '../types';
import { dracoModule } from './draco_module';

/** Draco triangle meshes: points in the order that the decoder gives. */
export async function decodeDraco(bytes: Uint8Array): Promise<Source> {
  const draco = await dracoModule();
  const decoder = new draco.Decoder();
  const mesh = new draco.Mesh();
  try {
    if (decoder.GetEncodedGeometryType(bytes) !== draco.TRIANGULAR_MESH) throw new Error('the Draco file holds no triangle mesh');
    const status = decoder.DecodeArrayToMesh(bytes, bytes.length, mesh);
    if (!status.ok()) throw new Error(`the Draco file cannot be decoded: ${status.error_msg()}`);
    const vertices: number = mesh.num_points();
    const source: Source = { positions: readPositions(draco, decoder, mesh), indices: readIndices(draco, decoder, mesh) };
    if (source.indices.some((index) => index >= vertices)) throw new Error('a triangle of the Draco file uses a point that does not exist');
    source.colours = readColours(draco, decoder, mesh);
    return source;
  } finally {
    draco.destroy(mesh);
    draco.destroy(decoder);
  }
}

/* eslint-disable @typescript-eslint/no-explicit-any */
function readIndices(draco: any, decoder: any, mesh: any): Uint32Array {
  const bytes = mesh.num_faces() * 12;
  const at = draco._malloc(bytes);
  decoder.GetTrianglesUInt32Array(mesh, bytes, at);
  const indices = new Uint32Array(draco.HEAPF32.buffer, at, bytes / 4).slice();
  draco._free(at);
  return indices;
}

function readPositions(draco: any, decoder: any, mesh: any): Float64Array {
  const id = decoder.GetAttributeId(mesh, draco.POSITION);
  if (id < 0) throw new Error('the Draco file has no positions');
  const count = mesh.num_points() * 3;
  const at = draco._malloc(count * 4);
  decoder.GetAttributeDataArrayForAllPoints(mesh, decoder.GetAttribute(mesh, id), draco.DT_FLOAT32, count * 4, at);
  const positions = Float64Array.from(new Float32Array(draco.HEAPF32.buffer, at, count));
  draco._free(at);
  return positions;
}

function readColours(draco: any, decoder: any, mesh: any): Uint8Array | undefined {
  const id = decoder.GetAttributeId(mesh, draco.COLOR);
  if (id < 0) return undefined;
  const attribute = decoder.GetAttribute(mesh, id);
  const parts: number = attribute.num_components();
  if (parts < 3) return undefined;
  const whole = attribute.data_type() === draco.DT_UINT8;
  const count = mesh.num_points() * parts;
  const at = draco._malloc(count * 4);
  decoder.GetAttributeDataArrayForAllPoints(mesh, attribute, draco.DT_FLOAT32, count * 4, at);
  const values = new Float32Array(draco.HEAPF32.buffer, at, count);
  const colours = new Uint8Array(mesh.num_points() * 3);
  const scale = whole && !attribute.normalized() ? 1 : 255;
  for (let i = 0; i < colours.length; i++) colours[i] = Math.round(values[Math.floor(i / 3) * parts + (i % 3)] * scale);
  draco._free(at);
  return colours;
}
