/** What the worker and the page tell each other about meshes. */

export type Format = 'obj' | 'drc' | 'ply' | 'stl' | 'off' | 'glb';

/** A mesh as a file holds it: its vertices in their order, polygons split into triangles. */
export interface Source {
  positions: Float64Array;
  indices: Uint32Array;
  /** Red, green, blue of each vertex. */
  colours?: Uint8Array;
}

/** What the view draws; positions are relative to `origin`, which is the same for all meshes of a scene. */
export interface MeshBuffers {
  id: number;
  format: Format;
  vertices: number;
  triangles: number;
  positions: Float32Array;
  normals: Float32Array;
  indices: Uint32Array;
  colours?: Uint8Array;
  origin: [number, number, number];
  centre: [number, number, number];
  radius: number;
}

/** A number for each vertex and what there is to say about them. */
export interface Field {
  values: Float32Array;
  /** The colour map's ends; values beyond them have its last colours. */
  low: number;
  high: number;
  smallest: number;
  largest: number;
  mean: number;
  rms: number;
  /** Not from vertex to vertex but to the nearest point of the surface. */
  nearest?: boolean;
}

export interface Hit {
  triangle: number;
  vertex: number;
  /** In the file's own coordinates. */
  position: [number, number, number];
  value?: number;
}

export type FieldKind = 'displacement' | 'distance' | 'curvature';
export type SampleKind = 'machined' | 'knot';
