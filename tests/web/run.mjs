// Runs one file of browser tests: node run.mjs NAME. Ends with 77, which ctest takes for skipped, where npm packages or Chromium are missing.
import { existsSync } from 'node:fs';

const skip = (why) => {
  console.log(`skipped: ${why}`);
  process.exit(77);
};
if (!existsSync(new URL('node_modules/installed.json', import.meta.url))) skip('scripts/setup found no npm registry');
if (!process.env.CHROMIUM || !existsSync(process.env.CHROMIUM)) skip('there is no Chromium; scripts/setup installs it');
if (process.env.BURNISH_PAGE !== 'ON') skip('burnishd was built without its page');
await import(new URL(`${process.argv[2]}.test.mjs`, import.meta.url));
