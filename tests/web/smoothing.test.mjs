// From a file to its result: what the page shows is what the API answers.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { after, before, test } from 'node:test';
import { House, choose, drawn, eventually, screenshot, smooth, takeSample } from './house.mjs';
import { ball, obj } from './meshes.mjs';

let house;
before(async () => { house = await House.open(); });
after(() => house.close());

const fine = (page) => assert.deepEqual(page.wrongs, []);

test('a sample is smoothed, and the divider shows before and after', async () => {
  const page = await house.visit();
  await screenshot(page, 'empty');
  await takeSample(page);
  assert.equal(await page.getAttribute('#view canvas', 'data-draw-calls'), '1');
  await smooth(page);
  assert.ok(await page.isChecked('input[value=divider]'));
  assert.equal(await page.getAttribute('#view canvas', 'data-draw-calls'), '2', 'one for each mesh');
  assert.match(await page.textContent('#result-words'), /^auto chose \w+: .+\.$/);
  await screenshot(page, 'divider');
  await page.selectOption('#look', 'displacement');
  await page.waitForSelector('#legend', { state: 'visible' });
  await drawn(page);
  await screenshot(page, 'heat-map');
  fine(page);
});

test('the download has the bytes of the API', async () => {
  const page = await house.visit();
  const path = house.file('ball.obj', obj(ball()));
  await choose(page, path);
  await page.click('#more summary');
  await page.selectOption('#method', 'taubin');
  await page.fill('#parameter-iterations', '7');
  await smooth(page);
  for (const format of ['obj', 'drc']) {
    await page.selectOption('#format', format);
    const [download] = await Promise.all([page.waitForEvent('download'), page.click('#download')]);
    assert.equal(download.suggestedFilename(), `ball-smooth.${format}`);
    const answer = await fetch(`${house.url}/v1/smooth?method=taubin&iterations=7&output=${format}`, { method: 'POST', body: readFileSync(path) });
    assert.equal(answer.status, 200);
    assert.ok(readFileSync(await download.path()).equals(Buffer.from(await answer.arrayBuffer())), format);
  }
  fine(page);
});

test('only what somebody changed is sent, whatever the method', async () => {
  const page = await house.visit();
  await choose(page, house.file('small.obj', obj(ball(8))));
  await page.click('#more summary');
  const { methods } = await (await fetch(`${house.url}/v1/methods`)).json();
  for (const { name } of methods) {
    await page.selectOption('#method', name);
    await smooth(page);
    const { jobs } = await (await fetch(`${house.url}/v1/jobs?page_size=1`)).json();
    assert.deepEqual(jobs[0].options, { method: name, parameters: {} });
  }
  assert.equal(await page.locator('#runs-table tbody tr').count(), 8, 'the last runs are kept');
  fine(page);
});

test('a file that is dropped anywhere on the page is shown', async () => {
  const page = await house.visit();
  const dropped = await page.evaluateHandle((text) => {
    const transfer = new DataTransfer();
    transfer.items.add(new File([text], 'dropped.obj'));
    return transfer;
  }, obj(ball(6)));
  for (const event of ['dragover', 'drop']) await page.dispatchEvent('body', event, { dataTransfer: dropped });
  await page.waitForFunction(() => document.getElementById('mesh-name').textContent === 'dropped.obj');
  assert.match(await page.textContent('#mesh-facts'), new RegExp(`^OBJ, ${ball(6).triangles.length} triangles`));
  fine(page);
});

test('a bad file gets the sentence with its place', async () => {
  const page = await house.visit();
  const bad = obj(ball(6)).replace(/^(f .*) \d+$/m, '$1 99999');
  await page.setInputFiles('#file', house.file('bad.obj', bad));
  await page.waitForSelector('#alert', { state: 'visible' });
  assert.match(await page.textContent('#alert p'), /bad\.obj: a face uses vertex 99998 of \d+ \(line \d+\)\./);
  fine(page);
});

test('what the server refuses it says itself, and the page goes on', async () => {
  const small = await House.open({ flags: ['--max-triangles', '2000'] });
  try {
    const page = await small.visit();
    const path = small.file('many.obj', obj(ball(40)));
    await choose(page, path);
    await page.click('#smooth');
    await page.waitForSelector('#alert', { state: 'visible' });
    const { detail } = await (await fetch(`${small.url}/v1/smooth`, { method: 'POST', body: readFileSync(path) })).json();
    assert.equal((await page.textContent('#alert p')).toLowerCase(), `${detail}.`.toLowerCase());
    await choose(page, small.file('few.obj', obj(ball(10))));
    await smooth(page);
    fine(page);
  } finally {
    await small.close();
  }
});

test('cancel ends the job on the server', async () => {
  const page = await house.visit();
  await choose(page, house.file('large.obj', obj(ball(160))));
  await page.click('#more summary');
  await page.selectOption('#method', 'laplacian');
  await page.fill('#parameter-iterations', '100000');
  await page.click('#smooth');
  await page.waitForFunction(() => document.getElementById('progress-words').textContent.startsWith('Smoothing'));
  await page.click('#cancel');
  await page.waitForSelector('#progress', { state: 'hidden' });
  const { jobs } = await (await fetch(`${house.url}/v1/jobs?page_size=1`)).json();
  await eventually(async () => (await (await fetch(`${house.url}/v1/jobs/${jobs[0].id}`)).json()).state === 'JOB_STATE_CANCELLED', 'the job is cancelled');
  await eventually(async () => await house.metric('burnish_jobs_running') === 0, 'the worker is free');
  assert.ok(await page.isEnabled('#smooth'));
  fine(page);
});
