/** The parts of proto/burnish/v1 that the page uses, as JSON. */

export type Value = number | string;

export interface Parameter {
  name: string;
  kind: 'PARAMETER_KIND_NUMBER' | 'PARAMETER_KIND_INTEGER' | 'PARAMETER_KIND_CHOICE';
  defaultValue: Value;
  minimum: number;
  maximum: number;
  choices: string[];
  unit: string;
  description: string;
}

export interface Method { name: string; summary: string; reference: string; parameters: Parameter[] }

export interface Summary { vertices: number; triangles: number; boundaryEdges: number; components: number }

export interface Errors {
  against: 'input' | 'reference';
  ev: number; evOverEdge: number; evOverDiagonal: number;
  meanDistance: number; rmsDistance: number; maxDistance: number;
  meanNormalDegrees?: number; maxNormalDegrees?: number; flippedTriangles?: number;
}

export interface Report {
  version: string;
  requestId: string;
  method: string;
  parameters: Record<string, Value>;
  errors: Errors;
  change: {
    rmsDisplacement: number; maxDisplacement: number; areaPercent: number; volumePercent: number;
    smallestAngleDegreesBefore: number; smallestAngleDegreesAfter: number;
  };
  input: Summary;
  output: Summary;
  encoding: { format: string; quantisationError: number; bytes: number };
  timings: Record<string, number>;
  warnings: { code: string; message: string; count: number }[];
  pinnedVertices: number;
  noise?: { sigmaOverEdge: number; kind: string };
  choice?: { method: string; parameters: Record<string, Value>; reason: string; sharpBending: number };
}

export interface Job {
  id: string;
  state: 'JOB_STATE_QUEUED' | 'JOB_STATE_RUNNING' | 'JOB_STATE_SUCCEEDED' | 'JOB_STATE_FAILED' | 'JOB_STATE_CANCELLED' | 'JOB_STATE_EXPIRED';
  mesh: { sha256: string };
  result?: { sha256: string; bytes: number; format: string };
  progress?: { stage: string; fraction: number };
  report?: Report;
  error?: { code: string; message: string; field: string };
  fromCache: boolean;
}

/** What was asked for: a method, and its parameters that are not the defaults. */
export interface Options { method: string; parameters: Record<string, Value> }
