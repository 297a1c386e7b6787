// Every format that scanners write: shown as it is, smoothed where the server smooths it, and given back with the bytes of the API.
import assert from 'node:assert/strict';
import { readFileSync } from 'node:fs';
import { after, before, test } from 'node:test';
import { House, choose, smooth } from './house.mjs';
import { ball, glb, glbDraco, obj, off, plyBinary, plyText, stl, stlText } from './meshes.mjs';

let house, page;
const mesh = ball(16);
before(async () => {
  house = await House.open();
  page = await house.visit();
});
after(() => house.close());

async function draco(method) {
  const query = `method=laplacian&iterations=0&output=drc&draco_method=${method}`;
  return Buffer.from(await (await fetch(`${house.url}/v1/smooth?${query}`, { method: 'POST', body: obj(mesh) })).arrayBuffer());
}

for (const [name, what, make] of [
  ['a.obj', 'OBJ', () => obj(mesh)],
  ['quads.obj', 'OBJ', () => 'v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 1 1 0 0 0 1\nv 0 1 0 1 1 1\nv .5 .5 1e0 0 0 0\nf 1 4 3 -4\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5 # the last\n'],
  ['sequential.drc', 'Draco', () => draco('sequential')],
  ['edgebreaker.drc', 'Draco', () => draco('edgebreaker')],
  ['text.ply', 'PLY', () => plyText(mesh)],
  ['little.ply', 'PLY', () => plyBinary(mesh)],
  ['big.ply', 'PLY', () => plyBinary(mesh, false)],
  ['binary.stl', 'STL', () => stl(mesh)],
  ['text.stl', 'STL', () => stlText(mesh)],
  ['a.off', 'OFF', () => off(mesh)],
  ['a.glb', 'GLB', () => glb(mesh)],
  ['draco.glb', 'GLB', async () => glbDraco(mesh, await draco('sequential'))],
]) {
  test(`${name}`, async (context) => {
    const path = house.file(name, await make());
    await choose(page, path);
    const triangles = name === 'quads.obj' ? 6 : mesh.triangles.length;
    assert.match(await page.textContent('#mesh-facts'), new RegExp(`^${what}, ${triangles.toLocaleString('en')} triangles`));
    assert.deepEqual(page.wrongs, []);
    const answer = await fetch(`${house.url}/v1/smooth`, { method: 'POST', body: readFileSync(path) });
    const bytes = Buffer.from(await answer.arrayBuffer()); // at once: a caller who takes nothing is cut off
    if (!answer.ok) { // a codec that this server does not have: its own sentence, and no more
      const { code, detail } = JSON.parse(bytes);
      assert.equal(code, 'unsupported_format');
      await page.click('#smooth');
      await page.waitForSelector('#alert', { state: 'visible' });
      assert.match((await page.textContent('#alert p')).toLowerCase(), new RegExp(detail.slice(0, 20).toLowerCase()));
      return context.diagnostic(`this server does not smooth ${what}`);
    }
    await smooth(page);
    const [download] = await Promise.all([page.waitForEvent('download'), page.click('#download')]);
    assert.ok(readFileSync(await download.path()).equals(bytes), 'the bytes of the API');
    if (name !== 'quads.obj') {
      await page.selectOption('#look', 'displacement');
      await page.waitForSelector('#legend', { state: 'visible' });
      await page.selectOption('#look', 'shaded');
    }
    assert.deepEqual(page.wrongs, []);
  });
}

test('files that are cut anywhere get a sentence or are shown, and never break the page', async () => {
  for (const [name, bytes] of [['cut.ply', plyBinary(ball(4))], ['cut.glb', glb(ball(4))], ['cut.off', Buffer.from(off(ball(4)))], ['cut.drc', await draco('edgebreaker')]]) {
    for (const share of [0.1, 0.5, 0.9]) {
      await page.evaluate(() => { document.getElementById('alert').hidden = true; });
      await page.setInputFiles('#file', house.file(name, bytes.subarray(0, Math.floor(bytes.length * share))));
      await page.waitForFunction((file) => !document.getElementById('alert').hidden || document.getElementById('mesh-name').textContent === file, name);
      if (await page.locator('#alert').isVisible()) assert.match(await page.textContent('#alert p'), /^cut\.\w+: .+\.$/);
    }
  }
  assert.deepEqual(page.wrongs, []);
  await choose(page, house.file('after.obj', obj(mesh)));
});
