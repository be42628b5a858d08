// First paint, readiness, and live updates on loopback.
import assert from 'node:assert/strict';
import { mkdtemp, writeFile } from 'node:fs/promises';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, test } from 'node:test';
import { done, drop, endBrowser, open, P885, serve } from './browser.mjs';

after(endBrowser);

/** In the page: when the list of records can be pressed. */
function noteFirstRecord() {
  new MutationObserver(() => {
    if (document.querySelector('button.chip')) window.firstRecord ??= performance.now();
  }).observe(document, { childList: true, subtree: true });
}

test('first paint and readiness', async () => {
  const server = await serve([P885]);
  try {
    const paints = [];
    const ready = [];
    for (let i = 0; i < 5; i++) {
      const page = await open(server.url, { before: noteFirstRecord });
      await page.waitForSelector('.chip');
      ready.push(await page.evaluate(() => window.firstRecord));
      paints.push(
        await page.evaluate(
          () => performance.getEntriesByName('first-contentful-paint')[0]?.startTime ?? NaN,
        ),
      );
      await done(page);
    }
    const middle = (list) => [...list].sort((a, b) => a - b)[2];
    console.log(
      `first contentful paint ${middle(paints).toFixed(0)} ms, list there ${middle(ready).toFixed(0)} ms`,
    );
    assert.ok(middle(paints) < 300, `first paint ${paints}`);
    assert.ok(middle(ready) < 500, `ready ${ready}`);
  } finally {
    await server.close();
  }
});

test('a record of 1e6 samples', async () => {
  const folder = await mkdtemp(join(tmpdir(), 'hysteron-long-'));
  const rows = Array.from({ length: 1_000_000 }, (_, i) => {
    const phase = (i / 10_000) * 2 * Math.PI;
    const [u, y] = [5 - 5 * Math.cos(phase), 8 - 8 * Math.cos(phase - 0.1)];
    return `${(i / 10_000).toFixed(4)},${u.toFixed(4)},${y.toFixed(4)}`;
  });
  await writeFile(join(folder, 'long.csv'), `t_s,u_V,y_um\n${rows.join('\n')}\n`);
  const server = await serve();
  const page = await open(server.url);
  try {
    const began = Date.now();
    await drop(page, join(folder, 'long.csv'));
    await page.waitForSelector('.plot canvas', { timeout: 60_000 });
    console.log(`1e6 samples: first figure ${Date.now() - began} ms after the drop`);
    const zoomed = Date.now();
    await page.evaluate(() => (location.hash += '&z.t=10_11'));
    await page.waitForTimeout(50);
    await page.waitForLoadState('networkidle');
    console.log(`1e6 samples: zoom answered after ${Date.now() - zoomed} ms`);
    assert.deepEqual(page.faults, []);
  } finally {
    await done(page);
    await server.close();
  }
});
