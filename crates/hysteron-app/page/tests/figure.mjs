// The picture of the page in the README: the measured example after its fit.
import { join } from 'node:path';
import { drop, endBrowser, identified, open, P885, ROOT, serve } from './browser.mjs';

const BAR = 46;
const server = await serve();
try {
  const page = await open(server.url, { width: 1300, height: 1000 });
  await drop(page, P885);
  await page.waitForSelector('text=What this record determines');
  await page.click('a.primary');
  await page.waitForSelector('h1:text("Identify")');
  await page.click('button.primary');
  await identified(page);
  await page.waitForTimeout(1000);
  const clip = { x: 0, y: BAR, width: 1300, height: 860 };
  await page.screenshot({ path: join(ROOT, 'docs', 'figures', 'page.png'), clip });
} finally {
  await endBrowser();
  await server.close();
}
