import { BufferAttribute, BufferGeometry, Vector3 } from 'three';
import { MeshBVH } from 'three-mesh-bvh';
import { relativeTo } from './geometry';
import type { Source } from './types';

/** Distance of every vertex to the nearest point of the reference's surface. */
export function distances(mesh: Source, reference: Source, origin: readonly number[]): Float32Array {
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(relativeTo(origin, reference.positions), 3));
  geometry.setIndex(new BufferAttribute(reference.indices.slice(), 1));
  const tree = new MeshBVH(geometry);
  const values = new Float32Array(mesh.positions.length / 3);
  const point = new Vector3(), hit = { point: new Vector3(), distance: 0, faceIndex: 0 };
  for (let v = 0; v < values.length; v++) {
    point.set(mesh.positions[3 * v] - origin[0], mesh.positions[3 * v + 1] - origin[1], mesh.positions[3 * v + 2] - origin[2]);
    tree.closestPointToPoint(point, hit);
    values[v] = hit.distance;
  }
  return values;
}
