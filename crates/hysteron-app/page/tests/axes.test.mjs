// Several axes: the simulated controllers, source code for a level of drive, and structures compared.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdtemp, writeFile } from 'node:fs/promises';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { COMMAND, done, endBrowser, open, picture, serve } from './browser.mjs';

const RATE = 1000;
const PERIOD = 1024;
const AXES = ['--inputs', 'u1_V,u2_V', '--outputs', 'y1_nm,y2_nm'];
const FEW = '--modes 2 --steps 1 --plays 1 --iterations 2 --least-fit 0'.split(' ');

let server;

/** Numbers in [0, 1) that are the same every time. */
function random(seed) {
  let state = BigInt(seed);
  return () => {
    state = (state * 6364136223846793005n + 1442695040888963407n) & ((1n << 64n) - 1n);
    return Number(state >> 11n) / 2 ** 53;
  };
}

/** Two periods of multisines to 300 Hz on two actuators whose stage resonates at 130 Hz (simulated). */
function record(level, seed) {
  const next = random(seed);
  const lines = Math.round((300 * PERIOD) / RATE);
  const drive = () => {
    const phases = Array.from({ length: lines }, () => 2 * Math.PI * next());
    const at = (k) =>
      phases.reduce((sum, phase, l) => sum + Math.cos((2 * Math.PI * (l + 1) * k) / PERIOD + phase), 0);
    return Array.from({ length: PERIOD }, (_, k) => (level * at(k)) / Math.sqrt(lines / 2));
  };
  const [u1, u2] = [drive(), drive()];
  const [angle, damping] = [(2 * Math.PI * 130) / RATE, 0.05];
  const [p1, p2] = [2 * Math.exp(-damping * angle) * Math.cos(angle), -Math.exp(-2 * damping * angle)];
  const rows = ['# simulated: two actuators and a resonance, not measured', 't_s,u1_V,u2_V,y1_nm,y2_nm'];
  let [q1, q2] = [0, 0];
  for (let k = 0; k < 4 * PERIOD; k++) {
    const [a, b] = [u1[k % PERIOD], u2[k % PERIOD]];
    [q1, q2] = [p1 * q1 + p2 * q2 + angle * angle * (a + 0.3 * b), q1];
    const outputs = [q1 + 0.5 * a, 0.4 * q1 + b].map((y) => y + 0.002 * level * (next() - 0.5));
    // The first two periods settle.
    if (k >= 2 * PERIOD) rows.push([(k - 2 * PERIOD) / RATE, a, b, ...outputs].map(String).join(','));
  }
  return rows.join('\n') + '\n';
}

before(async () => {
  const folder = await mkdtemp(join(tmpdir(), 'hysteron-axes-'));
  const levels = { low1: [0.1, 1], low2: [0.1, 2], high1: [0.5, 3], high2: [0.5, 4] };
  const files = [];
  for (const [name, [level, seed]] of Object.entries(levels)) {
    files.push(join(folder, `simulated_${name}.csv`));
    await writeFile(files.at(-1), record(level, seed));
  }
  server = await serve(files);
  execFileSync(
    COMMAND,
    ['identify', 'simulated_low1.csv', 'simulated_high1.csv', ...AXES, ...FEW, '-o', 'axes.json'],
    {
      cwd: server.folder,
      stdio: 'pipe',
    },
  );
});

after(async () => {
  await server?.close();
  await endBrowser();
});

test('the controllers of all axes are simulated for references from a record', async () => {
  const page = await open(`${server.url}#/follow`);
  try {
    const own = page.locator('details.operation', { hasText: 'Controllers of all axes' });
    await own.locator('summary').click();
    await own.locator('label:has-text("References") select').selectOption('simulated_low1.csv');
    await own.locator('button:has-text("Simulate the controllers")').click();
    await own.locator('table').first().waitFor({ timeout: 120_000 });
    await picture(page, 'axes-track');
    assert.deepEqual(page.faults, []);
  } finally {
    await done(page);
  }
});

test('source code of an inverse of several axes takes a level and a range of each actuator', async () => {
  const page = await open(`${server.url}#/home?form=c&level=0.3&ranges=-1:1,-2:2`);
  try {
    await page.waitForSelector('a.primary:has-text("Download C99 source")', { timeout: 60_000 });
    const command = 'code[aria-label="The command that does the same"]';
    await page.waitForSelector(`${command}:has-text("--level 0.3")`);
    const shell = await page.textContent(command);
    assert.match(shell, /-1:1,-2:2/);
    const [download] = await Promise.all([
      page.waitForEvent('download'),
      page.click('a.primary:has-text("Download C99 source")'),
    ]);
    assert.match(download.suggestedFilename(), /-c\.zip$/);
    await picture(page, 'axes-home');
    assert.deepEqual(page.faults, []);
  } finally {
    await done(page);
  }
});

test('structures of several axes are compared and one is taken', async () => {
  const page = await open(
    `${server.url}#/compare?axes=1&inputs=u1_V,u2_V&outputs=y1_nm,y2_nm&o=${encodeURIComponent('{}')}`,
  );
  try {
    await page.click('button:has-text("Compare on 4 records")');
    await page.waitForSelector('caption:has-text("Left out in turn")', { timeout: 240_000 });
    await picture(page, 'axes-compare');
    assert.ok((await page.locator('table.mid tbody tr').count()) >= 2);
    assert.deepEqual(page.faults, []);
  } finally {
    await done(page);
  }
});
