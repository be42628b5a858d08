// Fits that are stopped, resumed, watched from two pages, and interrupted by the end of the server.
import assert from 'node:assert/strict';
import { join } from 'node:path';
import { after, test } from 'node:test';
import { done, EXAMPLES, endBrowser, identified, open, P885, picture, serve } from './browser.mjs';

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

test('a killed comparison goes on with the structures that are left', async () => {
  const server = await serve();
  const page = await open(`${server.url}#/records`);
  try {
    const plan = { sample_rate_hz: 500, loop_periods: 2, sweep_end_hz: 20, sweep_s: 3, validation_hz: [5] };
    const ask = async (method, at, body) => {
      const headers = { 'Content-Type': 'application/json' };
      const sent = body && { headers, body: JSON.stringify(body) };
      const answer = await fetch(`${server.url}api/v1/${at}`, { method, ...sent });
      assert.ok(answer.ok, await answer.clone().text());
      return answer.json();
    };
    const made = await ask('POST', 'bench', { plan: { ...plan, validation_s: 1 }, seed: 3 });
    const candidates = ['none+degree1', 'none+degree2', 'integer1+degree1', 'integer2+degree2'];
    const job = await ask('POST', 'jobs', { kind: 'compare', records: made.records, candidates });
    await page.goto(`${server.url}#/compare?job=${job.id}`);
    await page.waitForSelector('button.stop:has-text("keep what is finished")', { timeout: 60_000 });
    await server.kill('SIGKILL');
    await page.waitForSelector('text=no connection');
    await server.restart();
    await page.waitForSelector('button:has-text("Go on")', { timeout: 20_000 });
    const killed = (await ask('GET', `jobs/${job.id}`)).result.candidates.length;
    assert.ok(killed >= 1 && killed < candidates.length, `${killed} structures`);
    await picture(page, 'compare-interrupted');
    await page.click('main button:has-text("Go on")');
    await page.waitForSelector('button.primary:has-text("Take")', { timeout: 120_000 });
    const ended = await ask('GET', `jobs/${job.id}`);
    assert.equal(ended.result.comparison.candidates.length, candidates.length);
  } finally {
    await done(page);
    await server.close();
  }
});

test('controllers that are simulated tell the time left and can be stopped', async () => {
  const server = await serve([P885]);
  const page = await open(`${server.url}#/identify`);
  try {
    await page.click('button.primary');
    await identified(page);
    await page.goto(`${server.url}#/follow`);
    await page.click('button:has-text("Simulate the controllers")', { timeout: 60_000 });
    await page.waitForSelector('[role=group][aria-label="Controllers"]:has-text("left")', {
      timeout: 60_000,
    });
    await picture(page, 'follow-working');
    await page.click('[role=group][aria-label="Controllers"] button:has-text("Stop")');
    await page.waitForSelector('text=It was stopped.');
    await page.waitForSelector('button:has-text("Simulate the controllers")');
    assert.deepEqual(page.faults, []);
  } finally {
    await done(page);
    await server.close();
  }
});
