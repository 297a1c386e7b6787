import type { Source } from '../types';
import { Scanner, addPolygon, indexes, numbers } from './text';

/** Object File Format: counts, positions, polygons; whatever else a line holds is passed over. */
export function decodeOff(bytes: Uint8Array): Source {
  const scanner = new Scanner(bytes);
  scanner.skipToWord();
  const word = scanner.word();
  if (/BINARY/i.test(word) || /^(4|ST4)?n/.test(word)) throw new Error('only the plain text form of OFF with three coordinates can be shown');
  const next = () => { scanner.skipToWord(); return scanner.number(); };
  const vertices = next(), faces = next();
  if (!scanner.lineDone) scanner.number();
  scanner.nextLine();
  // Texture coordinates, normals and colours follow the position on its line.
  const positions = numbers(), triangles = indexes(), corners: number[] = [];
  for (let v = 0; v < vertices; v++) {
    scanner.skipToWord();
    if (scanner.done) throw new Error(`the file ends before vertex ${v} of ${vertices}`);
    for (let axis = 0; axis < 3; axis++) positions.push(scanner.number());
    scanner.nextLine();
  }
  for (let f = 0; f < faces; f++) {
    scanner.skipToWord();
    if (scanner.done) throw new Error(`the file ends before face ${f} of ${faces}`);
    const count = scanner.number();
    for (let k = 0; k < count; k++) corners[k] = scanner.number();
    addPolygon(triangles, corners, count, vertices, `line ${scanner.line}`);
    scanner.nextLine();
  }
  return { positions: positions.take(), indices: triangles.take() };
}
