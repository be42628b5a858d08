// What the expert settings of Follow, Validate and Take it home do, each ending in a file.
import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { join } from 'node:path';
import { after, test } from 'node:test';
import { done, endBrowser, identified, open, P885, picture, serve } from './browser.mjs';

after(endBrowser);

async function downloaded(page, act) {
  const [download] = await Promise.all([page.waitForEvent('download'), act()]);
  return { name: download.suggestedFilename(), text: await readFile(await download.path(), 'utf8') };
}

const dock = (page) => page.textContent('footer, .dock');

test('preview, learning, controllers, scored samples, names of the source', async () => {
  const server = await serve([P885]);
  const page = await open(`${server.url}#/identify`, { refusals: true });
  try {
    await page.click('button.primary:has-text("Identify from 1 record")');
    await identified(page);

    await page.goto(`${server.url}#/follow?preview=5&bandwidth=8`);
    await page.waitForSelector('text=known ahead');
    await page.waitForSelector('text=Predicted error');
    assert.match(await dock(page), /--bandwidth 8 --preview 5/);
    await picture(page, 'follow-preview');
    const drive = await downloaded(page, () => page.click('button:has-text("Download the drive")'));
    assert.equal(drive.name, 'drive.csv');
    await page.goto(`${server.url}#/follow?ref=drive-reference.csv&learn=drive.csv`);
    await page.waitForFunction(() => document.body.textContent.includes('--learn-from drive.csv'));

    await page.click('summary:has-text("Which controllers")');
    await page.click('fieldset label:has-text("uncompensated")');
    await page.click('fieldset label:text-is("feedforward")');
    await page.click('button:has-text("Simulate the controllers")');
    await page.waitForSelector('button:has-text("Download the samples")', { timeout: 120_000 });
    const track = await downloaded(page, () => page.click('button:has-text("Download the samples")'));
    assert.match(track.text, /u_uncompensated_V,y_uncompensated_um,u_feedforward_V/);
    await picture(page, 'follow-controllers');

    const record = P885.split('/').pop();
    await page.goto(`${server.url}#/validate?also=${record}&skip=0.1`);
    await page.waitForSelector('summary:has-text("How they are scored")');
    await page.click('summary:has-text("How they are scored")');
    await page.waitForSelector('.plot canvas');
    const scored = await downloaded(page, () =>
      page.click('button:has-text("Download the scored samples")'),
    );
    assert.match(scored.text.split('\n')[0], /u_.*residual/);
    await picture(page, 'validate-settings');

    await page.goto(`${server.url}#/home?prefix=axis&accuracy=0.001&preview=3&low=0&high=3`);
    await page.waitForFunction(() => document.body.textContent.includes('axis_inverse.c'));
    assert.match(await dock(page), /--name axis --accuracy 0.001 --inverse --range 0:3 --preview 3/);
    await page.click('summary:has-text("Name, accuracy")');
    await picture(page, 'home-settings');
    await page.goto(`${server.url}#/home?prefix=Not%20a%20name`);
    await page.waitForSelector('text=is not a valid name prefix');
    assert.deepEqual(page.faults, []);
    assert.ok(await readFile(join(server.folder, 'scored.csv')));
  } finally {
    await done(page);
    await server.close();
  }
});
