// Every room in both themes and three widths: no violation of WCAG 2.2 AA that axe finds, no sideways scroll.
import assert from 'node:assert/strict';
import { readFile } from 'node:fs/promises';
import { after, before, test } from 'node:test';
import { done, drop, endBrowser, identified, open, P885, picture, serve, whole } from './browser.mjs';

const ROOMS = ['records', 'identify', 'compare', 'validate', 'follow', 'home', 'try', 'history'];
const WIDTHS = [1440, 900, 500];
const THEMES = ['light', 'dark'];
const RULES = ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa', 'wcag22aa', 'best-practice'];

let server;
let axe;

before(async () => {
  axe = await readFile(new URL('../node_modules/axe-core/axe.min.js', import.meta.url), 'utf8');
  server = await serve([P885]);
  const page = await open(`${server.url}#/identify`);
  await page.click('button.primary');
  await identified(page);
  await done(page);
});

after(async () => {
  await server?.close();
  await endBrowser();
});

async function violations(page) {
  await page.evaluate(axe);
  const found = await page.evaluate(
    (values) => window.axe.run({ runOnly: { type: 'tag', values } }),
    RULES,
  );
  return found.violations.flatMap((rule) =>
    rule.nodes.map(
      (node) => `${rule.id}: ${node.html.slice(0, 160)} (${node.any[0]?.message ?? rule.help})`,
    ),
  );
}

async function settled(page) {
  await page.waitForLoadState('load');
  await page
    .waitForFunction(() => !document.querySelector('main .sk'), null, { timeout: 30_000 })
    .catch(() => {});
  await page.waitForTimeout(300);
}

for (const room of ROOMS) {
  test(`room ${room}`, async () => {
    for (const theme of THEMES) {
      for (const width of WIDTHS) {
        const also = room === 'validate' ? '?also=identification_1hz.csv' : '';
        const page = await open(`${server.url}#/${room}${also}`, { width, theme });
        try {
          await settled(page);
          const wide = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
          assert.ok(wide <= 0, `${room} ${width}: ${wide} px wider than the window`);
          await whole(page);
          assert.deepEqual(await violations(page), [], `${room} ${width} ${theme}`);
          await picture(page, `${room}-${width}-${theme}`);
          assert.deepEqual(page.faults, []);
        } finally {
          await done(page);
        }
      }
    }
  });
}

test('empty rooms say what is missing', async () => {
  const empty = await serve();
  try {
    for (const room of ROOMS) {
      const page = await open(`${empty.url}#/${room}`);
      await settled(page);
      assert.deepEqual(await violations(page), [], `${room} empty`);
      await picture(page, `${room}-empty-1440-light`);
      assert.deepEqual(page.faults, []);
      await done(page);
    }
  } finally {
    await empty.close();
  }
});
