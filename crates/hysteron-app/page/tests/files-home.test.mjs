// What is taken home: a drive, the model file, the report; and from an example in one click.
import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { after, test } from 'node:test';
import { done, endBrowser, identified, open, picture, serve } from './browser.mjs';

after(endBrowser);

async function downloaded(page, act) {
  const [download] = await Promise.all([page.waitForEvent('download'), act()]);
  return { name: download.suggestedFilename(), text: await readFile(await download.path(), 'utf8') };
}

test('an example in one click, its drive, its model file and its report', async () => {
  const server = await serve();
  const page = await open(`${server.url}#/try`);
  try {
    await page.click('.card:has-text("P-885") button');
    await page.waitForSelector('.plot canvas');
    await page.click('a.primary:has-text("Identify from 1 record")');
    await page.click('button.primary:has-text("Identify from 1 record")');
    await identified(page);

    await page.keyboard.press('5');
    await page.waitForSelector('text=Predicted error');
    const drive = await downloaded(page, () => page.click('button:has-text("Download the drive")'));
    assert.equal(drive.name, 'drive.csv');
    const rows = drive.text.trim().split('\n');
    assert.ok(rows.length > 100, `${rows.length} rows`);
    assert.ok(
      rows.slice(-20).every((row) => row.split(',').every((field) => Number.isFinite(Number(field)))),
    );
    await page.selectOption('label:has-text("Reference") select', { label: 'drawn by hand' });
    await page.waitForSelector('.pad');
    await page.click('.pad', { position: { x: 300, y: 60 } });
    await page.waitForFunction(() => document.querySelectorAll('.pad .dot').length === 4);
    await page.waitForSelector('text=Predicted error');
    await picture(page, 'follow-drawn');

    await page.keyboard.press('6');
    await page.waitForSelector('a.primary:has-text("Download C99")');
    await page.click('label:has-text("Model file")');
    await page.waitForSelector('a.primary:has-text("Download Model file")');
    const model = await downloaded(page, () => page.click('a.primary'));
    assert.equal(JSON.parse(model.text).kind, 'hammerstein');
    await page.click('label:has-text("Report")');
    await page.waitForSelector('a.primary:has-text("Download Report")');
    const report = await downloaded(page, () => page.click('a.primary'));
    assert.match(report.text, /<h1/);
    assert.match(await page.textContent('pre[aria-label^="Script"]'), /hysteron identify/);
    assert.deepEqual(page.faults, []);
  } finally {
    await done(page);
    await server.close();
  }
});
