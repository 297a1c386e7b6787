// What the colours say is what the report says.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { House, choose, drawn, screenshot, smooth } from './house.mjs';
import { ball, obj } from './meshes.mjs';

let house, page;
before(async () => {
  house = await House.open();
  page = await house.visit();
  await choose(page, house.file('ball.obj', obj(ball(24, 0.04))));
  await choose(page, house.file('clean.obj', obj(ball(24, 0))), '#reference-file');
  await page.click('#more summary');
  await page.selectOption('#method', 'taubin');
  await smooth(page);
});
after(() => house.close());

const close = (a, b, share, what) => assert.ok(Math.abs(a - b) <= share * Math.abs(b), `${what}: ${a} and ${b}`);

async function lastReport() {
  const { jobs } = await (await fetch(`${house.url}/v1/jobs?page_size=1`)).json();
  return { job: jobs[0], report: await (await fetch(`${house.url}/v1/jobs/${jobs[0].id}/report`)).json() };
}

const legend = async () => Object.fromEntries(Object.entries(await page.locator('#legend').evaluate((node) => ({ ...node.dataset }))).map(([name, value]) => [name, Number(value)]));

async function show(look) {
  const was = await page.textContent('#legend-title');
  await page.selectOption('#look', look);
  await page.waitForFunction((words) => !document.getElementById('legend').hidden && document.getElementById('legend-title').textContent !== words, was);
  await drawn(page);
}

/** The colours of points of the page, as the screen has them. */
async function pixels(points) {
  const png = (await page.screenshot()).toString('base64');
  const other = await house.browser.newPage();
  const colours = await other.evaluate(async ([data, places]) => {
    const image = await createImageBitmap(await (await fetch(`data:image/png;base64,${data}`)).blob());
    const canvas = new OffscreenCanvas(image.width, image.height).getContext('2d');
    canvas.drawImage(image, 0, 0);
    return places.map(([x, y]) => [...canvas.getImageData(x, y, 1, 1).data].slice(0, 3));
  }, [png, points]);
  await other.close();
  return colours;
}

/** The legend's own colour at a place from 0 to 1. */
async function legendColour(at) {
  const gradient = await page.locator('#gradient').evaluate((node) => node.style.background);
  const stops = [...gradient.matchAll(/rgb\((\d+),? (\d+),? (\d+)\)/g)].map((found) => found.slice(1).map(Number));
  assert.ok(stops.length >= 5, gradient);
  const place = Math.max(0, Math.min(1, at)) * (stops.length - 1), low = Math.min(stops.length - 2, Math.floor(place));
  return stops[low].map((value, k) => value + (stops[low + 1][k] - value) * (place - low));
}

const positionsOf = (text) => text.split('\n').filter((line) => line.startsWith('v ')).map((line) => line.split(' ').slice(1).map(Number));

test('the heat map of the displacement has the colours of its legend, and the legend the figures of the report', async () => {
  await page.check('input[value=after]', { force: true });
  await show('displacement');
  const { job, report } = await lastReport();
  const ends = await legend();
  close(ends.largest, report.change.maxDisplacement, 1e-4, 'largest displacement');
  close(ends.rms, report.change.rmsDisplacement, 1e-4, 'RMS displacement');

  const mesh = ball(24, 0.04), moved = positionsOf(await (await fetch(`${house.url}/v1/jobs/${job.id}/mesh`)).text());
  const size = mesh.positions.map((p, v) => Math.hypot(...p.map((value, axis) => value - moved[v][axis])));
  const box = await page.locator('#view canvas').boundingBox();
  const points = [], values = [];
  for (const [right, down] of [[0, 0], [0.06, 0.03], [-0.05, 0.06], [-0.07, -0.04], [0.03, -0.07], [0.01, 0.05], [-0.02, -0.02]]) {
    const at = [Math.round(box.x + box.width / 2 + right * box.height), Math.round(box.y + box.height / 2 + down * box.height)];
    await page.mouse.click(...at);
    await page.waitForSelector('#probe', { state: 'visible' });
    const { triangle, value } = await page.locator('#probe').evaluate((node) => ({ ...node.dataset }));
    const corners = mesh.triangles[Number(triangle)].map((v) => size[v]);
    assert.ok(Number(value) >= Math.min(...corners) * 0.999 && Number(value) <= Math.max(...corners) * 1.001, `${value} of ${corners}`);
    points.push(at);
    values.push(Number(value));
  }
  const seen = await pixels(points);
  assert.ok(new Set(seen.map(String)).size > 3, 'the heat map has more than one colour');
  for (const [k, value] of values.entries()) {
    const expected = await legendColour((value - ends.low) / (ends.high - ends.low));
    assert.ok(seen[k].every((part, c) => Math.abs(part - expected[c]) <= 14), `${value} is ${seen[k]}, the legend says ${expected}`);
  }
  await screenshot(page, 'look-displacement');
});

test('the distance to the reference has the figures of the report', async () => {
  await show('distance');
  const { report } = await lastReport();
  assert.equal(report.errors.against, 'reference');
  const ends = await legend();
  close(ends.largest, report.errors.maxDistance, 1e-3, 'largest distance');
  close(ends.rms, report.errors.rmsDistance, 1e-3, 'RMS distance');
  close(ends.mean, report.errors.meanDistance, 1e-3, 'mean distance');
  const bars = await page.locator('#histogram rect').count();
  assert.equal(bars, 48);
});

test('what a click tells is dropped when it comes after another look was chosen', async () => {
  const box = await page.locator('#view canvas').boundingBox();
  const at = { clientX: Math.round(box.x + box.width / 2), clientY: Math.round(box.y + box.height / 2), bubbles: true };
  await page.mouse.click(at.clientX, at.clientY);
  await page.waitForSelector('#probe', { state: 'visible' });
  // Again, and in the same turn of the page's thread another look: its worker answers the click first.
  await page.locator('#view canvas').evaluate((node, where) => {
    node.dispatchEvent(new MouseEvent('click', where));
    const looks = document.getElementById('look');
    looks.value = 'curvature';
    looks.dispatchEvent(new Event('change', { bubbles: true }));
  }, at);
  await page.waitForFunction(() => document.getElementById('legend-title').textContent.startsWith('Curvature'));
  assert.equal(await page.locator('#probe').isVisible(), false);
  await show('distance');
});

test('the divider moves with keys and with the mouse, and each side shows its mesh', async () => {
  await page.selectOption('#look', 'normals');
  await page.check('input[value=divider]', { force: true });
  await drawn(page);
  const divider = page.locator('#divider');
  await divider.focus();
  await page.keyboard.press('Home');
  await drawn(page);
  const box = await page.locator('#view canvas').boundingBox();
  const middle = Array.from({ length: 40 }, (_, k) => [Math.round(box.x + box.width / 2 - 60 + 3 * k), Math.round(box.y + box.height / 2 + 20)]);
  const smoothed = await pixels(middle);
  await page.keyboard.press('End');
  assert.equal(await divider.getAttribute('aria-valuenow'), '100');
  await drawn(page);
  const noisy = await pixels(middle);
  const rough = (row) => row.slice(1).reduce((sum, colour, k) => sum + colour.reduce((of, part, c) => of + Math.abs(part - row[k][c]), 0), 0);
  assert.ok(rough(noisy) > 1.2 * rough(smoothed), `normals before ${rough(noisy)}, after ${rough(smoothed)}`);
  await page.keyboard.press('Home');
  for (let k = 0; k < 10; k++) await page.keyboard.press('Shift+ArrowRight');
  assert.equal(await divider.getAttribute('aria-valuenow'), '100');
  await page.keyboard.press('Home');
  await page.mouse.move(box.x + 2, box.y + 300);
  await page.mouse.down();
  await page.mouse.move(box.x + box.width * 0.7, box.y + 300, { steps: 4 });
  await page.mouse.up();
  assert.equal(await divider.getAttribute('aria-valuenow'), '70');
});

test('curvature, wireframe and side by side draw without a complaint', async () => {
  await show('curvature');
  await page.check('#wireframe', { force: true });
  await page.waitForFunction(() => document.querySelector('#view canvas').dataset.drawCalls === '4');
  await page.check('input[value=side]', { force: true });
  await page.check('#flat', { force: true });
  await drawn(page);
  await screenshot(page, 'look-side-by-side');
  assert.deepEqual(page.wrongs, []);
});

test('runs are compared in a table, and an earlier one is shown again', async () => {
  await page.fill('#parameter-iterations', '50');
  await smooth(page);
  const rows = page.locator('#runs-table tbody tr');
  assert.equal(await rows.count(), 2);
  assert.match(await rows.nth(1).textContent(), /iterations 50/);
  const largest = await page.locator('#figures dd').nth(2).textContent();
  await page.click('#runs-table tbody tr:first-child button');
  await page.waitForSelector('#runs-table tbody tr:first-child.shown');
  assert.notEqual(await page.locator('#figures dd').nth(2).textContent(), largest);
  const report = await page.locator('#report').textContent();
  assert.match(report, /Errors against the reference/);
});
