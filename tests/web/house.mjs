// A burnishd on a free port and a Chromium that looks at it. Everything that a page does wrong on its own is noted:
// errors, words on the console, breaches of its policy, and requests to anybody but burnishd.
import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { once } from 'node:events';
import { existsSync, mkdirSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { setTimeout as wait } from 'node:timers/promises';
import { chromium } from 'playwright-core';

const FLAGS = ['--no-sandbox', '--disable-quic', '--no-first-run', '--disable-background-networking', '--disable-component-update',
  '--disable-sync', '--no-proxy-server', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'];
const PATIENCE = 60_000;

export async function eventually(condition, what, patience = PATIENCE) {
  for (const end = Date.now() + patience; ;) {
    const value = await condition();
    if (value) return value;
    assert.ok(Date.now() < end, `not within ${patience} ms: ${what}`);
    await wait(10);
  }
}

export class House {
  static async open({ flags = [] } = {}) {
    const house = new House();
    house.folder = mkdtempSync(join(tmpdir(), 'burnish-web-'));
    const ports = join(house.folder, 'ports.json');
    house.server = spawn(process.env.BURNISHD, ['--grpc-listen', '127.0.0.1:0', '--http-listen', '127.0.0.1:0', '--ports-file', ports,
      '--store', join(house.folder, 'store'), ...flags], { stdio: ['ignore', 'ignore', 'pipe'] });
    house.log = '';
    house.server.stderr.on('data', (text) => { house.log += text; });
    await eventually(() => existsSync(ports) || house.server.exitCode !== null, 'burnishd serves');
    assert.equal(house.server.exitCode, null, house.log);
    const addresses = JSON.parse(readFileSync(ports));
    house.grpc = addresses.grpc;
    house.url = `http://${addresses.http}`;
    house.browser = await chromium.launch({ executablePath: process.env.CHROMIUM, headless: true, args: FLAGS });
    return house;
  }

  /** A page in a context of its own. */
  async visit({ width = 1280, height = 800, dark = false, touch = false, reducedMotion = 'reduce', path = '/' } = {}) {
    const context = await this.browser.newContext({
      viewport: { width, height }, colorScheme: dark ? 'dark' : 'light', reducedMotion, hasTouch: touch, isMobile: touch,
      deviceScaleFactor: touch ? 2 : 1, acceptDownloads: true,
    });
    context.setDefaultTimeout(PATIENCE);
    const page = await context.newPage();
    page.wrongs = [];
    page.on('pageerror', (error) => page.wrongs.push(`error: ${error.message}`));
    page.on('console', (message) => {
      // The browser itself words a refused call; the page shows its sentence.
      if (['error', 'warning'].includes(message.type()) && !/Failed to load resource|GPU stall|GL Driver Message/.test(message.text())) {
        page.wrongs.push(`console: ${message.text()}`);
      }
    });
    page.on('request', (request) => {
      const url = new URL(request.url());
      if (url.origin !== this.url && !['blob:', 'data:'].includes(url.protocol)) page.wrongs.push(`asks elsewhere: ${request.url()}`);
    });
    await context.addInitScript(() => {
      document.addEventListener('securitypolicyviolation', (event) => console.error(`policy: ${event.violatedDirective} ${event.blockedURI}`));
    });
    await page.goto(this.url + path);
    await page.waitForSelector('#method option', { state: 'attached' });
    await page.waitForSelector('#view canvas');
    return page;
  }

  /** Writes a file for a page to choose. */
  file(name, content) {
    const path = join(this.folder, name);
    writeFileSync(path, content);
    return path;
  }

  async metric(name) {
    const text = await (await fetch(`${this.url}/metrics`)).text();
    return text.split('\n').filter((line) => line.startsWith(name)).reduce((sum, line) => sum + Number(line.split(' ').at(-1)), 0);
  }

  async close() {
    await this.browser.close();
    this.server.kill('SIGTERM');
    if (this.server.exitCode === null) await once(this.server, 'exit');
    rmSync(this.folder, { recursive: true, force: true });
    assert.equal(this.server.exitCode, 0, this.log);
  }
}

/** Chooses a file and waits until it is shown. */
export async function choose(page, path, input = '#file') {
  await page.setInputFiles(input, path);
  const name = path.split('/').at(-1);
  await page.waitForFunction(([id, words]) => document.getElementById(id).textContent === words, [input === '#file' ? 'mesh-name' : 'reference-name', name]);
  await drawn(page);
}

export async function takeSample(page, kind = 'machined') {
  await page.selectOption('#sample', kind);
  await page.waitForFunction((name) => document.getElementById('reference-name').textContent === name, `${kind}-clean.obj`);
  await drawn(page);
}

/** Smooths and waits for the result, or for the sentence that says why there is none. */
export async function smooth(page) {
  const last = () => page.evaluate(() => document.querySelector('#runs-table tbody tr:last-child button')?.textContent ?? '');
  const before = await last();
  await page.click('#smooth');
  await page.waitForFunction((was) => !document.getElementById('alert').hidden ||
    (document.querySelector('#runs-table tbody tr:last-child button')?.textContent ?? '') !== was, before);
  assert.equal(await page.locator('#alert').isVisible() ? await page.locator('#alert p').textContent() : '', '');
  await drawn(page);
}

/** Until the last picture has been on the screen for a moment. */
export async function drawn(page) {
  await page.waitForSelector('#view canvas');
  await page.evaluate(async () => {
    const canvas = document.querySelector('#view canvas');
    for (let same = 0, last; same < 3;) {
      await new Promise((done) => requestAnimationFrame(() => setTimeout(done, 30)));
      same = canvas.dataset.pictures === last ? same + 1 : 0;
      last = canvas.dataset.pictures;
    }
  });
}

export async function screenshot(page, name) {
  mkdirSync(process.env.SCREENSHOTS, { recursive: true });
  return page.screenshot({ path: join(process.env.SCREENSHOTS, `${name}.png`) });
}
