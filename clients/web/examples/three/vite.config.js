// How the example is served: the page's own /v1 leads to a Swellcast server, so that no server need allow its origin.

import { defineConfig } from 'vite';

const target = process.env.SWELLCAST ?? 'http://127.0.0.1:8080';
const proxy = { '/v1': { target, ws: true } };

export default defineConfig({
  base: './',
  build: { target: 'es2022', chunkSizeWarningLimit: 1000 },
  resolve: { dedupe: ['three'] }, // the client lies in another folder, but draws with the three of this one
  server: { proxy },
  preview: { proxy },
});
