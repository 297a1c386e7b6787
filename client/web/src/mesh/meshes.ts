import type { Calls } from './worker';

type Waiting = { resolve: (value: never) => void; reject: (error: Error) => void };

const worker = new Worker(new URL('./worker.ts', import.meta.url), { type: 'module', name: 'meshes' });
const waiting = new Map<number, Waiting>();
let last = 0;

worker.onmessage = ({ data: { call, result, error } }) => {
  const { resolve, reject } = waiting.get(call)!;
  waiting.delete(call);
  if (error === undefined) resolve(result as never);
  else reject(new Error(error));
};
worker.onerror = (event) => {
  for (const { reject } of waiting.values()) reject(new Error(event.message || 'the mesh worker ended'));
  waiting.clear();
};

/** Calls the worker by the name of what it does there. */
export function inWorker<Name extends keyof Calls>(name: Name, ...values: Parameters<Calls[Name]>): Promise<Awaited<ReturnType<Calls[Name]>>> {
  const call = ++last;
  return new Promise((resolve, reject) => {
    waiting.set(call, { resolve: resolve as Waiting['resolve'], reject });
    worker.postMessage({ call, name, values });
  });
}
