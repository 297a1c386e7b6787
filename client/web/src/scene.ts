/** What the view shows of the mesh, its result and the reference. The viewer, with three.js, comes after the first paint. */
import { byId, element } from './dom';
import { inWorker } from './mesh/meshes';
import type { Field, FieldKind, MeshBuffers } from './mesh/types';
import { count, figure } from './text';
import type { MapName } from './view/colours';
import { setUpDivider } from './view/divider';
import { showLegend } from './view/legend';
import type { Layout, Slot, Viewer } from './view/viewer';

type Look = 'shaded' | 'normals' | 'colours' | FieldKind;
const TITLES: Record<FieldKind, string> = { displacement: 'Displacement', distance: 'Distance', curvature: 'Curvature' };

export class SceneView {
  private viewer?: Viewer;
  private before?: MeshBuffers;
  private after?: MeshBuffers;
  private reference?: number;
  private layout: Layout = 'before';
  private look: Look = 'shaded';
  private readonly fields = new Map<string, Field>();
  private shown?: { kind: FieldKind; field: Field | null };
  private turn = 0;
  private probes = 0;
  private readonly unit = byId<HTMLSelectElement>('unit');
  private readonly looks = byId<HTMLSelectElement>('look');

  constructor(private readonly failed: (error: unknown) => void, private readonly unitChanged: () => void) {
    setUpDivider((share) => this.viewer?.setSplit(share));
    for (const input of this.layouts()) input.onchange = () => this.setLayout(input.value as Layout);
    this.looks.onchange = () => this.setLook(this.looks.value as Look);
    byId<HTMLInputElement>('flat').onchange = (event) => this.viewer?.setFlat((event.target as HTMLInputElement).checked);
    byId<HTMLInputElement>('wireframe').onchange = () => void this.refreshWireframe();
    byId<HTMLButtonElement>('fit').onclick = () => this.viewer?.fit();
    byId<HTMLButtonElement>('up').onclick = () => this.turnUp();
    this.unit.onchange = () => { this.refreshLegend(); this.unitChanged(); };
  }

  get origin(): [number, number, number] | undefined { return this.before?.origin; }
  get unitName(): string { return this.unit.value; }

  async start(): Promise<Viewer> {
    if (this.viewer) return this.viewer;
    const { Viewer } = await import('./view/viewer');
    this.viewer ??= this.prepare(new Viewer(byId('view')));
    return this.viewer;
  }

  private prepare(viewer: Viewer): Viewer {
    let down = [0, 0];
    viewer.canvas.addEventListener('pointerdown', (event) => { down = [event.clientX, event.clientY]; });
    viewer.canvas.addEventListener('click', (event) => {
      if (Math.hypot(event.clientX - down[0], event.clientY - down[1]) < 4) void this.probe(event.offsetX, event.offsetY);
    });
    return viewer;
  }

  themeChanged(): void { this.viewer?.setTheme(); }

  async setBefore(buffers: MeshBuffers, format: string): Promise<void> {
    const viewer = await this.start();
    this.before = buffers;
    this.after = undefined;
    this.fields.clear();
    byId('drop').hidden = true;
    byId('tools').hidden = false;
    viewer.setMesh('before', buffers);
    viewer.setMesh('after', undefined);
    this.unit.value = format === 'glb' ? 'm' : ''; // glTF alone has a unit
    this.setLayout('before');
    viewer.fit();
    this.resetLook();
    void this.refreshWireframe();
  }

  /** A result beside the mesh; nothing: the mesh alone. */
  setAfter(buffers?: MeshBuffers): void {
    const first = !this.after;
    this.after = buffers;
    this.viewer?.setMesh('after', buffers);
    if (!buffers) this.setLayout('before');
    else if (first) this.setLayout('divider');
    this.resetLook();
    void this.refreshWireframe();
  }

  setReference(id?: number): void {
    this.reference = id;
    for (const key of this.fields.keys()) if (key.startsWith('distance')) this.fields.delete(key);
    this.resetLook();
  }

  forget(id: number): void {
    for (const key of this.fields.keys()) if (key.endsWith(` ${id}`)) this.fields.delete(key);
  }

  private layouts = () => [...document.querySelectorAll<HTMLInputElement>('input[name="layout"]')];

  private setLayout(layout: Layout): void {
    this.layout = layout;
    for (const input of this.layouts()) {
      input.checked = input.value === layout;
      input.disabled = !this.after && input.value !== 'before';
    }
    byId('divider').hidden = layout !== 'divider';
    byId('tag-before').hidden = byId('tag-after').hidden = layout !== 'divider' && layout !== 'side';
    this.hideProbe();
    this.viewer?.setLayout(layout);
    this.describe();
    void this.refreshField();
  }

  /** Keeps what was chosen as far as it can still be shown. */
  private resetLook(): void {
    const can: Partial<Record<Look, boolean>> = { displacement: !!this.after, distance: this.reference !== undefined, colours: !!this.before?.colours };
    for (const option of this.looks.options) option.disabled = can[option.value as Look] === false;
    this.setLook(can[this.look] === false ? 'shaded' : this.look);
  }

  private setLook(look: Look): void {
    this.look = look;
    this.looks.value = look;
    this.hideProbe();
    void this.refreshField();
  }

  private slots(): [Slot, MeshBuffers][] {
    return ([['before', this.before], ['after', this.after]] as [Slot, MeshBuffers | undefined][]).filter((pair): pair is [Slot, MeshBuffers] => !!pair[1]);
  }

  /** Displacement is the result's; the other fields are each mesh's own, and the legend's ends are those of the mesh before. */
  private async refreshField(): Promise<void> {
    const viewer = this.viewer, turn = ++this.turn;
    if (!viewer) return;
    const kind = this.look;
    if (kind === 'shaded' || kind === 'normals' || kind === 'colours') {
      viewer.setLook(kind);
      for (const [slot] of this.slots()) viewer.setField(slot, null, 'heat');
      this.shown = undefined;
      return this.refreshLegend();
    }
    try {
      const map: MapName = kind === 'curvature' ? 'signed' : 'heat';
      const found = new Map<Slot, Field | null>();
      for (const [slot, { id }] of this.slots()) if (kind !== 'displacement' || slot === 'after') found.set(slot, await this.field(kind, id));
      if (turn !== this.turn) return; // something else is wanted meanwhile
      const ends = found.get('before') ?? found.get('after');
      for (const [slot] of this.slots()) {
        const field = found.get(slot);
        viewer.setField(slot, field && ends ? { ...field, low: ends.low, high: ends.high } : null, map);
      }
      const own = this.layout === 'before' ? found.get('before') : found.get('after');
      const field = own ?? found.get('after') ?? found.get('before') ?? null;
      this.shown = { kind, field: field && ends ? { ...field, low: ends.low, high: ends.high } : null };
      this.refreshLegend();
    } catch (error) {
      this.failed(error);
    }
  }

  private async field(kind: FieldKind, id: number): Promise<Field> {
    const key = `${kind} ${id}`;
    if (!this.fields.has(key)) {
      const field = kind === 'displacement' ? await this.displacement(id) : kind === 'distance' ? await inWorker('distance', id, this.reference!, this.origin!) : await inWorker('curvature', id);
      this.fields.set(key, field);
    }
    return this.fields.get(key)!;
  }

  /** Where the result has its vertices in another order, the distance to the surface before stands in. */
  private async displacement(id: number): Promise<Field> {
    return await inWorker('displacement', this.before!.id, id) ?? { ...await inWorker('distance', id, this.before!.id, this.origin!, 'displacement'), nearest: true };
  }

  private fieldUnit(kind: FieldKind): string {
    return kind === 'curvature' ? (this.unitName ? `1/${this.unitName}` : 'per unit') : this.unitName;
  }

  private refreshLegend(): void {
    const shown = this.shown;
    const title = !shown ? '' : shown.field?.nearest ? 'Distance from before' : TITLES[shown.kind] + (shown.kind === 'displacement' || !this.after ? '' : this.layout === 'before' ? ', before' : ', after');
    showLegend(title, shown?.field ?? null, shown?.kind === 'curvature' ? 'signed' : 'heat', shown ? this.fieldUnit(shown.kind) : '');
    byId('stage').classList.toggle('with-legend', !!shown?.field);
  }

  private async refreshWireframe(): Promise<void> {
    const shown = byId<HTMLInputElement>('wireframe').checked, viewer = this.viewer;
    if (!viewer) return;
    viewer.setWireframe(shown);
    if (!shown) return;
    for (const [slot, { id }] of this.slots()) {
      if (!viewer.hasEdges(slot)) viewer.setEdges(slot, await inWorker('edges', id));
    }
  }

  private turnUp(): void {
    const axis = this.viewer?.turnUp() ?? 'y', button = byId('up');
    button.textContent = `Up: ${axis}`;
    button.setAttribute('aria-label', `Up: ${axis}, the axis that points upwards`);
  }

  /** Tells the place under a click, and its value on a heat map. */
  private async probe(x: number, y: number): Promise<void> {
    const asked = this.hideProbe();
    const ray = this.viewer?.rayAt(x, y), probe = byId<HTMLOutputElement>('probe');
    const mesh = ray && (ray.slot === 'before' ? this.before : this.after);
    const hit = mesh ? await inWorker('pick', mesh.id, ray.from, ray.along, this.shown?.kind) : null;
    if (!hit || asked !== this.probes) return;
    const field = this.shown && this.fields.get(`${this.shown.kind} ${mesh!.id}`);
    const unit = this.shown ? this.fieldUnit(this.shown.kind) : '';
    const value = field && hit.value !== undefined ? ` · ${TITLES[this.shown!.kind].toLowerCase()} ${figure(hit.value)} ${unit}` : '';
    probe.replaceChildren(element('span', {}, `vertex ${count(hit.vertex)} at ${hit.position.map(figure).join(', ')}${value}`));
    Object.assign(probe.dataset, { triangle: String(hit.triangle), value: field ? String(hit.value) : '' });
    probe.hidden = false;
  }

  /** What stands there belongs to an earlier click, and an answer that is still on its way is of no use. */
  private hideProbe(): number {
    byId('probe').hidden = true;
    return ++this.probes;
  }

  private describe(): void {
    const words = this.after ? { before: 'The mesh before smoothing', after: 'The mesh after smoothing', divider: 'The mesh before smoothing on the left, after it on the right', side: 'The mesh before and after smoothing side by side' }[this.layout] : 'The mesh';
    if (!this.viewer || !this.before) return;
    this.viewer.canvas.tabIndex = 0;
    this.viewer.canvas.setAttribute('aria-label', `${words}. Arrow keys turn it, plus and minus zoom, 0 fits.`);
  }
}
