// Fits that are stopped, resumed, watched from two pages, and interrupted by the end of the server.
import assert from 'node:assert/strict';
import { join } from 'node:path';
import { after, test } from 'node:test';
import { done, EXAMPLES, endBrowser, open, picture, serve } from './browser.mjs';

after(endBrowser);

const SCANNER = ['01', '02', '03'].map((n) => join(EXAMPLES, 'afm-z-scanner', `cycle_1_300hz_${n}.csv`));

async function begun(page) {
  await page.click('button.primary:has-text("Identify from")');
  await page.waitForSelector('button.stop', { timeout: 20_000 });
}

test('stop keeps the best, and it goes on; two pages show the same', async () => {
  const server = await serve(SCANNER);
  const page = await open(`${server.url}#/identify`);
  const other = await open(`${server.url}#/identify`);
  try {
    await begun(page);
    await other.waitForSelector('button.stop');
    await page.waitForSelector('.stages li');
    await page.waitForTimeout(1500);
    await picture(page, 'identify-running');
    await page.keyboard.press('s');
    await page.waitForSelector('button.primary:has-text("Go on")', { timeout: 30_000 });
    await other.waitForSelector('.job button:has-text("Go on")', { timeout: 30_000 });
    await picture(page, 'identify-stopped');
    await page.click('button.primary:has-text("Go on")');
    await page.waitForSelector('button.stop');
    await page.keyboard.press('s');
    await page.waitForSelector('button.primary:has-text("Go on")', { timeout: 30_000 });
    assert.deepEqual(page.faults, []);
    assert.deepEqual(other.faults, []);
  } finally {
    await done(page);
    await done(other);
    await server.close();
  }
});

test('a killed server leaves an interrupted job that can go on', async () => {
  const server = await serve(SCANNER);
  const page = await open(`${server.url}#/identify`);
  try {
    await begun(page);
    await page.waitForSelector('.stages li');
    await page.waitForTimeout(1000);
    await server.kill('SIGKILL');
    await page.waitForSelector('text=no connection');
    await server.restart();
    await page.waitForSelector('text=no connection', { state: 'detached', timeout: 15_000 });
    await page.waitForSelector('.job:has-text("interrupted"), .job.run', { timeout: 15_000 });
    const job = await (await fetch(`${server.url}api/v1/jobs`)).json();
    assert.ok(['interrupted', 'running', 'waiting'].includes(job[0].state), job[0].state);
    const faults = page.faults.filter((fault) => !/ERR_(CONNECTION|INCOMPLETE|EMPTY|SOCKET)/.test(fault));
    assert.deepEqual(faults, []);
  } finally {
    await done(page);
    await server.close();
  }
});
