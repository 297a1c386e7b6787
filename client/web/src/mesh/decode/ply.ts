import type { Source } from '../types';
import { Growing, Scanner, addPolygon, indexes } from './text';

interface Property { name: string; type: string; list?: string }
interface Element { name: string; count: number; properties: Property[] }
/** Reads the next value of a type. */
type Read = (type: string) => number;

const SIZES: Record<string, [number, 'Int8' | 'Uint8' | 'Int16' | 'Uint16' | 'Int32' | 'Uint32' | 'Float32' | 'Float64']> = {
  char: [1, 'Int8'], int8: [1, 'Int8'], uchar: [1, 'Uint8'], uint8: [1, 'Uint8'], short: [2, 'Int16'], int16: [2, 'Int16'],
  ushort: [2, 'Uint16'], uint16: [2, 'Uint16'], int: [4, 'Int32'], int32: [4, 'Int32'], uint: [4, 'Uint32'], uint32: [4, 'Uint32'],
  float: [4, 'Float32'], float32: [4, 'Float32'], double: [8, 'Float64'], float64: [8, 'Float64'],
};
const COLOURS = ['red', 'green', 'blue'];

/** PLY in its three encodings, with polygons of any size and double precision, which three.js's loader leaves out. */
export function decodePly(bytes: Uint8Array): Source {
  const { encoding, elements, body } = readHeader(bytes);
  const read = encoding === 'ascii' ? textReader(bytes, body) : binaryReader(bytes, body, encoding === 'binary_little_endian');
  const mesh: Source = { positions: new Float64Array(), indices: new Uint32Array() };
  for (const element of elements) {
    if (element.name === 'vertex') readVertices(element, read, mesh);
    else readFaces(element, read, mesh);
  }
  return mesh;
}

function readHeader(bytes: Uint8Array) {
  const scanner = new Scanner(bytes);
  const elements: Element[] = [];
  let encoding = '';
  for (; ; scanner.nextLine()) {
    if (scanner.done) throw new Error('the header has no end_header');
    const word = scanner.word();
    if (word === 'format') encoding = scanner.word();
    else if (word === 'element') elements.push({ name: scanner.word(), count: Number(scanner.word()), properties: [] });
    else if (word === 'property') {
      const type = scanner.word();
      const list = type === 'list' ? scanner.word() : undefined;
      const of = list ? scanner.word() : type;
      if (!SIZES[of] || (list && !SIZES[list])) throw new Error(`the property type "${of}" is not known (line ${scanner.line})`);
      elements.at(-1)?.properties.push({ type: of, list, name: scanner.word() });
    } else if (word === 'end_header') break;
  }
  scanner.nextLine();
  return { encoding, elements, body: scanner.at };
}

function textReader(bytes: Uint8Array, body: number): Read {
  const scanner = new Scanner(bytes);
  scanner.at = body;
  return () => {
    scanner.skipToWord();
    return scanner.number();
  };
}

function binaryReader(bytes: Uint8Array, body: number, little: boolean): Read {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  let at = body;
  return (type) => {
    const [size, kind] = SIZES[type];
    if (at + size > view.byteLength) throw new Error('the file ends before its last element');
    const value = view[`get${kind}`](at, little);
    at += size;
    return value;
  };
}

function readVertices(element: Element, read: Read, mesh: Source): void {
  const { count, properties } = element;
  const axes = properties.map(({ name }) => ['x', 'y', 'z'].indexOf(name));
  const colours = properties.map(({ name }) => COLOURS.indexOf(name.replace('diffuse_', '')));
  mesh.positions = new Float64Array(count * 3);
  if (COLOURS.every((_, k) => colours.includes(k))) mesh.colours = new Uint8Array(count * 3);
  for (let v = 0; v < count; v++) {
    for (let p = 0; p < properties.length; p++) {
      const { type, list } = properties[p];
      if (list) { skipList(read, list, type); continue; }
      const value = read(type);
      if (axes[p] >= 0) mesh.positions[v * 3 + axes[p]] = value;
      else if (colours[p] >= 0 && mesh.colours) mesh.colours[v * 3 + colours[p]] = type.startsWith('f') || type.startsWith('d') ? value * 255 : value;
    }
  }
}

function skipList(read: Read, list: string, type: string): void {
  for (let left = read(list); left > 0; left--) read(type);
}

function readFaces(element: Element, read: Read, mesh: Source): void {
  const triangles: Growing<Uint32Array> = indexes();
  const corners: number[] = [];
  const vertices = mesh.positions.length / 3;
  for (let f = 0; f < element.count; f++) {
    for (const { name, type, list } of element.properties) {
      if (!list) { read(type); continue; }
      if (element.name !== 'face' || !/^vertex_ind/.test(name)) { skipList(read, list, type); continue; }
      const count = read(list);
      for (let k = 0; k < count; k++) corners[k] = read(type);
      addPolygon(triangles, corners, count, vertices, `face ${f}`);
    }
  }
  if (element.name === 'face') mesh.indices = triangles.take();
}
