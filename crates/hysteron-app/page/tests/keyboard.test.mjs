// Keyboard alone: rooms, records, a figure, a fit; and what a link carries.
import assert from 'node:assert/strict';
import { join } from 'node:path';
import { after, test } from 'node:test';
import { done, endBrowser, EXAMPLES, identified, open, P885, serve } from './browser.mjs';

after(endBrowser);

async function tabTo(page, selector, most = 80) {
  for (let i = 0; i < most; i++) {
    if (await page.evaluate((s) => document.activeElement?.matches(s), selector)) return;
    await page.keyboard.press('Tab');
  }
  assert.fail(`${selector} is not reached by Tab`);
}

test('without a mouse from record to model', async () => {
  const server = await serve([P885], { scanner: join(EXAMPLES, 'afm-z-scanner', 'cycle_1_300hz_01.csv') });
  const page = await open(server.url);
  try {
    await page.waitForSelector('.plot canvas');
    const first = await page.textContent('.rhead h2');
    await page.keyboard.press('j');
    await page.waitForFunction((name) => document.querySelector('.rhead h2')?.textContent !== name, first);
    await page.keyboard.press('k');
    await page.waitForFunction((name) => document.querySelector('.rhead h2')?.textContent === name, first);

    await tabTo(page, '.pc');
    await page.keyboard.press('ArrowRight');
    await page.keyboard.press('ArrowRight');
    const reading = await page.textContent('.pc:focus .ro');
    assert.match(reading, /V|s/);
    await page.keyboard.press('+');
    await page.waitForFunction(() => /[?&]z\./.test(location.hash));
    await page.keyboard.press('0');
    await page.waitForFunction(() => !/[?&]z\./.test(location.hash));

    await page.keyboard.press('2');
    await page.waitForSelector('h1:text("Identify")');
    assert.equal(await page.evaluate(() => document.activeElement?.tagName), 'H1');
    await tabTo(page, 'button.primary');
    await page.keyboard.press('Enter');
    await identified(page);
    await page.keyboard.press('6');
    await page.waitForSelector('h1:text("Take it home")');
    assert.deepEqual(page.faults, []);
  } finally {
    await done(page);
    await server.close();
  }
});

test('a link shows the same view', async () => {
  const server = await serve([P885]);
  const page = await open(`${server.url}#/records?r=identification_1hz.csv&z.t=2_4&theme=dark&lang=python`);
  try {
    await page.waitForSelector('.plot canvas');
    assert.equal(await page.getAttribute('html', 'data-theme'), 'dark');
    await page.waitForSelector('.echo button[aria-pressed="true"]:text("Python")');
    await page.keyboard.press('2');
    await page.waitForSelector('h1:text("Identify")');
    assert.match(page.url(), /theme=dark/);
    await page.goBack();
    await page.waitForSelector('h1:text("Records")');
    assert.match(page.url(), /z\.t=2_4/);
    assert.deepEqual(page.faults, []);
  } finally {
    await done(page);
    await server.close();
  }
});
