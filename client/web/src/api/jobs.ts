import { Problem, ask, askJson, authorization, problemOf } from './server';
import type { Job, Options } from './types';
import { eventsOf } from './events';

/** Sends a file to be kept; gives the SHA-256 that names it to jobs. By XMLHttpRequest, which alone tells how much has gone. */
export function upload(file: Blob, tell: (share: number) => void, signal: AbortSignal): Promise<string> {
  return new Promise((resolve, reject) => {
    const request = new XMLHttpRequest();
    request.open('POST', '/v1/uploads');
    for (const [name, value] of Object.entries(authorization())) request.setRequestHeader(name, value);
    request.setRequestHeader('Content-Type', 'application/octet-stream');
    request.upload.onprogress = (event) => tell(event.total ? event.loaded / event.total : 0);
    request.onload = () => (request.status < 300
      ? resolve((JSON.parse(request.responseText) as { sha256: string }).sha256)
      : reject(problemOf(request.status, request.responseText)));
    request.onerror = () => reject(new Problem(0, 'unreachable', 'The server does not answer. Is it still running?'));
    request.onabort = () => reject(new DOMException('cancelled', 'AbortError'));
    signal.addEventListener('abort', () => request.abort(), { once: true });
    request.send(file);
  });
}

export interface Submission { mesh: string; reference?: string; options: Options; output?: string }

export function queryOf(options: Options, output?: string): URLSearchParams {
  const query = new URLSearchParams({ method: options.method });
  for (const [name, value] of Object.entries(options.parameters)) query.set(name, String(value));
  if (output) query.set('output', output);
  return query;
}

export function submit({ mesh, reference, options, output }: Submission, signal?: AbortSignal): Promise<Job> {
  const query = queryOf(options, output);
  query.set('mesh_sha256', mesh);
  if (reference) query.set('reference_sha256', reference);
  return askJson<Job>(`/v1/jobs?${query}`, { method: 'POST', signal });
}

const ended = (job: Job) => job.state !== 'JOB_STATE_QUEUED' && job.state !== 'JOB_STATE_RUNNING';

/** Follows a job to its end: by its events, or, when too many callers listen, by asking. */
export async function follow(id: string, tell: (job: Job) => void, signal?: AbortSignal): Promise<Job> {
  try {
    for await (const data of eventsOf(await ask(`/v1/jobs/${id}/events`, { signal }))) {
      const job = JSON.parse(data) as Job;
      tell(job);
      if (ended(job)) return job;
    }
  } catch (error) {
    if (signal?.aborted || (error instanceof Problem && error.status !== 429 && error.status !== 0)) throw error;
  }
  for (;;) {
    const job = await askJson<Job>(`/v1/jobs/${id}`, { headers: { Prefer: 'wait=5' }, signal });
    tell(job);
    if (ended(job)) return job;
  }
}

/** A job that succeeded; else throws why it did not. */
export function checked(job: Job): Job {
  if (job.state === 'JOB_STATE_SUCCEEDED') return job;
  throw new Problem(422, (job.error?.code ?? job.state).toLowerCase(), job.error?.message ?? 'The job ended without a result.', job.error?.field);
}

export const cancel = (id: string) => ask(`/v1/jobs/${id}`, { method: 'DELETE', keepalive: true });

export const resultOf = async (id: string, signal?: AbortSignal) => (await ask(`/v1/jobs/${id}/mesh`, { signal })).blob();
