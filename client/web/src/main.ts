import { checked, follow, resultOf, submit } from './api/jobs';
import { askJson, token } from './api/server';
import type { Method } from './api/types';
import { byId, copyFrom, element, save } from './dom';
import type { MeshBuffers, SampleKind } from './mesh/types';
import { inWorker } from './mesh/meshes';
import { say, sayWhy, saidNothing } from './panel/alert';
import { type Language, callIn } from './panel/calls';
import { MethodForm } from './panel/method_form';
import { headline, reportTable, reportText } from './panel/report_table';
import { type Run, showRuns } from './panel/runs';
import { setUpTheme } from './panel/theme';
import { setUpToken } from './panel/token';
import { SceneView } from './scene';
import { SentFile, Smoothing } from './smoothing';
import { bytes, count, figure, formatName } from './text';

const KEPT_RUNS = 8;

let mesh: { sent: SentFile; buffers: MeshBuffers } | undefined;
let reference: { sent: SentFile; buffers: MeshBuffers } | undefined;
let runs: Run[] = [];
let current: Run | undefined;
let lastRun = 0;
let running: Smoothing | undefined;
let formats: string[] = ['obj', 'drc'];

const scene = new SceneView((error) => sayWhy(error, ''), () => current && showResult(current));
const form = new MethodForm(() => refreshButton());

function refreshButton(): void {
  byId<HTMLButtonElement>('smooth').disabled = !mesh || !form.ready || running !== undefined;
}

async function fetchMethods(): Promise<void> {
  try {
    form.fill((await askJson<{ methods: Method[] }>('/v1/methods')).methods);
    const described = await askJson<{ paths: Record<string, { post: { parameters: { name?: string; schema?: { enum?: string[] } }[] } }>; info: { version: string } }>('/openapi.json');
    formats = described.paths['/v1/smooth'].post.parameters.find(({ name }) => name === 'output')?.schema?.enum ?? formats;
    byId('footer').textContent = `burnish ${described.info.version}. Meshes stay on this server and are forgotten after a while.`;
  } catch (error) {
    sayWhy(error, '');
  }
}

function loading(words: string): void {
  byId('loading').hidden = !words;
  byId('loading').textContent = words;
}

async function read(file: File, origin?: [number, number, number]): Promise<MeshBuffers | undefined> {
  saidNothing();
  loading(`Reading ${file.name}`);
  try {
    return await inWorker('load', file, origin);
  } catch (error) {
    sayWhy(error, file.name);
    return undefined;
  } finally {
    loading('');
  }
}

async function takeMesh(file: File): Promise<void> {
  running?.cancel();
  const buffers = await read(file);
  if (!buffers) return;
  clearReference();
  if (mesh) void inWorker('drop', mesh.buffers.id);
  for (const run of runs) void inWorker('drop', run.buffers.id);
  mesh = { sent: new SentFile(file, file.name), buffers };
  runs = [];
  current = undefined;
  for (const id of ['result', 'runs', 'calls']) byId(id).hidden = true;
  byId('mesh-name').textContent = file.name;
  byId('mesh-facts').textContent = `${formatName(buffers.format)}, ${count(buffers.triangles)} triangles, ${count(buffers.vertices)} vertices, ${bytes(file.size)}`;
  await scene.setBefore(buffers, buffers.format);
  refreshButton();
}

async function takeReference(file: File): Promise<void> {
  if (!mesh) return say('Choose a mesh first, then its reference.');
  const buffers = await read(file, scene.origin);
  if (!buffers) return;
  clearReference();
  reference = { sent: new SentFile(file, file.name), buffers };
  byId('reference-name').textContent = file.name;
  byId('clear-reference').hidden = false;
  scene.setReference(buffers.id);
}

function clearReference(): void {
  if (reference) void inWorker('drop', reference.buffers.id);
  reference = undefined;
  byId('reference-name').textContent = 'none: the errors are against the input';
  byId('clear-reference').hidden = true;
  scene.setReference(undefined);
}

async function takeSample(kind: SampleKind): Promise<void> {
  loading('Making the sample');
  const { noisy, clean } = await inWorker('sample', kind);
  await takeMesh(new File([noisy], `${kind}.obj`));
  await takeReference(new File([clean], `${kind}-clean.obj`));
}

async function smooth(): Promise<void> {
  if (!mesh || running) return;
  saidNothing();
  const { sent, buffers } = mesh, against = reference, options = form.options();
  const meter = byId<HTMLProgressElement>('meter');
  const tell = (words: string, share: number) => {
    byId('progress-words').textContent = words;
    meter.value = share;
  };
  running = new Smoothing(sent, against?.sent, options, tell);
  const mine = running;
  byId('progress').hidden = false;
  tell('Starting', 0);
  refreshButton();
  byId('cancel').focus({ preventScroll: true });
  try {
    const outcome = await mine.run(), { job, file } = outcome;
    tell('Drawing', 0.99);
    const result = await inWorker('load', file, buffers.origin);
    if (mesh?.buffers === buffers) {
      const referred = outcome.reference && against ? { sha256: outcome.reference, name: against.sent.name } : undefined;
      addRun({ number: ++lastRun, job: job.id, mesh: outcome.mesh, reference: referred, options, report: job.report!, file, buffers: result });
    }
  } catch (error) {
    sayWhy(error, '');
  } finally {
    running = undefined;
    byId('progress').hidden = true;
    refreshButton();
    if (document.activeElement === document.body) byId('smooth').focus({ preventScroll: true });
  }
}

function addRun(run: Run): void {
  runs.push(run);
  const old = runs.length > KEPT_RUNS ? runs.shift() : undefined;
  if (old) {
    void inWorker('drop', old.buffers.id);
    scene.forget(old.buffers.id);
  }
  chooseRun(run);
  const panel = byId('panel'); // which scrolls by itself where there is room for it beside the view
  panel.scrollTo({ top: byId('result').offsetTop - panel.offsetTop, behavior: matchMedia('(prefers-reduced-motion: reduce)').matches ? 'auto' : 'smooth' });
}

function chooseRun(run: Run): void {
  current = run;
  scene.setAfter(run.buffers);
  showResult(run);
}

function showResult(run: Run): void {
  const { report } = run, unit = scene.unitName;
  for (const id of ['result', 'calls']) byId(id).hidden = false;
  byId('result-words').textContent = report.choice?.reason
    ? `${report.method} chose ${report.choice.method}: ${report.choice.reason}.`
    : `${report.method} moved the vertices by ${figure(report.change.rmsDisplacement)} ${unit} in the root mean square.`;
  byId('figures').replaceChildren(...headline(report, unit).map(([name, value, of]) =>
    element('div', {}, element('dt', {}, name), element('dd', {}, `${value} `, element('small', {}, of)))));
  byId('warnings').replaceChildren(...report.warnings.map(({ message }) => element('li', {}, message)));
  byId('report').replaceChildren(reportTable(report, unit));
  const own = mesh!.buffers.format;
  byId('format').replaceChildren(...[own, ...formats.filter((format) => format !== own)].map((format) =>
    element('option', { value: format }, format === own ? `${formatName(format)}, as it came` : formatName(format))));
  showRuns(runs, current, unit, chooseRun);
  showCall();
}

const chosenFormat = () => byId<HTMLSelectElement>('format').value;
const resultName = (format: string) => `${mesh!.sent.name.replace(/\.[^.]*$/, '')}-smooth.${format}`;

async function download(): Promise<void> {
  if (!current || !mesh) return;
  const format = chosenFormat(), { options } = current;
  try {
    if (format === mesh.buffers.format) return save(current.file, resultName(format));
    const { id } = await submit({ mesh: current.mesh, reference: current.reference?.sha256, options, output: format });
    checked(await follow(id, () => undefined));
    save(await resultOf(id), resultName(format));
  } catch (error) {
    sayWhy(error, '');
  }
}

function showCall(): void {
  if (!current || !mesh) return;
  const language = document.querySelector<HTMLInputElement>('input[name="language"]:checked')!.value as Language;
  const format = chosenFormat();
  byId('call').textContent = callIn(language, {
    server: location.origin, grpc: `${location.hostname}:50051`, mesh: mesh.sent.name, reference: current.reference?.name,
    result: resultName(format), options: current.options, output: format === mesh.buffers.format ? undefined : format, token: token.get() !== '',
  });
}

function setUpFiles(): void {
  const file = byId<HTMLInputElement>('file'), referenceFile = byId<HTMLInputElement>('reference-file');
  for (const id of ['choose', 'choose-big']) byId<HTMLButtonElement>(id).onclick = () => file.click();
  byId<HTMLButtonElement>('choose-reference').onclick = () => referenceFile.click();
  byId<HTMLButtonElement>('clear-reference').onclick = clearReference;
  const taken = (input: HTMLInputElement, take: (file: File) => Promise<void>) => () => {
    const chosen = input.files?.[0];
    input.value = '';
    if (chosen) void take(chosen);
  };
  file.onchange = taken(file, takeMesh);
  referenceFile.onchange = taken(referenceFile, takeReference);
  const sample = byId<HTMLSelectElement>('sample');
  sample.onchange = () => {
    if (sample.value) void takeSample(sample.value as SampleKind);
    sample.value = '';
  };
  for (const button of document.querySelectorAll<HTMLButtonElement>('[data-sample]')) button.onclick = () => void takeSample(button.dataset.sample as SampleKind);
  setUpDrop();
}

function setUpDrop(): void {
  const stage = byId('stage');
  addEventListener('dragover', (event) => {
    event.preventDefault();
    stage.classList.add('over');
  });
  addEventListener('dragleave', (event) => { if (!event.relatedTarget) stage.classList.remove('over'); });
  addEventListener('drop', (event) => {
    event.preventDefault();
    stage.classList.remove('over');
    const dropped = event.dataTransfer?.files[0];
    const onReference = (event.target as HTMLElement).closest?.('.reference');
    if (dropped) void (onReference ? takeReference(dropped) : takeMesh(dropped));
  });
}

setUpTheme(() => scene.themeChanged());
setUpToken(() => void fetchMethods());
setUpFiles();
byId<HTMLFormElement>('options').onsubmit = (event) => {
  event.preventDefault();
  void smooth();
};
addEventListener('pagehide', () => running?.cancel()); // nobody would fetch the result
byId<HTMLButtonElement>('cancel').onclick = () => running?.cancel();
byId<HTMLButtonElement>('download').onclick = () => void download();
byId<HTMLSelectElement>('format').onchange = showCall;
for (const input of document.querySelectorAll<HTMLInputElement>('input[name="language"]')) input.onchange = showCall;
byId<HTMLButtonElement>('copy-call').onclick = (event) => void copyFrom(event.currentTarget as HTMLButtonElement, byId('call').textContent ?? '');
byId<HTMLButtonElement>('copy-report').onclick = (event) => current && void copyFrom(event.currentTarget as HTMLButtonElement, reportText(current.report, scene.unitName));
void fetchMethods();
// three.js comes once the page stands, before anybody needs it.
new PerformanceObserver((list, observer) => {
  if (!list.getEntriesByName('first-contentful-paint').length) return;
  observer.disconnect();
  void scene.start().catch((error) => sayWhy(error, 'The view cannot start'));
}).observe({ type: 'paint', buffered: true });
