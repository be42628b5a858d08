// The report of a fit in the browser: its tables and figures are taken along, its contents stay, it has a dark side.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { readFile } from 'node:fs/promises';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { COMMAND, done, endBrowser, open, P885, picture, serve } from './browser.mjs';

let server;

before(async () => {
  server = await serve([P885]);
  const model = ['identify', 'identification_1hz.csv', '-o', 'model.json', '--report', 'model.html'];
  execFileSync(COMMAND, model, { cwd: server.folder, stdio: 'pipe' });
});

after(async () => {
  await server?.close();
  await endBrowser();
});

const report = (options) => open(`${server.url}api/v1/reports/model.html`, options);

async function saved(page, button) {
  const [download] = await Promise.all([page.waitForEvent('download'), page.click(button)]);
  return { name: download.suggestedFilename(), bytes: await readFile(await download.path()) };
}

test('a table is copied as CSV', async () => {
  // The copy goes to the clipboard of the test.
  const before = () => {
    Object.defineProperty(navigator, 'clipboard', {
      value: { writeText: (text) => Promise.resolve(void (window.copied = text)) },
    });
  };
  const page = await report({ before });
  try {
    const tables = await page.locator('[data-csv]').count();
    assert.ok(tables > 2, `${tables} tables`);
    await page.locator('button:has-text("Copy as CSV")').first().click();
    await page.waitForSelector('button:has-text("Copied")');
    const rows = (await page.evaluate(() => window.copied)).trim().split(/\r?\n/);
    const shown = await page.locator('[data-csv]').first().locator('tbody tr').count();
    assert.equal(rows.length, shown + 1, rows.join('\n'));
    assert.deepEqual(page.faults, []);
  } finally {
    await done(page);
  }
});

test('a figure is saved as PNG and SVG', async () => {
  const page = await report();
  try {
    const png = await saved(page, 'button:has-text("Save as PNG") >> nth=0');
    assert.match(png.name, /\.png$/);
    assert.deepEqual([...png.bytes.subarray(1, 4)].map((c) => String.fromCharCode(c)).join(''), 'PNG');
    // Twice the size of the drawing.
    assert.ok(png.bytes.readUInt32BE(16) > 800, `${png.bytes.readUInt32BE(16)} pixels wide`);
    const svg = await saved(page, 'figure button:text-is("SVG") >> nth=0');
    assert.match(svg.name, /\.svg$/);
    const text = svg.bytes.toString('utf8');
    assert.match(text, /^<svg[^>]*xmlns="http:\/\/www.w3.org\/2000\/svg"/);
    assert.match(text, /<path/);
    assert.deepEqual(page.faults, []);
  } finally {
    await done(page);
  }
});

test('the contents stay in sight and mark the section', async () => {
  const page = await report({ width: 1440 });
  try {
    const marked = () => page.textContent('nav.side a[aria-current]');
    const first = await marked();
    await page.evaluate(() => scrollTo(0, document.documentElement.scrollHeight));
    await page.waitForFunction(
      (before) => document.querySelector('nav.side a[aria-current]').textContent !== before,
      first,
    );
    const box = await page.locator('nav.side').boundingBox();
    assert.ok(box.y >= -1 && box.y < 100, `the contents stand at ${box.y}`);
    await page.click('nav.side a >> nth=0');
    await page.waitForFunction(() => scrollY < 2000);
    assert.deepEqual(page.faults, []);
  } finally {
    await done(page);
  }
});

test('it is dark where the system is', async () => {
  const luminance = async (theme) => {
    const page = await report({ theme });
    try {
      if (theme === 'dark') await picture(page, 'report-dark');
      assert.deepEqual(page.faults, []);
      const colour = await page.evaluate(() => getComputedStyle(document.body).backgroundColor);
      const html = await page.evaluate(() => getComputedStyle(document.documentElement).backgroundColor);
      const numbers = (/rgba?\(0, 0, 0, 0\)/.test(colour) ? html : colour).match(/\d+/g).slice(0, 3);
      return numbers.reduce((sum, number) => sum + Number(number), 0) / 3;
    } finally {
      await done(page);
    }
  };
  const [light, dark] = [await luminance('light'), await luminance('dark')];
  assert.ok(light > 220 && dark < 60, `light ${light}, dark ${dark}`);
  // The file itself needs no server.
  assert.match(await readFile(join(server.folder, 'model.html'), 'utf8'), /prefers-color-scheme/);
});
