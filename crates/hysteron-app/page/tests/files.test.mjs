// Files that are no records, and records whose names are markup.
import assert from 'node:assert/strict';
import { mkdtemp, writeFile } from 'node:fs/promises';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, test } from 'node:test';
import { done, drop, endBrowser, open, serve } from './browser.mjs';

after(endBrowser);

const rows = (n, line) => Array.from({ length: n }, (_, i) => line(i)).join('\n');
const BAD = {
  'empty.csv': '',
  'header_only.csv': 't_s,u_V,y_um\n',
  'one_row.csv': 't_s,u_V,y_um\n0,1,2\n',
  'word.csv': `t_s,u_V,y_um\n${rows(20, (i) => `${i / 10},${i === 5 ? 'nope' : i},${i}`)}\n`,
  'ragged.csv': `t_s,u_V,y_um\n${rows(20, (i) => (i === 7 ? `${i},1` : `${i},1,${i}`))}\n`,
  'binary.csv': Buffer.from(Array.from({ length: 400 }, (_, i) => (i * 73) % 256)),
  'picture.png': Buffer.from('89504e470d0a1a0a0000000d49484452', 'hex'),
  'archive.zip': Buffer.from('504b0304140000000000', 'hex'),
  'text.txt': 'dear diary, nothing was measured today\n',
  'page.html': '<!doctype html><p>no record</p>\n',
  'broken.mat': Buffer.from('MATLAB 5.0 MAT-file, and then nothing'),
  'broken.npz': Buffer.from('504b03041400', 'hex'),
  'broken.h5': Buffer.from('894844460d0a1a0a00', 'hex'),
  'broken.tdms': Buffer.from('5444536d0e000000', 'hex'),
  'nan.csv': `t_s,u_V,y_um\n${rows(20, (i) => `${i},NaN,NaN`)}\n`,
  'infinite.csv': `t_s,u_V,y_um\n${rows(20, (i) => `${i},inf,1e999`)}\n`,
  'backwards.csv': `t_s,u_V,y_um\n${rows(20, (i) => `${20 - i},${i},${i}`)}\n`,
  'same_names.csv': `u_V,u_V,y_um\n${rows(20, (i) => `${i},${i},${i}`)}\n`,
  'one_column.csv': `u_V\n${rows(20, (i) => i)}\n`,
  'commas.csv': `t;u;y\n${rows(20, (i) => `0,${i};zwei;${i}`)}\n`,
};

async function written(files) {
  const folder = await mkdtemp(join(tmpdir(), 'hysteron-bad-'));
  for (const [name, content] of Object.entries(files)) await writeFile(join(folder, name), content);
  return folder;
}

test('twenty bad files, each with a message that can be read', async () => {
  const folder = await written(BAD);
  const server = await serve();
  const page = await open(server.url, { refusals: true });
  try {
    const messages = {};
    for (const name of Object.keys(BAD)) {
      await drop(page, join(folder, name));
      await page.waitForSelector(`main h2.mono:text-is("${name}")`, { timeout: 10_000 });
      const message = await page.waitForSelector('main .find.bad, main .find.warn', { timeout: 10_000 });
      messages[name] = (await message.textContent()).trim();
      assert.ok(messages[name].length > 20, `${name}: ${messages[name]}`);
      assert.doesNotMatch(messages[name], /undefined|\[object|panicked|answered 5/);
    }
    console.log(
      Object.entries(messages)
        .map(([name, text]) => `${name}: ${text.slice(0, 160)}`)
        .join('\n'),
    );
    assert.deepEqual(page.faults, []);
  } finally {
    await done(page);
    await server.close();
  }
});

test('a record whose names are markup stays text', async () => {
  const name = '<img src=x onerror=window.hit=1>.csv'.replace('/', '');
  const column = '<script>window.hit=2</script>_V';
  const wave = (i) => [i / 100, Math.sin(i / 16), Math.sin(i / 16 - 0.2)].join();
  const folder = await written({
    [name]: `t_s,${column},y_um\n${rows(400, wave)}\n`,
  });
  const server = await serve();
  const page = await open(server.url);
  try {
    await drop(page, join(folder, name));
    await page.waitForSelector('.chip');
    await page.waitForSelector('.rhead');
    await page.waitForTimeout(500);
    assert.equal(await page.evaluate('window.hit'), undefined);
    assert.equal(await page.locator('main img').count(), 0);
    assert.match(await page.textContent('.rhead'), /<img src=x/);
    assert.deepEqual(page.faults, []);
  } finally {
    await done(page);
    await server.close();
  }
});
