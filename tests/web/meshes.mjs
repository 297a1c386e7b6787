// A noisy ball, written in every format by the plainest means.

export function ball(cells = 24, noise = 0.01) {
  const positions = [], triangles = [];
  let seed = 7;
  const random = () => { seed = (Math.imul(seed, 1664525) + 1013904223) >>> 0; return seed / 2 ** 32 - 0.5; };
  const point = (theta, phi) => {
    const radius = 10 * (1 + noise * 2 * random());
    positions.push([radius * Math.sin(theta) * Math.cos(phi), radius * Math.cos(theta), -radius * Math.sin(theta) * Math.sin(phi)].map(Math.fround));
    return positions.length - 1;
  };
  const top = point(0, 0), bottom = point(Math.PI, 0);
  const rings = Array.from({ length: cells - 1 }, (_, i) =>
    Array.from({ length: 2 * cells }, (_, j) => point(((i + 1) * Math.PI) / cells, (j * Math.PI) / cells)));
  for (let j = 0; j < 2 * cells; j++) {
    const k = (j + 1) % (2 * cells);
    triangles.push([top, rings[0][j], rings[0][k]], [bottom, rings.at(-1)[k], rings.at(-1)[j]]);
    for (let i = 0; i + 1 < rings.length; i++) triangles.push([rings[i][j], rings[i + 1][j], rings[i + 1][k]], [rings[i][j], rings[i + 1][k], rings[i][k]]);
  }
  return { positions, triangles };
}

export const obj = ({ positions, triangles }) =>
  positions.map((p) => `v ${p.join(' ')}`).concat(triangles.map((t) => `f ${t.map((v) => v + 1).join(' ')}`)).join('\n') + '\n';

export const off = ({ positions, triangles }) =>
  ['OFF', `${positions.length} ${triangles.length} 0`, ...positions.map((p) => p.join(' ')), ...triangles.map((t) => `3 ${t.join(' ')}`)].join('\n') + '\n';

const plyHeader = (format, { positions, triangles }) =>
  `ply\nformat ${format} 1.0\nelement vertex ${positions.length}\nproperty float x\nproperty float y\nproperty float z\n` +
  `element face ${triangles.length}\nproperty list uchar int vertex_indices\nend_header\n`;

export const plyText = (mesh) =>
  plyHeader('ascii', mesh) + mesh.positions.map((p) => p.join(' ')).concat(mesh.triangles.map((t) => `3 ${t.join(' ')}`)).join('\n') + '\n';

export function plyBinary(mesh, little = true) {
  const { positions, triangles } = mesh;
  const body = Buffer.alloc(12 * positions.length + 13 * triangles.length);
  const float = little ? 'writeFloatLE' : 'writeFloatBE', int = little ? 'writeInt32LE' : 'writeInt32BE';
  let at = 0;
  for (const value of positions.flat()) at = body[float](value, at);
  for (const triangle of triangles) {
    at = body.writeUInt8(3, at);
    for (const corner of triangle) at = body[int](corner, at);
  }
  return Buffer.concat([Buffer.from(plyHeader(little ? 'binary_little_endian' : 'binary_big_endian', mesh)), body]);
}

export function stl({ positions, triangles }) {
  const bytes = Buffer.alloc(84 + 50 * triangles.length);
  bytes.writeUInt32LE(triangles.length, 80);
  triangles.forEach((triangle, t) => triangle.forEach((corner, k) =>
    positions[corner].forEach((value, axis) => bytes.writeFloatLE(value, 84 + 50 * t + 12 + 12 * k + 4 * axis))));
  return bytes;
}

export const stlText = ({ positions, triangles }) => ['solid ball', ...triangles.flatMap((triangle) =>
  ['facet normal 0 0 0', 'outer loop', ...triangle.map((v) => `vertex ${positions[v].join(' ')}`), 'endloop', 'endfacet']), 'endsolid ball'].join('\n') + '\n';

/** A glTF binary with one primitive over these buffer views: positions and indices, or all of it as Draco. */
function glbOf({ positions, triangles }, views, primitive, more = {}) {
  const low = [0, 1, 2].map((axis) => Math.min(...positions.map((p) => p[axis]))), high = [0, 1, 2].map((axis) => Math.max(...positions.map((p) => p[axis])));
  const inViews = views.length > 1;
  const pad = (bytes, fill) => Buffer.concat([bytes, Buffer.alloc((4 - (bytes.length % 4)) % 4, fill)]);
  const body = pad(Buffer.concat(views), 0);
  let offset = 0;
  const json = pad(Buffer.from(JSON.stringify({
    asset: { version: '2.0' }, scene: 0, scenes: [{ nodes: [0] }], nodes: [{ mesh: 0 }], ...more,
    meshes: [{ primitives: [{ attributes: { POSITION: 0 }, indices: 1, ...primitive }] }],
    accessors: [
      { ...(inViews ? { bufferView: 0 } : {}), componentType: 5126, count: positions.length, type: 'VEC3', min: low, max: high },
      { ...(inViews ? { bufferView: 1 } : {}), componentType: 5125, count: triangles.length * 3, type: 'SCALAR' }],
    bufferViews: views.map((view) => ({ buffer: 0, byteOffset: (offset += view.length) - view.length, byteLength: view.length })),
    buffers: [{ byteLength: body.length }],
  })), ' ');
  const chunk = (type, content) => {
    const head = Buffer.alloc(8);
    head.writeUInt32LE(content.length, 0);
    head.write(type, 4, 'latin1');
    return Buffer.concat([head, content]);
  };
  const chunks = Buffer.concat([chunk('JSON', json), chunk('BIN\0', body)]);
  const head = Buffer.alloc(12);
  head.write('glTF', 0, 'latin1');
  head.writeUInt32LE(2, 4);
  head.writeUInt32LE(12 + chunks.length, 8);
  return Buffer.concat([head, chunks]);
}

export const glb = (mesh) =>
  glbOf(mesh, [Buffer.from(Float32Array.from(mesh.positions.flat()).buffer), Buffer.from(Uint32Array.from(mesh.triangles.flat()).buffer)], {});

/** The same with its geometry as Draco, whose positions are the attribute with the unique id 0. */
export const glbDraco = (mesh, draco) => glbOf(mesh, [draco],
  { extensions: { KHR_draco_mesh_compression: { bufferView: 0, attributes: { POSITION: 0 } } } },
  { extensionsUsed: ['KHR_draco_mesh_compression'], extensionsRequired: ['KHR_draco_mesh_compression'] });
