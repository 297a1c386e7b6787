/** Calls to the server that the page came from. */

export interface ProblemBody { title?: string; detail?: string; code?: string; field?: string; status?: number; requestId?: string }

/** What the server refuses, in its own sentence. */
export class Problem extends Error {
  constructor(readonly status: number, readonly code: string, detail: string, readonly field = '') {
    super(detail);
  }
}

const KEY = 'burnish-token';
export const token = {
  get: () => sessionStorage.getItem(KEY) ?? '',
  set: (value: string) => (value ? sessionStorage.setItem(KEY, value) : sessionStorage.removeItem(KEY)),
};

export const authorization = (): Record<string, string> => (token.get() ? { Authorization: `Bearer ${token.get()}` } : {});

export function problemOf(status: number, text: string): Problem {
  let body: ProblemBody = {};
  try { body = JSON.parse(text) as ProblemBody; } catch { /* not ours: a proxy between */ }
  return new Problem(status, body.code ?? '', body.detail ?? `The server answered ${status}.`, body.field);
}

/** A call whose answer is fine; else throws a Problem. */
export async function ask(path: string, options: RequestInit = {}): Promise<Response> {
  let answer: Response;
  try {
    answer = await fetch(path, { ...options, headers: { ...authorization(), ...options.headers } });
  } catch (error) {
    if (options.signal?.aborted) throw error;
    throw new Problem(0, 'unreachable', 'The server does not answer. Is it still running?');
  }
  if (answer.ok) return answer;
  throw problemOf(answer.status, await answer.text());
}

export const askJson = async <T>(path: string, options: RequestInit = {}): Promise<T> => (await ask(path, options)).json() as Promise<T>;
