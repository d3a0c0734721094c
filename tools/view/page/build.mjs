// SPDX-License-Identifier: LGPL-2.1-or-later
// Bundles the page: node build.mjs OUT writes index.html, app.js, app.css and licences.txt into OUT.
import { build } from 'esbuild';
import { copyFile, mkdir, readFile, writeFile } from 'node:fs/promises';
import { dirname, join, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';

const here = dirname(fileURLToPath(import.meta.url));
if (process.argv.length !== 3) {
  console.error('Usage: node build.mjs OUT (the folder to write into)');
  process.exit(2);
}
const out = resolve(process.argv[2]);

// Names relative to this folder, so that the bytes do not depend on where it is.
const common = { absWorkingDir: here, bundle: true, minify: true, legalComments: 'none', logLevel: 'warning' };
await mkdir(out, { recursive: true });
await build({
  ...common, entryPoints: ['src/main.js'], outfile: join(out, 'app.js'), format: 'iife', target: 'es2022', charset: 'utf8', loader: { '.html': 'text' },
  banner: { js: '// The page of stroma view; with three.js and uPlot: see licences.txt' },
});
// The page is also written into one file, inside an element "script": nothing in it may look like a comment of HTML.
const script = join(out, 'app.js');
await writeFile(script, (await readFile(script, 'utf8')).replaceAll('<!--', '<\\!--'));
await build({ ...common, entryPoints: ['styles/app.css'], outfile: join(out, 'app.css'), charset: 'utf8' });
await copyFile(join(here, 'index.html'), join(out, 'index.html'));

const licences = ['What the page of stroma view contains besides its own code (LGPL-2.1-or-later):\n'];
for (const name of ['three', 'uplot']) {
  const folder = join(here, 'node_modules', name);
  const { version } = JSON.parse(await readFile(join(folder, 'package.json'), 'utf8'));
  licences.push(`${'='.repeat(80)}\n${name} ${version}\n\n${(await readFile(join(folder, 'LICENSE'), 'utf8')).trim()}\n`);
}
await writeFile(join(out, 'licences.txt'), licences.join('\n'));
