import type { Options, Report } from '../api/types';
import { byId, element } from '../dom';
import type { MeshBuffers } from '../mesh/types';
import { figure, milliseconds } from '../text';

/** One smoothing of the session. */
export interface Run {
  number: number;
  job: string;
  mesh: string;
  reference?: { sha256: string; name: string };
  options: Options;
  report: Report;
  file: Blob;
  buffers: MeshBuffers;
}

const wordsOf = ({ method, parameters }: Options) =>
  [method, ...Object.entries(parameters).map(([name, value]) => `${name} ${value}`)].join(', ');

/** Compares the runs on this mesh; a click shows one again. */
export function showRuns(runs: Run[], current: Run | undefined, unit: string, choose: (run: Run) => void): void {
  byId('runs').hidden = runs.length === 0;
  const head = ['', 'Method', 'Ev / edge', `RMS moved ${unit}`.trim(), `Most moved ${unit}`.trim(), 'Normals °', 'Volume %', 'Against', 'Time'];
  byId('runs-table').replaceChildren(
    element('thead', {}, element('tr', {}, ...head.map((name) => element('th', { scope: 'col' }, name || element('span', { className: 'sr-only' }, 'Run'))))),
    element('tbody', {}, ...runs.map((run) => row(run, run === current, choose))));
}

function row(run: Run, shown: boolean, choose: (run: Run) => void): HTMLTableRowElement {
  const { report: { errors, change, timings }, options } = run;
  const button = element('button', { type: 'button', onclick: () => choose(run), 'aria-label': `Show run ${run.number}`, 'aria-pressed': String(shown) }, String(run.number));
  const cells = [wordsOf(options), figure(errors.evOverEdge), figure(change.rmsDisplacement), figure(change.maxDisplacement),
    errors.meanNormalDegrees === undefined ? '–' : figure(errors.meanNormalDegrees), figure(change.volumePercent), errors.against, milliseconds(timings.totalMs)];
  return element('tr', { className: shown ? 'shown' : '' }, element('td', {}, button), ...cells.map((cell) => element('td', {}, cell)));
}
