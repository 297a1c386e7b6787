import { defineConfig } from 'vite';

export default defineConfig({
  // Everything is a file of its own with its hash in its name: the server's policy allows no inline code.
  build: { target: 'es2022', assetsInlineLimit: 0, modulePreload: { polyfill: false }, chunkSizeWarningLimit: 1500 },
  worker: { format: 'es' },
});
