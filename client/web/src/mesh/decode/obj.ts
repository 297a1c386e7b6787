import type { Source } from '../types';
import { Growing, Scanner, addPolygon, indexes, numbers } from './text';

const V = 118, F = 102, SLASH = 47;

/** Wavefront OBJ: positions, colours behind them, faces. Every vertex stays in its place, so results can be compared. */
export function decodeObj(bytes: Uint8Array): Source {
  const scanner = new Scanner(bytes);
  const positions = numbers(), triangles = indexes();
  const colours = new Growing(new Uint8Array(1 << 12));
  while (!scanner.done) {
    scanner.skipBlanks();
    const letter = bytes[scanner.at], next = bytes[scanner.at + 1];
    if (next === 32 || next === 9) {
      scanner.at++;
      if (letter === V) readVertex(scanner, positions, colours);
      else if (letter === F) readFace(scanner, triangles, positions.size / 3);
    }
    scanner.nextLine();
  }
  const coloured = colours.size > 0 && colours.size === positions.size;
  return { positions: positions.take(), indices: triangles.take(), colours: coloured ? colours.take() : undefined };
}

function readVertex(scanner: Scanner, positions: Growing<Float64Array>, colours: Growing<Uint8Array>): void {
  for (let axis = 0; axis < 3; axis++) positions.push(scanner.number());
  if (scanner.lineDone) return;
  const rest = [];
  while (!scanner.lineDone) rest.push(scanner.number());
  if (rest.length >= 3) for (const part of rest.slice(-3)) colours.push(Math.max(0, Math.min(255, Math.round(part * 255))));
}

const corners: number[] = [];

function readFace(scanner: Scanner, triangles: Growing<Uint32Array>, vertices: number): void {
  const { bytes } = scanner;
  let count = 0;
  while (!scanner.lineDone) {
    const index = scanner.number();
    while (scanner.at < bytes.length && (bytes[scanner.at] > 32 || bytes[scanner.at] === SLASH)) scanner.at++;
    corners[count++] = index < 0 ? vertices + index : index - 1;
  }
  addPolygon(triangles, corners, count, vertices, `line ${scanner.line}`);
}
