// What strangers stumbled over: the chain of a new folder, many records, links to what is gone, fits that fail
// at once, drives that were taken for measurements.
import assert from 'node:assert/strict';
import { writeFile } from 'node:fs/promises';
import { join } from 'node:path';
import { after, test } from 'node:test';
import { done, endBrowser, identified, open, P885, picture, serve } from './browser.mjs';

after(endBrowser);

/** A loop of this many samples a period, or a constant drive. */
function loop(gain, constant = false) {
  const rows = Array.from({ length: 120 }, (_, k) => {
    const phase = (2 * Math.PI * k) / 60;
    const u = constant ? 3 : 5 - 5 * Math.cos(phase);
    return `${(k / 60).toFixed(5)},${u.toFixed(5)},${(gain * (5 - 5 * Math.cos(phase - 0.1))).toFixed(5)}`;
  });
  return `t_s,u_V,y_um\n${rows.join('\n')}\n`;
}

test('the whole chain in a new folder', async () => {
  const server = await serve();
  const page = await open(`${server.url}#/try`);
  try {
    await page.getByRole('button', { name: 'Run the whole chain' }).click();
    const size = page.getByText(/\d+ files, .*B/).first();
    await size.waitFor({ timeout: 240_000 });
    const jobs = await (await fetch(`${server.url}api/v1/jobs`)).json();
    assert.equal(jobs[0].request.records.length, 2, 'the loop and the sweep');
    await picture(page, 'chain');
    assert.deepEqual(page.faults, []);
  } finally {
    await done(page);
    await server.close();
  }
});

test('seventy records, one after the other', async () => {
  const server = await serve();
  for (let k = 0; k < 70; k++)
    await writeFile(join(server.folder, `r${String(k).padStart(2, '0')}.csv`), loop(1 + k / 100));
  const page = await open(`${server.url}#/records`);
  try {
    for (const k of [3, 8, 15, 22, 30, 37, 44, 51, 58, 69]) {
      await page.locator('.chip', { hasText: `r${String(k).padStart(2, '0')}.csv` }).click();
      await page.waitForSelector('.g-facts .facts, .g-facts dl', { timeout: 30_000 });
      await page.getByText('determine', { exact: false }).first().waitFor({ timeout: 30_000 });
      await page.locator('.plot canvas').first().waitFor({ timeout: 30_000 });
    }
    assert.deepEqual(page.faults, []);
  } finally {
    await done(page);
    await server.close();
  }
});

test('a link to a model that is gone says so', async () => {
  const server = await serve([P885]);
  const page = await open(`${server.url}#/identify`);
  try {
    await page.click('button.primary');
    await identified(page);
    await page.goto(`${server.url}#/follow?m=gone.json`);
    await page.getByText('gone.json').first().waitFor();
    await page.getByRole('button', { name: 'Show what is there' }).click();
    await page.waitForFunction(() => !location.hash.includes('gone'));
    await page.goto(`${server.url}#/nonsense`);
    await page.waitForFunction(() => location.hash.startsWith('#/records'));
  } finally {
    await done(page);
    await server.close();
  }
});

test('the drive that was downloaded is no record of a fit', async () => {
  const server = await serve([P885]);
  const page = await open(`${server.url}#/identify`);
  try {
    await page.click('button.primary');
    await identified(page);
    await page.goto(`${server.url}#/follow`);
    const button = page.getByRole('button', { name: 'Download the drive' });
    await Promise.all([page.waitForEvent('download', { timeout: 60_000 }), button.click()]);
    const records = await (await fetch(`${server.url}api/v1/records`)).json();
    const role = (end) => records.find((record) => record.id.endsWith(end))?.settings.role;
    assert.equal(role('drive.csv'), 'unused');
    assert.equal(role('drive-reference.csv'), 'reference');
  } finally {
    await done(page);
    await server.close();
  }
});

test('a fit that fails at once is not said to wait', async () => {
  const server = await serve();
  await writeFile(join(server.folder, 'constant.csv'), loop(1, true));
  await writeFile(join(server.folder, 'good.csv'), loop(1));
  const page = await open(`${server.url}#/identify`);
  try {
    // The page itself leaves the constant one out; another client does not.
    const job = await fetch(`${server.url}api/v1/jobs`, {
      method: 'POST',
      headers: { 'Content-Type': 'application/json' },
      body: JSON.stringify({ kind: 'identify', records: ['constant.csv', 'good.csv'] }),
    });
    const { id } = await job.json();
    await page.goto(`${server.url}#/identify?job=${id}`);
    await page.locator('.find.bad', { hasText: 'constant' }).waitFor({ timeout: 20_000 });
    assert.equal(await page.getByText('Waits:').count(), 0);
    await page.goto(`${server.url}#/identify?new=1`);
    await page.getByRole('button', { name: 'Identify from 1 record' }).waitFor({ timeout: 20_000 });
  } finally {
    await done(page);
    await server.close();
  }
});

test('the device is chosen where there are several', async () => {
  const server = await serve([], { one: P885, two: P885 });
  const page = await open(`${server.url}#/identify`);
  try {
    await page.waitForSelector('select[aria-label="Device"]', { timeout: 20_000 });
    await page.selectOption('select[aria-label="Device"]', 'two');
    await page.waitForFunction(() => location.hash.includes('device=two'));
    await page.click('button.primary:has-text("Identify from 1 record")');
    await identified(page);
    const models = await (await fetch(`${server.url}api/v1/models`)).json();
    assert.deepEqual(
      models.map((model) => model.device),
      ['two'],
    );
    assert.deepEqual(page.faults, []);
  } finally {
    await done(page);
    await server.close();
  }
});
