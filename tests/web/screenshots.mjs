// The pictures of the page in the documentation: node screenshots.mjs FOLDER, with the environment of the tests. scripts/pictures calls it.
import { execFileSync } from 'node:child_process';
import { mkdirSync, statSync } from 'node:fs';
import { join } from 'node:path';
import { House, drawn, smooth, takeSample } from './house.mjs';

const MOST = 200_000; // bytes of a picture
const folder = process.argv[2];
mkdirSync(folder, { recursive: true });

async function picture(page, name) {
  await drawn(page);
  await page.evaluate(() => document.activeElement?.blur());
  const path = join(folder, `${name}.png`);
  await page.screenshot({ path, scale: 'css' });
  execFileSync('pngquant', ['--force', '--speed', '1', '--strip', '--output', path, '192', path]);
  if (statSync(path).size > MOST) throw new Error(`${path} has more than ${MOST} bytes`);
}

const house = await House.open();
try {
  for (const dark of [false, true]) {
    const theme = dark ? 'dark' : 'light';
    const desk = await house.visit({ width: 1120, height: 700, dark });
    await takeSample(desk, dark ? 'knot' : 'machined');
    await smooth(desk);
    if (dark) {
      await desk.selectOption('#look', 'distance');
      await desk.waitForSelector('#legend', { state: 'visible' });
    }
    await picture(desk, `page-desktop-${theme}`);
    const phone = await house.visit({ width: 390, height: 780, touch: true, dark });
    await takeSample(phone, dark ? 'machined' : 'knot');
    await smooth(phone);
    await phone.evaluate(() => scrollTo(0, 0));
    await phone.evaluate(() => scrollTo(0, 0));
    await picture(phone, `page-phone-${theme}`);
  }
} finally {
  await house.close();
}
