// What the page offers to copy does what was just done: the calls are run, and their results have the same bytes.
import assert from 'node:assert/strict';
import { execFile } from 'node:child_process';
import { mkdtempSync, readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { promisify } from 'node:util';
import { House, choose, smooth } from './house.mjs';
import { ball, obj } from './meshes.mjs';

const run = promisify(execFile);
const { CURL, PYTHON, CXX, CXX_FLAGS } = process.env;

let house, page;
before(async () => {
  house = await House.open();
  page = await house.visit();
  await choose(page, house.file("a scan's.obj", obj(ball(14))));
});
after(() => house.close());

async function resultOfPage() {
  const [download] = await Promise.all([page.waitForEvent('download'), page.click('#download')]);
  return readFileSync(await download.path());
}

async function call(language) {
  await page.check(`input[value=${language}]`, { force: true });
  return page.textContent('#call');
}

/** Runs a call beside copies of the files; gives what it wrote. */
async function resultOf(language, text) {
  const folder = mkdtempSync(join(house.folder, `${language}-`));
  for (const name of ["a scan's.obj", 'clean one.obj']) writeFileSync(join(folder, name), readFileSync(house.file(name, obj(ball(14, name.startsWith('a') ? 0.01 : 0)))));
  const options = { cwd: folder, env: { ...process.env, no_proxy: '*', NO_PROXY: '*', no_grpc_proxy: '127.0.0.1' } };
  if (language === 'curl') await run('sh', ['-ec', text.replace(/^curl/, CURL)], options);
  if (language === 'python') await run(PYTHON, ['-c', text], options);
  if (language === 'cpp') {
    writeFileSync(join(folder, 'call.cpp'), text.replace('127.0.0.1:50051', house.grpc));
    await run(CXX, ['-std=c++20', '-O0', 'call.cpp', '-o', 'call', ...CXX_FLAGS.split(' ').filter(Boolean)], options);
    await run(join(folder, 'call'), [], options);
  }
  const written = /-smooth\.\w+/.exec(text)[0];
  return readFileSync(join(folder, `a scan's${written}`));
}

test('without a reference, as it came', async () => {
  await page.click('#more summary');
  await page.selectOption('#method', 'taubin');
  await page.fill('#parameter-iterations', '5');
  await page.selectOption('#parameter-boundary', 'free');
  await smooth(page);
  const expected = await resultOfPage();
  for (const language of ['curl', 'python']) assert.ok((await resultOf(language, await call(language))).equals(expected), language);
});

test('with a reference and as Draco', async () => {
  await choose(page, house.file('clean one.obj', obj(ball(14, 0))), '#reference-file');
  await smooth(page);
  await page.selectOption('#format', 'drc');
  const expected = await resultOfPage();
  for (const language of ['curl', 'python', 'cpp']) assert.ok((await resultOf(language, await call(language))).equals(expected), language);
});
