// Builds the page into dist/, or with --check says whether dist/ is what the sources make.
import { build } from 'esbuild';
import { readFile, writeFile, mkdir } from 'node:fs/promises';
import { gzipSync } from 'node:zlib';
import { fileURLToPath } from 'node:url';
import { join } from 'node:path';

const root = fileURLToPath(new URL('.', import.meta.url));
const result = await build({
  absWorkingDir: root,
  entryPoints: { app: 'src/main.tsx' },
  outdir: 'dist',
  bundle: true,
  minify: true,
  format: 'esm',
  target: 'es2022',
  charset: 'utf8',
  jsx: 'automatic',
  jsxImportSource: 'preact',
  legalComments: 'inline',
  write: false,
});
const files = result.outputFiles.map((file) => [
  file.path.slice(file.path.lastIndexOf('/') + 1),
  file.contents,
]);
for (const name of ['index.html', 'icon.svg']) files.push([name, await readFile(join(root, 'src', name))]);

if (process.argv.includes('--check')) {
  for (const [name, contents] of files) {
    const kept = await readFile(join(root, 'dist', name)).catch(() => Buffer.alloc(0));
    if (!kept.equals(contents)) {
      console.error(`dist/${name} is not what the sources make; try: make page`);
      process.exitCode = 1;
    }
  }
} else {
  await mkdir(join(root, 'dist'), { recursive: true });
  for (const [name, contents] of files) {
    await writeFile(join(root, 'dist', name), contents);
    console.log(`${name.padEnd(12)} ${contents.length} bytes, ${gzipSync(contents).length} compressed`);
  }
}
