// A newcomer: an empty folder, a file dropped, a model, its scores, and the code in the download folder.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdtemp, readdir, stat } from 'node:fs/promises';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, test } from 'node:test';
import { done, drop, EXAMPLES, endBrowser, identified, open, P885, picture, serve } from './browser.mjs';

after(endBrowser);

test('from an empty folder to C code that compiles', async () => {
  const server = await serve();
  const page = await open(server.url);
  try {
    await page.waitForSelector('.drop.big');
    await picture(page, 'records-empty');
    const began = Date.now();
    await drop(page, P885);
    await page.waitForSelector('.plot canvas');
    await page.waitForSelector('text=What this record determines');
    console.log(`record visible ${Date.now() - began} ms after the drop`);
    assert.match(await page.textContent('.rhead'), /8\D?027 samples at 200 Hz/);
    await picture(page, 'newcomer-records');

    await page.click('a.primary');
    await page.waitForSelector('h1:text("Identify")');
    await page.click('button.primary');
    await identified(page);
    assert.match(page.url(), /m=/);
    await picture(page, 'newcomer-identify');

    await page.keyboard.press('4');
    await page.waitForSelector('text=Every record was used for the fit');
    await page.selectOption('select[aria-label="Add a record to validate on"]', { index: 1 });
    await page.waitForSelector('table >> text=of the fit');
    await picture(page, 'newcomer-validate');

    await page.keyboard.press('6');
    await page.waitForSelector('a.primary:has-text("Download C99")');
    await page.waitForSelector('pre.code');
    const [download] = await Promise.all([page.waitForEvent('download'), page.click('a.primary')]);
    const folder = await mkdtemp(join(tmpdir(), 'hysteron-c-'));
    const archive = join(folder, 'code.zip');
    await download.saveAs(archive);
    assert.ok((await stat(archive)).size > 1000);
    execFileSync('python3', ['-m', 'zipfile', '-e', archive, folder]);
    const files = (await readdir(folder, { recursive: true })).filter((name) => name.endsWith('.c'));
    assert.ok(files.length > 0, 'C files in the archive');
    for (const file of files) {
      execFileSync('cc', ['-std=c99', '-Wall', '-c', join(folder, file), '-o', join(folder, 'out.o')], {
        cwd: folder,
      });
    }
    assert.deepEqual(page.faults, []);
  } finally {
    await done(page);
    await server.close();
  }
});

test('several files at once, parts of a run joined by the select', async () => {
  const server = await serve();
  const page = await open(server.url);
  try {
    await page.waitForSelector('.drop.big');
    const scanner = join(EXAMPLES, 'afm-z-scanner');
    await drop(page, ...['01', '02', '03'].map((n) => join(scanner, `cycle_1_300hz_${n}.csv`)));
    await page.waitForFunction(() => document.querySelectorAll('button.chip').length === 3);
    await page.click('.chip:has-text("cycle_1_300hz_02")');
    await page.waitForSelector('.rhead h2:has-text("cycle_1_300hz_02")');
    await page.locator('label:has-text("continues") select').selectOption('cycle_1_300hz_01.csv');
    await page.waitForSelector('.chip.cont:has-text("cycle_1_300hz_02")');
    await page.reload();
    await page.waitForSelector('.chip.cont:has-text("cycle_1_300hz_02")');
    assert.deepEqual(page.faults, []);
  } finally {
    await done(page);
    await server.close();
  }
});
