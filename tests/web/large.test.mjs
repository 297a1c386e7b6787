// A million triangles: one draw call a mesh, and the page's own thread is never away for long.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { House, choose, drawn, smooth } from './house.mjs';
import { ball, obj } from './meshes.mjs';

const LONGEST = 200; // ms
const TRIES = 3; // a busy machine only adds to what the page's thread takes itself

let house;
before(async () => { house = await House.open(); });
after(() => house.close());

/** Everything a user does with a mesh, once; the longest task in ms. */
async function longestTask(path) {
  const page = await house.visit();
  await page.evaluate(() => {
    window.longest = { duration: 0 };
    new PerformanceObserver((list) => {
      for (const { duration, startTime } of list.getEntries()) if (duration > window.longest.duration) window.longest = { duration, startTime };
    }).observe({ type: 'longtask', buffered: false });
  });
  const start = Date.now();
  await choose(page, path);
  console.log(`shown after ${Date.now() - start} ms`);
  assert.equal(await page.getAttribute('#view canvas', 'data-draw-calls'), '1');
  await page.click('#more summary');
  await page.selectOption('#method', 'laplacian');
  await page.fill('#parameter-iterations', '2');
  await smooth(page);
  assert.equal(await page.getAttribute('#view canvas', 'data-draw-calls'), '2');
  await page.selectOption('#look', 'displacement');
  await page.waitForSelector('#legend', { state: 'visible' });
  await page.focus('#view canvas');
  for (let k = 0; k < 4; k++) {
    await page.keyboard.press('ArrowLeft');
    await drawn(page);
  }
  const box = await page.locator('#view canvas').boundingBox();
  await page.mouse.click(box.x + box.width * 0.6, box.y + box.height / 2);
  await page.waitForSelector('#probe', { state: 'visible' });
  const longest = await page.evaluate(() => window.longest);
  console.log(`longest task ${longest.duration} ms`);
  assert.deepEqual(page.wrongs, []);
  await page.close();
  return longest.duration;
}

test('a million triangles are shown, smoothed and coloured without a task over 200 ms', async () => {
  const mesh = ball(500, 0.0005);
  assert.ok(mesh.triangles.length > 990_000);
  const path = house.file('million.obj', obj(mesh));
  let longest = Infinity;
  for (let k = 0; k < TRIES && longest > LONGEST; k++) longest = Math.min(longest, await longestTask(path));
  assert.ok(longest <= LONGEST, `${longest} ms`);
});
