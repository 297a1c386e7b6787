/** Draws the meshes: two at most, one draw call each, with one camera for both. Draws only when something changed. */
import {
  BufferAttribute, BufferGeometry, Color, LineBasicMaterial, LineSegments, Mesh, PerspectiveCamera, Raycaster, Scene, type ShaderMaterial, Sphere,
  Vector2, Vector3, WebGLRenderer,
} from 'three';
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';
import type { Field, MeshBuffers } from '../mesh/types';
import type { MapName } from './colours';
import { type SurfaceLook, setColourMap, setLook, surfaceMaterial } from './surface';

export type Slot = 'before' | 'after';
export type Layout = Slot | 'divider' | 'side';

interface Place { scene: Scene; mesh?: Mesh<BufferGeometry, ShaderMaterial>; lines?: LineSegments; buffers?: MeshBuffers }

export interface Ray { slot: Slot; from: number[]; along: number[] }

export class Viewer {
  readonly canvas: HTMLCanvasElement;
  private readonly renderer: WebGLRenderer;
  private readonly camera = new PerspectiveCamera(35, 1, 0.01, 100);
  private controls: OrbitControls;
  private readonly places: Record<Slot, Place> = { before: { scene: new Scene() }, after: { scene: new Scene() } };
  private readonly lineMaterial = new LineBasicMaterial({ transparent: true, opacity: 0.5 });
  private layout: Layout = 'before';
  private split = 0.5;
  private look: SurfaceLook = 'shaded';
  private flat = false;
  private wireframe = false;
  private readonly clay = new Color();
  private waiting = false;
  private radius = 1;
  private centre = new Vector3();
  /** Of the last picture, for tests and the curious. */
  drawCalls = 0;

  constructor(private readonly frame: HTMLElement) {
    this.renderer = new WebGLRenderer({ antialias: true, alpha: true, powerPreference: 'high-performance' });
    this.renderer.setScissorTest(true);
    this.renderer.info.autoReset = false;
    this.canvas = this.renderer.domElement;
    this.canvas.setAttribute('role', 'img');
    this.canvas.setAttribute('aria-label', 'No mesh yet');
    frame.prepend(this.canvas);
    this.controls = this.makeControls();
    this.canvas.addEventListener('keydown', (event) => this.onKey(event));
    new ResizeObserver(() => this.resize()).observe(frame);
    this.setTheme();
    this.resize();
  }

  private makeControls(): OrbitControls {
    const controls = new OrbitControls(this.camera, this.canvas);
    controls.zoomToCursor = true;
    controls.addEventListener('change', () => this.draw());
    return controls;
  }

  setMesh(slot: Slot, buffers?: MeshBuffers): void {
    const place = this.places[slot];
    if (place.buffers === buffers) return;
    place.mesh?.geometry.dispose();
    place.mesh?.material.dispose();
    place.lines?.geometry.dispose();
    place.scene.clear();
    Object.assign(place, { mesh: undefined, lines: undefined, buffers });
    if (buffers) place.scene.add((place.mesh = this.meshOf(buffers)));
    this.draw();
  }

  private meshOf(buffers: MeshBuffers): Mesh<BufferGeometry, ShaderMaterial> {
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', new BufferAttribute(buffers.positions, 3));
    geometry.setAttribute('normal', new BufferAttribute(buffers.normals, 3));
    if (buffers.colours) geometry.setAttribute('vertexColour', new BufferAttribute(buffers.colours, 3, true));
    geometry.setIndex(new BufferAttribute(buffers.indices, 1));
    geometry.boundingSphere = new Sphere(new Vector3(...buffers.centre), buffers.radius); // or three.js would walk all of it
    const mesh = new Mesh(geometry, surfaceMaterial());
    mesh.material.uniforms.clay.value = this.clay;
    mesh.material.uniforms.flatShading.value = this.flat;
    setLook(mesh.material, this.look === 'values' || (this.look === 'colours' && !buffers.colours) ? 'shaded' : this.look);
    return mesh;
  }

  /** Colours the mesh by a number for each vertex; nothing: as it was. */
  setField(slot: Slot, field: Field | null, map: MapName): void {
    const mesh = this.places[slot].mesh;
    if (!mesh) return;
    if (field) {
      mesh.geometry.setAttribute('value', new BufferAttribute(field.values, 1));
      setColourMap(mesh.material, map, field.low, field.high);
      setLook(mesh.material, 'values');
    } else {
      mesh.geometry.deleteAttribute('value');
      setLook(mesh.material, this.look === 'values' ? 'shaded' : this.look);
    }
    this.draw();
  }

  setLook(look: SurfaceLook): void {
    this.look = look;
    for (const { mesh, buffers } of Object.values(this.places)) {
      if (mesh && look !== 'values') setLook(mesh.material, look === 'colours' && !buffers?.colours ? 'shaded' : look);
    }
    this.draw();
  }

  setFlat(flat: boolean): void {
    this.flat = flat;
    for (const { mesh } of Object.values(this.places)) if (mesh) mesh.material.uniforms.flatShading.value = flat;
    this.draw();
  }

  setEdges(slot: Slot, edges: Uint32Array): void {
    const place = this.places[slot];
    if (!place.mesh || place.lines) return;
    const geometry = new BufferGeometry();
    geometry.setAttribute('position', place.mesh.geometry.getAttribute('position'));
    geometry.setIndex(new BufferAttribute(edges, 1));
    geometry.boundingSphere = place.mesh.geometry.boundingSphere;
    place.lines = new LineSegments(geometry, this.lineMaterial);
    place.lines.visible = this.wireframe;
    place.scene.add(place.lines);
    this.draw();
  }

  hasEdges(slot: Slot): boolean { return !this.places[slot].mesh || this.places[slot].lines !== undefined; }

  setWireframe(shown: boolean): void {
    this.wireframe = shown;
    for (const { lines } of Object.values(this.places)) if (lines) lines.visible = shown;
    this.draw();
  }

  setLayout(layout: Layout): void {
    const narrow = () => Math.min(1, this.aspect()), was = narrow();
    this.layout = layout;
    this.resize();
    if (narrow() !== was) this.zoom(was / narrow()); // the mesh keeps its place in its frame
  }

  setSplit(split: number): void {
    this.split = split;
    this.draw();
  }

  /** Colours follow the page's. */
  setTheme(): void {
    const style = getComputedStyle(this.frame);
    this.clay.setStyle(style.color).convertLinearToSRGB(); // the shader writes what it is given
    this.lineMaterial.color.setStyle(style.outlineColor);
    this.draw();
  }

  /** The whole mesh, from a little above and to the side. */
  fit(): void {
    const buffers = this.places.before.buffers ?? this.places.after.buffers;
    if (!buffers) return;
    this.radius = buffers.radius;
    this.centre.set(...buffers.centre);
    const up = this.camera.up.y > 0;
    const from = up ? new Vector3(0.62, 0.42, 1) : new Vector3(0.62, -1, 0.42);
    const narrow = Math.min(1, this.aspect());
    const distance = (this.radius * 0.92) / Math.sin((this.camera.fov * Math.PI) / 360) / narrow;
    this.controls.target.copy(this.centre);
    this.camera.position.copy(this.centre).addScaledVector(from.normalize(), distance);
    this.controls.minDistance = this.radius * 0.02;
    this.controls.maxDistance = this.radius * 40;
    this.controls.update();
    this.draw();
  }

  /** Scanners differ in which axis is up. */
  turnUp(): 'y' | 'z' {
    const toZ = this.camera.up.y > 0;
    this.camera.up.set(0, toZ ? 0 : 1, toZ ? 1 : 0);
    this.controls.dispose(); // they look at the axis only once
    this.controls = this.makeControls();
    this.fit();
    return toZ ? 'z' : 'y';
  }

  /** Radians to the right and upwards. */
  turn(right: number, upwards: number): void {
    const offset = this.camera.position.clone().sub(this.controls.target);
    const up = this.camera.up;
    offset.applyAxisAngle(up, -right);
    const side = new Vector3().crossVectors(up, offset).normalize();
    const height = Math.acos(Math.max(-1, Math.min(1, offset.clone().normalize().dot(up))));
    offset.applyAxisAngle(side, -Math.max(0.02 - Math.PI + height, Math.min(height - 0.02, upwards)));
    this.camera.position.copy(this.controls.target).add(offset);
    this.controls.update();
    this.draw();
  }

  zoom(factor: number): void {
    const offset = this.camera.position.clone().sub(this.controls.target).multiplyScalar(factor);
    this.camera.position.copy(this.controls.target).add(offset);
    this.controls.update();
    this.draw();
  }

  private onKey(event: KeyboardEvent): void {
    const step = event.shiftKey ? 0.3 : 0.1;
    const keys: Record<string, () => void> = {
      ArrowLeft: () => this.turn(-step, 0), ArrowRight: () => this.turn(step, 0), ArrowUp: () => this.turn(0, step), ArrowDown: () => this.turn(0, -step),
      '+': () => this.zoom(0.85), '=': () => this.zoom(0.85), '-': () => this.zoom(1 / 0.85), '0': () => this.fit(),
    };
    if (event.ctrlKey || event.metaKey || event.altKey || !keys[event.key]) return;
    keys[event.key]();
    event.preventDefault();
  }

  /** What lies under a point of the frame. */
  rayAt(x: number, y: number): Ray | null {
    const { width, height } = this.size();
    const half = this.layout === 'side';
    const right = half ? x > width / 2 : x > width * this.split;
    const slot: Slot = this.layout === 'before' || this.layout === 'after' ? this.layout : right ? 'after' : 'before';
    const buffers = this.places[slot].buffers;
    if (!buffers) return null;
    const across = half ? ((x % (width / 2)) / (width / 2)) * 2 - 1 : (x / width) * 2 - 1;
    const caster = new Raycaster();
    caster.setFromCamera(new Vector2(across, 1 - (y / height) * 2), this.camera);
    return { slot, from: caster.ray.origin.toArray().map((value, axis) => value + buffers.origin[axis]), along: caster.ray.direction.toArray() };
  }

  private size() { return { width: this.frame.clientWidth || 1, height: this.frame.clientHeight || 1 }; }
  private aspect(): number { const { width, height } = this.size(); return (this.layout === 'side' ? width / 2 : width) / height; }

  private resize(): void {
    const { width, height } = this.size();
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.renderer.setSize(width, height);
    this.camera.aspect = this.aspect();
    this.camera.updateProjectionMatrix();
    this.draw();
  }

  draw(): void {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => {
      this.waiting = false;
      this.render();
    });
  }

  private render(): void {
    const { width, height } = this.size();
    const distance = this.camera.position.distanceTo(this.centre);
    this.camera.near = Math.max(this.radius * 0.002, distance - this.radius * 1.5);
    this.camera.far = distance + this.radius * 1.5;
    this.camera.updateProjectionMatrix();
    const { renderer } = this;
    renderer.info.reset();
    const at = this.layout === 'side' ? width / 2 : this.layout === 'after' ? 0 : this.layout === 'before' ? width : Math.round(width * this.split);
    const side = this.layout === 'side';
    this.renderPart('before', side ? [0, width / 2] : [0, width], [0, at], height);
    this.renderPart('after', side ? [width / 2, width / 2] : [0, width], [at, width - at], height);
    this.drawCalls = renderer.info.render.calls;
    this.canvas.dataset.drawCalls = String(this.drawCalls);
    this.canvas.dataset.pictures = String(Number(this.canvas.dataset.pictures ?? 0) + 1);
  }

  private renderPart(slot: Slot, [left, across]: number[], [from, part]: number[], height: number): void {
    if (part <= 0) return;
    this.renderer.setViewport(left, 0, across, height);
    this.renderer.setScissor(from, 0, part, height);
    this.renderer.render(this.places[slot].scene, this.camera);
  }
}
