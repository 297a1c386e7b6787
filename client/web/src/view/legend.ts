import { byId } from '../dom';
import type { Field } from '../mesh/types';
import { count, figure } from '../text';
import { type MapName, cssGradient } from './colours';

const SVG = 'http://www.w3.org/2000/svg';
const WIDTH = 240, HEIGHT = 44, BINS = 48;

/** The colour map with its numbers in the file's unit, and how many vertices have which. */
export function showLegend(title: string, field: Field | null, map: MapName, unit: string): void {
  byId('legend').hidden = !field;
  if (!field) return;
  byId('legend-title').textContent = title;
  byId('gradient').style.background = cssGradient(map);
  byId('legend-low').textContent = field.smallest < field.low ? `≤ ${figure(field.low)}` : figure(field.low);
  byId('legend-middle').textContent = figure((field.low + field.high) / 2);
  byId('legend-high').textContent = `${field.largest > field.high ? '≥ ' : ''}${figure(field.high)} ${unit}`;
  byId('legend-words').textContent = map === 'heat'
    ? `Mean ${figure(field.mean)}, RMS ${figure(field.rms)}, largest ${figure(field.largest)} ${unit} over ${count(field.values.length)} vertices.`
    : `From ${figure(field.smallest)} to ${figure(field.largest)} ${unit}; warm bulges, blue is hollow.`;
  drawHistogram(field, title, unit);
  const legend = byId('legend');
  Object.assign(legend.dataset, { low: String(field.low), high: String(field.high), largest: String(field.largest), rms: String(field.rms), mean: String(field.mean) });
}

/** Vertices per bin, from one end of the colours to the other; those beyond are in the outermost bins. */
function histogramOf({ values, low, high }: Field): number[] {
  const bins = new Array<number>(BINS).fill(0);
  for (const value of values) bins[Math.max(0, Math.min(BINS - 1, Math.floor(((value - low) / (high - low)) * BINS)))]++;
  return bins;
}

function drawHistogram(field: Field, title: string, unit: string): void {
  const { low, high } = field, histogram = histogramOf(field);
  const svg = byId('histogram') as unknown as SVGSVGElement;
  const most = Math.max(...histogram), wide = WIDTH / histogram.length;
  svg.replaceChildren(...histogram.map((vertices, bin) => {
    const bar = document.createElementNS(SVG, 'rect');
    // By the square root, so that few vertices are seen too.
    const tall = Math.sqrt(vertices / most) * HEIGHT;
    for (const [name, value] of Object.entries({ x: bin * wide, y: HEIGHT - tall, width: wide * 0.86, height: tall })) bar.setAttribute(name, String(value));
    const tip = document.createElementNS(SVG, 'title');
    tip.textContent = `${figure(low + ((high - low) * bin) / histogram.length)} ${unit}: ${count(vertices)} vertices`;
    bar.append(tip);
    return bar;
  }));
  svg.setAttribute('aria-label', `Histogram of ${title.toLowerCase()}: most vertices near ${figure(low + ((high - low) * (histogram.indexOf(most) + 0.5)) / histogram.length)} ${unit}`);
}
