import type { Report } from '../api/types';
import { element } from '../dom';
import { bytes, count, figure, label, milliseconds } from '../text';

type Row = [string, string];

/** The report as sections of rows; lengths in the file's unit. */
function sections(report: Report, unit: string): [string, Row[]][] {
  const length = (value: number) => `${figure(value)} ${unit}`.trim();
  const degrees = (value?: number) => (value === undefined ? 'not comparable' : `${figure(value)}°`);
  const { errors, change, noise, choice, timings } = report;
  return [
    ['Method', [
      ['method', report.method],
      ...(choice ? [['chose', choice.method], ['because', choice.reason]] as Row[] : []),
      ...Object.entries({ ...report.parameters, ...choice?.parameters }).map(([name, value]): Row => [label(name), String(value)]),
    ]],
    ['Noise of the input', noise ? [['size', `${figure(noise.sigmaOverEdge)} mean edges`], ['kind', noise.kind]] : []],
    [`Errors against the ${errors.against}`, [
      ['Ev (Eq. 9)', length(errors.ev)], ['Ev in mean edges', figure(errors.evOverEdge)], ['Ev in diagonals', figure(errors.evOverDiagonal)],
      ['mean distance', length(errors.meanDistance)], ['RMS distance', length(errors.rmsDistance)], ['largest distance', length(errors.maxDistance)],
      ['normals, mean', degrees(errors.meanNormalDegrees)], ['normals, largest', degrees(errors.maxNormalDegrees)],
      ['flipped triangles', errors.flippedTriangles === undefined ? 'not comparable' : count(errors.flippedTriangles)],
    ]],
    ['Change from the input', [
      ['RMS displacement', length(change.rmsDisplacement)], ['largest displacement', length(change.maxDisplacement)],
      ['area', `${figure(change.areaPercent)} %`], ['volume', `${figure(change.volumePercent)} %`],
      ['smallest angle', `${degrees(change.smallestAngleDegreesBefore)} before, ${degrees(change.smallestAngleDegreesAfter)} after`],
    ]],
    ['Mesh', [
      ['vertices', count(report.output.vertices)], ['triangles', count(report.output.triangles)],
      ['boundary edges', count(report.output.boundaryEdges)], ['components', count(report.output.components)],
      ['pinned vertices', count(report.pinnedVertices)],
    ]],
    ['File', [['size', bytes(report.encoding.bytes)], ['rounding', length(report.encoding.quantisationError)]]],
    ['Time', Object.entries(timings).map(([name, value]): Row => [label(name.replace(/Ms$/, '')), milliseconds(value)])],
    ['Server', [['version', report.version], ['request', report.requestId]]],
  ];
}

export function reportTable(report: Report, unit: string): HTMLTableElement {
  const table = element('table');
  for (const [title, rows] of sections(report, unit)) {
    if (rows.length === 0) continue;
    table.append(element('tbody', {},
      element('tr', {}, element('th', { colSpan: 2, scope: 'rowgroup' }, title)),
      ...rows.map(([name, value]) => element('tr', {}, element('th', { scope: 'row' }, name), element('td', {}, value)))));
  }
  return table;
}

/** For the clipboard: opens as a table in a spreadsheet. */
export function reportText(report: Report, unit: string): string {
  return sections(report, unit)
    .filter(([, rows]) => rows.length > 0)
    .map(([title, rows]) => [title, ...rows.map((row) => row.join('\t'))].join('\n'))
    .join('\n\n') + '\n';
}

/** The figures that people look at first. */
export function headline(report: Report, unit: string): [string, string, string][] {
  const { change, errors, noise, timings } = report;
  return [
    ['Noise found', noise ? figure(noise.sigmaOverEdge) : '–', 'mean edges'],
    ['Moved, RMS', figure(change.rmsDisplacement), unit],
    ['Moved at most', figure(change.maxDisplacement), unit],
    ...(errors.against === 'reference' ? [['Error Ev', figure(errors.ev), unit]] as [string, string, string][] : []),
    ['Volume', `${change.volumePercent > 0 ? '+' : ''}${figure(change.volumePercent)}`, '%'],
    ['Time', milliseconds(timings.totalMs), ''],
  ];
}
