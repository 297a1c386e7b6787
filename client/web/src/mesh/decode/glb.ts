import { type Document, type Node, type Primitive, WebIO } from '@gltf-transform/core';
import { KHRDracoMeshCompression, KHRMeshQuantization } from '@gltf-transform/extensions';
import type { Source } from '../types';
import { dracoModule } from './draco_module';
import { Growing, indexes, numbers } from './text';

/** glTF binary: the triangles of the default scene, where its nodes put them. */
export async function decodeGlb(bytes: Uint8Array): Promise<Source> {
  const io = new WebIO().registerExtensions([KHRDracoMeshCompression, KHRMeshQuantization]);
  if (new TextDecoder('latin1').decode(bytes.subarray(0, 1 << 20)).includes('KHR_draco_mesh_compression')) {
    io.registerDependencies({ 'draco3d.decoder': await dracoModule() });
  }
  const document = await io.readBinary(bytes);
  const positions = numbers(), triangles = indexes();
  for (const node of nodesOf(document)) {
    for (const primitive of node.getMesh()?.listPrimitives() ?? []) addPrimitive(primitive, node.getWorldMatrix(), positions, triangles);
  }
  return { positions: positions.take(), indices: triangles.take() };
}

function nodesOf(document: Document): Node[] {
  const scene = document.getRoot().getDefaultScene() ?? document.getRoot().listScenes()[0];
  const nodes: Node[] = [];
  scene?.traverse((node) => nodes.push(node));
  return scene ? nodes : document.getRoot().listNodes();
}

const TRIANGLES = 4, STRIP = 5, FAN = 6;

function addPrimitive(primitive: Primitive, matrix: ArrayLike<number>, positions: Growing<Float64Array>, triangles: Growing<Uint32Array>): void {
  const accessor = primitive.getAttribute('POSITION');
  const mode = primitive.getMode();
  if (!accessor || mode < TRIANGLES) return;
  const first = positions.size / 3, point = [0, 0, 0];
  const vertices = accessor.getCount();
  for (let v = 0; v < vertices; v++) {
    const [x, y, z] = accessor.getElement(v, point);
    for (let axis = 0; axis < 3; axis++) {
      positions.push(matrix[axis] * x + matrix[4 + axis] * y + matrix[8 + axis] * z + matrix[12 + axis]);
    }
  }
  const given = primitive.getIndices()?.getArray();
  const count = given?.length ?? vertices;
  const corner = (k: number) => {
    const index = given ? given[k] : k;
    if (index >= vertices) throw new Error(`a triangle uses vertex ${index} of ${vertices}`);
    return first + index;
  };
  const add = (a: number, b: number, c: number) => [a, b, c].forEach((k) => triangles.push(corner(k)));
  if (mode === TRIANGLES) for (let k = 0; k + 2 < count; k += 3) add(k, k + 1, k + 2);
  if (mode === STRIP) for (let k = 0; k + 2 < count; k++) add(k, k + 1 + (k % 2), k + 2 - (k % 2));
  if (mode === FAN) for (let k = 1; k + 1 < count; k++) add(0, k, k + 1);
}
