// Source code taken home: what the page hands out is what the command writes, and it runs.
import assert from 'node:assert/strict';
import { execFileSync, spawnSync } from 'node:child_process';
import { readFile, readdir, rm } from 'node:fs/promises';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { COMMAND, done, endBrowser, identified, open, P885, serve } from './browser.mjs';

let server;

before(async () => {
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

const has = (program, argument) => spawnSync(program, [argument]).status === 0;

/** Downloads a form, unpacks it, and has the command of the dock write the same beside it. */
async function taken(form, label, settings = '') {
  const page = await open(`${server.url}#/home?form=${form}${settings}`);
  try {
    await page.waitForSelector(`a.primary:has-text("Download ${label}")`);
    const command = 'code[aria-label="The command that does the same"]';
    await page.waitForFunction(
      ([at, to, more]) => {
        const text = document.querySelector(at).textContent;
        return text.includes(`--to ${to}`) && (!more || text.includes('--controller'));
      },
      [command, form, settings],
    );
    const shell = await page.textContent(command);
    const [download] = await Promise.all([
      page.waitForEvent('download'),
      page.click(`a.primary:has-text("Download ${label}")`),
    ]);
    assert.match(download.suggestedFilename(), new RegExp(`-${form}\\.zip$`));
    const folder = join(server.folder, `from-page-${form}`);
    execFileSync('unzip', ['-q', await download.path(), '-d', folder]);
    const [name] = await readdir(folder);
    const written = join(server.folder, name);
    execFileSync('sh', ['-c', shell.replace(/^hysteron\b/, COMMAND)], {
      cwd: server.folder,
      stdio: 'pipe',
    });
    await same(join(folder, name), written);
    // The next form writes into a folder of the same name.
    await rm(written, { recursive: true });
    assert.deepEqual(page.faults, []);
    return { folder: join(folder, name), name };
  } finally {
    await done(page);
  }
}

/** The command also measures a sweep and notes it in a comment. */
const withoutSweep = (text) =>
  text
    .split(/\r?\n/)
    .filter((line) => !/batch simulation along a sweep|^[\s*%]*most, .* rms\.$|of the range at$/.test(line))
    .join('\n');

async function same(page, command) {
  const names = await readdir(page);
  assert.deepEqual(names.sort(), (await readdir(command)).sort());
  for (const name of names) {
    const [a, b] = await Promise.all([page, command].map((at) => readFile(join(at, name), 'utf8')));
    assert.equal(withoutSweep(a), withoutSweep(b), name);
  }
}

test('MATLAB functions are those of the command, and their self-test passes in Octave', async (t) => {
  const { folder, name } = await taken('matlab', 'Functions of MATLAB');
  assert.ok((await readdir(folder)).includes(`${name}_selftest.m`));
  if (!has('octave-cli', '--version')) return t.diagnostic('skipped in part: GNU Octave is not installed');
  for (const test of [`${name}_selftest`, `${name}_inverse_selftest`])
    execFileSync('octave-cli', ['--no-gui', '--eval', `assert (${test} ())`], {
      cwd: folder,
      stdio: 'pipe',
    });
});

test('the S-function comes with C whose self-test passes', async (t) => {
  const { folder, name } = await taken('simulink', 'C99 source with an S-function');
  assert.match(await readFile(join(folder, `${name}_sfun.c`), 'utf8'), /simstruc\.h/);
  if (!has('cc', '--version')) return t.diagnostic('skipped in part: no C compiler is installed');
  const sources = [`${name}.c`, `${name}_selftest.c`];
  execFileSync('cc', ['-std=c99', '-ffp-contract=off', ...sources, '-o', 'selftest', '-lm'], {
    cwd: folder,
  });
  t.diagnostic(execFileSync(join(folder, 'selftest'), { encoding: 'utf8' }).trim());
});

test('a controller with an observer is that of the command, and its self-test passes', async (t) => {
  const { folder, name } = await taken('c', 'C99 source', '&controller=feedforward-observer');
  const own = (await readdir(folder)).filter((file) => file.endsWith('.c') && !/selftest|loop/.test(file));
  assert.ok(own.includes(`${name}_controller.c`));
  if (!has('cc', '--version')) return t.diagnostic('skipped in part: no C compiler is installed');
  const sources = [...own, `${name}_controller_selftest.c`];
  execFileSync('cc', ['-std=c99', '-ffp-contract=off', ...sources, '-o', 'selftest', '-lm'], {
    cwd: folder,
  });
  t.diagnostic(execFileSync(join(folder, 'selftest'), { encoding: 'utf8' }).trim());
});

test('a compilation that takes its time says so and can be stopped', async () => {
  const page = await open(`${server.url}#/home?form=fmu`);
  try {
    await page.click('[role=group][aria-label^="FMI"] button:has-text("Stop")', { timeout: 20_000 });
    await page.waitForSelector('text=It was stopped.');
    await page.click('button:has-text("Make it again")');
    await page.waitForSelector('text=It was stopped.', { state: 'detached' });
    assert.deepEqual(page.faults, []);
  } finally {
    await done(page);
  }
});
