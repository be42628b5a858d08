// Records: zoom by mouse, mask by numbers, roles, deleting with undo.
import assert from 'node:assert/strict';
import { after, test } from 'node:test';
import { done, endBrowser, open, P885, picture, serve } from './browser.mjs';

after(endBrowser);

test('zoom, mask, cut, role, delete and undo', async () => {
  const server = await serve([P885]);
  const page = await open(server.url);
  try {
    await page.waitForSelector('.plot:has-text("Time") canvas');
    const area = await page.locator('.plot:has(h2:text-is("Time")) .u-over').boundingBox();
    const y = area.y + area.height / 2;
    const drag = async (from, to) => {
      await page.mouse.move(area.x + area.width * from, y);
      await page.mouse.down();
      await page.mouse.move(area.x + area.width * to, y, { steps: 5 });
      await page.mouse.up();
    };
    await drag(0.25, 0.5);
    await page.waitForFunction(() => /[?&]z\.t=/.test(location.hash));
    const [from, to] = new URL(page.url()).hash
      .match(/z\.t=([\d.]+)_([\d.]+)/)
      .slice(1)
      .map(Number);
    assert.ok(from > 9 && from < 11 && to > 19 && to < 21, `${from} ${to}`);
    await page.dblclick('.plot:has(h2:text-is("Time")) .u-over');
    await page.waitForFunction(() => !/[?&]z\.t=/.test(location.hash));

    await page.click('.plot:has(h2:text-is("Time")) button[aria-label^="Mask"]');
    await drag(0.5, 0.6);
    await page.waitForSelector('text=masked from');
    await page.waitForSelector('dt:text("Masked")');
    await picture(page, 'records-masked');
    await page.click('li:has-text("masked from") button');
    await page.waitForSelector('text=masked from', { state: 'detached' });

    await page.fill('.stretches label:has-text("from") input', '2');
    await page.fill('.stretches label:has-text("to") input', '12');
    await page.click('button:has-text("Keep it alone")');
    await page.waitForSelector('.rhead:has-text("10.0 s")');
    await page.click('button:has-text("show the whole file")');
    await page.waitForSelector('.rhead:has-text("40.1 s")');

    await page.click('summary:has-text("Dead band")');
    await page.fill('.stretches label:has-text("below") input', '2');
    await page.click('button:has-text("Set it")');
    await page.waitForSelector('text=A drive below 2 V counts as 0');
    await page.click('p:has-text("A drive below") button');
    await page.waitForSelector('text=A drive below', { state: 'detached' });

    await page.selectOption('.rhead label:has-text("role") select', 'validate');
    await page.waitForSelector('.chip:has-text("validate")');

    await page.click('.rhead button:has-text("Delete")');
    await page.waitForSelector('.undo');
    await page.waitForSelector('.drop.big');
    await page.click('button:has-text("Put it back")');
    await page.waitForSelector('.chip:has-text("identification_1hz")');
    assert.deepEqual(page.faults, []);
  } finally {
    await done(page);
    await server.close();
  }
});
