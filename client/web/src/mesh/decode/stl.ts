import { isBinaryStl } from '../detect';
import type { Source } from '../types';
import { Scanner, numbers } from './text';

/** STL has no shared vertices: each triangle keeps its own three, in the order of the file. */
export function decodeStl(bytes: Uint8Array): Source {
  const positions = isBinaryStl(bytes) ? binaryPositions(bytes) : textPositions(bytes);
  const indices = new Uint32Array(positions.length / 3);
  for (let v = 0; v < indices.length; v++) indices[v] = v;
  return { positions, indices };
}

function binaryPositions(bytes: Uint8Array): Float64Array {
  const view = new DataView(bytes.buffer, bytes.byteOffset);
  const triangles = view.getUint32(80, true);
  const positions = new Float64Array(triangles * 9);
  for (let t = 0, to = 0; t < triangles; t++) {
    const from = 84 + 50 * t + 12;
    for (let k = 0; k < 9; k++) positions[to++] = view.getFloat32(from + 4 * k, true);
  }
  return positions;
}

function textPositions(bytes: Uint8Array): Float64Array {
  const scanner = new Scanner(bytes);
  const positions = numbers();
  for (; !scanner.done; scanner.nextLine()) {
    scanner.skipBlanks();
    const letter = bytes[scanner.at] | 32;
    if (letter !== 118 || scanner.word().toLowerCase() !== 'vertex') continue;
    for (let axis = 0; axis < 3; axis++) positions.push(scanner.number());
  }
  if (positions.size === 0 || positions.size % 9 !== 0) {
    throw new Error(`${positions.size / 3} vertices do not make whole triangles (line ${scanner.line})`);
  }
  return positions.take();
}
