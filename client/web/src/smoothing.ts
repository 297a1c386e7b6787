/** A smoothing from the file to its result: upload, job, progress, cancel. */
import { Problem } from './api/server';
import { cancel, checked, follow, resultOf, submit, upload } from './api/jobs';
import type { Job, Options } from './api/types';

/** A file that the server may already have. */
export class SentFile {
  private sha256?: string;
  constructor(readonly blob: Blob, readonly name: string) {}

  async sent(tell: (share: number) => void, signal: AbortSignal): Promise<string> {
    this.sha256 ??= await upload(this.blob, tell, signal);
    return this.sha256;
  }
  forget(): void { this.sha256 = undefined; }
}

/** What is going on, and how much of it is done, 0 to 1. */
export type Tell = (words: string, share: number) => void;

const STAGES: Record<string, [string, number, number]> = {
  SMOOTH_STAGE_QUEUE: ['Waiting for a place', 0.3, 0],
  SMOOTH_STAGE_DECODE: ['Reading the mesh', 0.3, 0.06],
  SMOOTH_STAGE_PREPARE: ['Looking at it', 0.36, 0.06],
  SMOOTH_STAGE_SMOOTH: ['Smoothing', 0.42, 0.44],
  SMOOTH_STAGE_MEASURE: ['Measuring', 0.86, 0.06],
  SMOOTH_STAGE_ENCODE: ['Writing the result', 0.92, 0.04],
};

export interface Outcome { job: Job; file: Blob; mesh: string; reference?: string }

export class Smoothing {
  private readonly stop = new AbortController();
  private job?: string;

  constructor(private readonly mesh: SentFile, private readonly reference: SentFile | undefined, private readonly options: Options, private readonly tell: Tell) {}

  /** Ends the job on the server too. */
  cancel(): void {
    this.stop.abort();
    if (this.job) void cancel(this.job).catch(() => undefined);
  }

  async run(): Promise<Outcome> {
    try {
      return await this.once();
    } catch (error) {
      // The server keeps what it was sent for a day: send it again.
      if (!(error instanceof Problem) || error.code !== 'not_found' || this.job) throw error;
      this.mesh.forget();
      this.reference?.forget();
      return this.once();
    }
  }

  private async once(): Promise<Outcome> {
    const { signal } = this.stop;
    const sending = (words: string, from: number, to: number) => (share: number) => this.tell(`${words}, ${Math.round(share * 100)} %`, from + (to - from) * share);
    const mesh = await this.mesh.sent(sending('Sending the mesh', 0, 0.22), signal);
    const reference = await this.reference?.sent(sending('Sending the reference', 0.22, 0.3), signal);
    const { id } = await submit({ mesh, reference, options: this.options }, signal);
    this.job = id;
    if (signal.aborted) this.cancel();
    const job = checked(await follow(id, (now) => this.tellJob(now), signal));
    this.tell('Fetching the result', 0.97);
    return { job, file: await resultOf(id, signal), mesh, reference };
  }

  private tellJob({ progress, state }: Job): void {
    const [words, from, size] = STAGES[state === 'JOB_STATE_QUEUED' ? 'SMOOTH_STAGE_QUEUE' : progress?.stage ?? ''] ?? ['Working', 0.3, 0];
    const share = progress?.fraction ?? 0;
    this.tell(share > 0 ? `${words}, ${Math.round(share * 100)} %` : words, from + size * share);
  }
}
