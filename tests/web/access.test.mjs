// The page for everybody: screen readers, keyboards, phones, light and dark, slow lines, servers with tokens.
import assert from 'node:assert/strict';
import { createHash } from 'node:crypto';
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { after, before, test } from 'node:test';
import { House, choose, drawn, screenshot, smooth, takeSample } from './house.mjs';
import { ball, obj } from './meshes.mjs';

const axe = readFileSync(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');

let house;
before(async () => { house = await House.open(); });
after(() => house.close());

async function checkAccess(page, state) {
  await page.evaluate(axe);
  const { violations, passes } = await page.evaluate(() => axe.run({ runOnly: ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa', 'wcag22aa', 'best-practice'] }));
  assert.ok(passes.length > 20);
  assert.deepEqual(violations.map(({ id, nodes }) => `${state}: ${id}: ${nodes.map(({ target, failureSummary }) => `${target} ${failureSummary}`).join('; ')}`), []);
}

for (const dark of [false, true]) {
  test(`axe finds nothing in the ${dark ? 'dark' : 'light'} page, empty and with a result`, async () => {
    const page = await house.visit({ dark });
    await checkAccess(page, 'empty');
    await takeSample(page, 'knot');
    await smooth(page);
    await page.selectOption('#look', 'distance');
    await page.waitForSelector('#legend', { state: 'visible' });
    for (const summary of await page.locator('summary').all()) await summary.click();
    await drawn(page);
    await checkAccess(page, 'result');
    await screenshot(page, dark ? 'dark' : 'light');
    assert.deepEqual(page.wrongs, []);
  });
}

test('a phone shows all of it without scrolling sideways', async () => {
  const page = await house.visit({ width: 390, height: 844, touch: true });
  await screenshot(page, 'phone-empty');
  await takeSample(page);
  await smooth(page);
  const { wide, own } = await page.evaluate(() => ({ wide: document.documentElement.scrollWidth, own: innerWidth }));
  assert.ok(wide <= own, `${wide} > ${own}`);
  for (const name of ['#smooth', '#download', 'input[value=divider] + span', '#look', '#fit']) {
    const box = await page.locator(name).boundingBox();
    assert.ok(box.x >= 0 && box.x + box.width <= own && box.height >= 32, `${name}: ${JSON.stringify(box)}`);
  }
  await checkAccess(page, 'phone');
  await page.evaluate(() => scrollTo(0, 0));
  await drawn(page);
  await screenshot(page, 'phone');
});

test('a keyboard is enough', async () => {
  const page = await house.visit();
  const press = async (key, until) => {
    for (let k = 0; k < 60; k++) {
      await page.keyboard.press(key);
      if (await page.evaluate(until)) return;
    }
    assert.fail(`no focus by ${key}: ${until}`);
  };
  const tabTo = (id) => press('Tab', `document.activeElement.id === '${id}'`);
  await press('Tab', `document.activeElement.dataset.sample === 'machined'`);
  await page.keyboard.press('Enter');
  await page.waitForFunction(() => document.getElementById('reference-name').textContent === 'machined-clean.obj');
  await tabTo('parameter-strength');
  await page.keyboard.press('ArrowRight');
  assert.notEqual(await page.inputValue('#parameter-strength'), '1');
  await tabTo('smooth');
  await page.keyboard.press('Enter');
  await page.waitForSelector('#result', { state: 'visible' });
  await press('Shift+Tab', `document.activeElement.id === 'divider'`);
  await page.keyboard.press('ArrowLeft');
  assert.equal(await page.getAttribute('#divider', 'aria-valuenow'), '48');
  await press('Shift+Tab', `document.activeElement.matches('#view canvas')`);
  await drawn(page);
  const pictures = await page.getAttribute('#view canvas', 'data-pictures');
  await page.keyboard.press('ArrowLeft');
  await page.waitForFunction((last) => document.querySelector('#view canvas').dataset.pictures !== last, pictures);
  await tabTo('download');
  const [download] = await Promise.all([page.waitForEvent('download'), page.keyboard.press('Enter')]);
  assert.equal(download.suggestedFilename(), 'machined-smooth.obj');
  assert.deepEqual(page.wrongs, []);
});

test('the first paint takes less than 300 KB, and three.js comes after it', async () => {
  const page = await house.visit();
  const { paint, files } = await page.evaluate(() => ({
    paint: performance.getEntriesByName('first-contentful-paint')[0].startTime,
    files: [...performance.getEntriesByType('navigation'), ...performance.getEntriesByType('resource')]
      .map(({ name, startTime, encodedBodySize, transferSize, decodedBodySize }) => ({ name, startTime, encodedBodySize, transferSize, decodedBodySize })),
  }));
  const early = files.filter(({ startTime }) => startTime <= paint), viewer = files.find(({ name }) => /viewer/.test(name));
  const size = early.reduce((sum, { encodedBodySize }) => sum + encodedBodySize, 0);
  assert.ok(viewer.startTime > paint, `three.js at ${viewer.startTime}, paint at ${paint}`);
  assert.ok(viewer.encodedBodySize > 50_000 && viewer.encodedBodySize < viewer.decodedBodySize / 2, 'compressed');
  assert.ok(size > 5_000 && size < 300_000, `${size} bytes: ${early.map(({ name }) => name)}`);
  console.log(`first paint: ${size} bytes compressed in ${early.length} files; with three.js ${size + viewer.encodedBodySize}`);
});

test('the page stands still while it loads, and says what it is', async () => {
  const page = await house.visit();
  const { shifts, title, language, description, viewport } = await page.evaluate(async () => ({
    shifts: await new Promise((done) => {
      let sum = 0;
      new PerformanceObserver((list) => { for (const entry of list.getEntries()) sum += entry.value; }).observe({ type: 'layout-shift', buffered: true });
      setTimeout(() => done(sum), 100);
    }),
    title: document.title, language: document.documentElement.lang,
    description: document.querySelector('meta[name=description]').content, viewport: document.querySelector('meta[name=viewport]').content,
  }));
  assert.ok(shifts < 0.1, `moves by ${shifts}`);
  assert.deepEqual([title, language], ['Burnish', 'en']);
  assert.ok(description.length > 20 && !/maximum-scale|user-scalable/.test(viewport));
});

test('files travel compressed, are kept by their names, and are asked for once', async () => {
  const html = await fetch(house.url, { headers: { 'Accept-Encoding': 'gzip' } });
  assert.equal(html.headers.get('content-encoding'), 'gzip');
  const script = /src="(\/assets\/[^"]+\.js)"/.exec(await html.text())[1];
  const asset = await fetch(house.url + script, { headers: { 'Accept-Encoding': 'identity' } });
  assert.equal(asset.headers.get('content-encoding'), null);
  assert.match(asset.headers.get('cache-control'), /immutable/);
  assert.equal(Number(asset.headers.get('content-length')), (await asset.arrayBuffer()).byteLength);
  const known = { 'If-None-Match': html.headers.get('etag') };
  assert.equal((await fetch(house.url, { headers: known })).status, 304);
  const head = await fetch(house.url, { method: 'HEAD', headers: { 'Accept-Encoding': 'gzip' } });
  assert.equal(head.headers.get('etag'), html.headers.get('etag'));
  assert.equal((await head.arrayBuffer()).byteLength, 0);
  const page = await house.visit();
  await page.reload();
  await page.waitForSelector('#view canvas');
  const again = await page.evaluate(() => performance.getEntriesByType('resource').filter(({ name, transferSize }) => name.includes('/assets/') && transferSize > 0).map(({ name }) => name));
  assert.deepEqual(again, []);
});

test('a server with tokens shows the page and asks for one', async () => {
  const hash = createHash('sha256').update('open-sesame').digest('hex');
  const guarded = await House.open({ flags: ['--tokens', house.file('tokens.json', JSON.stringify({ tokens: [{ name: 'people', sha256: hash }] }))] });
  try {
    const context = await guarded.browser.newContext();
    const page = await context.newPage();
    await page.goto(guarded.url);
    await page.waitForSelector('#token', { state: 'visible' });
    await page.fill('#token-value', 'wrong');
    await page.keyboard.press('Enter');
    await page.waitForSelector('#token', { state: 'visible' });
    await page.fill('#token-value', 'open-sesame');
    await page.keyboard.press('Enter');
    await page.waitForSelector('#method option', { state: 'attached' });
    await page.waitForSelector('#alert', { state: 'hidden' });
    await choose(page, guarded.file('ball.obj', obj(ball(12))));
    await smooth(page);
    assert.match(await page.textContent('#call'), /Authorization: Bearer \$BURNISH_TOKEN/);
    assert.ok(!(await page.content()).includes('open-sesame'));
  } finally {
    await guarded.close();
  }
});
