import type { Format } from './types';

const ascii = (bytes: Uint8Array) => new TextDecoder('latin1').decode(bytes);

/** Tells a mesh file by its content, never by its name. What is nothing else is taken for OBJ, as the server does. */
export function detectFormat(bytes: Uint8Array): Format {
  const start = ascii(bytes.subarray(0, 1024));
  if (start.startsWith('glTF')) return 'glb';
  if (start.startsWith('DRACO')) return 'drc';
  if (/^ply\s/.test(start)) return 'ply';
  if (isBinaryStl(bytes)) return 'stl';
  if (/^\s*solid\b/.test(start)) return 'stl';
  if (/^(\s*#[^\n]*\n)*\s*(ST)?C?N?4?n?OFF\b/.test(start)) return 'off';
  return 'obj';
}

export function isBinaryStl(bytes: Uint8Array): boolean {
  if (bytes.length < 84) return false;
  const triangles = new DataView(bytes.buffer, bytes.byteOffset).getUint32(80, true);
  return bytes.length === 84 + 50 * triangles;
}
