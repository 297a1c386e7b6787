/** Colour maps, as stops of red, green and blue. From calm to hot for sizes; two-sided, grey in the middle, for signs. */
const MAPS = {
  heat: [[36, 52, 122], [30, 116, 184], [38, 176, 164], [186, 214, 82], [250, 178, 54], [214, 40, 57]],
  signed: [[32, 84, 168], [96, 158, 214], [214, 216, 216], [236, 150, 96], [178, 44, 30]],
} as const;

export type MapName = keyof typeof MAPS;

/** The colour at 0 to 1. */
export function colourAt(map: MapName, at: number): [number, number, number] {
  const stops = MAPS[map];
  const place = Math.max(0, Math.min(1, at)) * (stops.length - 1);
  const low = Math.min(stops.length - 2, Math.floor(place));
  return [0, 1, 2].map((k) => Math.round(stops[low][k] + (stops[low + 1][k] - stops[low][k]) * (place - low))) as [number, number, number];
}

/** 256 colours as bytes, for the graphics card. */
export function colourTable(map: MapName): Uint8Array<ArrayBuffer> {
  const bytes = new Uint8Array(256 * 4);
  for (let k = 0; k < 256; k++) bytes.set([...colourAt(map, k / 255), 255], 4 * k);
  return bytes;
}

export const cssGradient = (map: MapName) => `linear-gradient(to right, ${MAPS[map].map((colour) => `rgb(${colour.join(' ')})`).join(', ')})`;
