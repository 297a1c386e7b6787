/** Numbers and names as people read them. */

const whole = new Intl.NumberFormat('en');

export const count = (value: number) => whole.format(value);

/** Three significant digits, without exponents where they can be avoided. */
export function figure(value: number): string {
  if (value === 0) return '0';
  const size = Math.abs(value);
  if (!Number.isFinite(value)) return String(value);
  if (size >= 1e6 || size < 1e-4) return value.toExponential(2).replace('e+', 'e');
  return String(Number(value.toPrecision(size >= 1000 ? 5 : size >= 100 ? 4 : 3)));
}

export function bytes(value: number): string {
  if (value < 1024) return `${value} bytes`;
  return value < 1024 * 1024 ? `${figure(value / 1024)} KiB` : `${figure(value / 1024 / 1024)} MiB`;
}

export const milliseconds = (value: number) => (value >= 1000 ? `${figure(value / 1000)} s` : `${figure(value)} ms`);

/** "max_displacement" as a label. */
export const label = (name: string) => (name.charAt(0).toUpperCase() + name.slice(1)).replaceAll('_', ' ');

export const FORMAT_NAMES: Record<string, string> = { obj: 'OBJ', drc: 'Draco', ply: 'PLY', stl: 'STL', off: 'OFF', glb: 'GLB' };
export const formatName = (format: string) => FORMAT_NAMES[format] ?? format.toUpperCase();
