// A server on a folder of its own and a browser that looks at it; what the page must never do ends the test.
import { chromium } from 'playwright-core';
import { spawn } from 'node:child_process';
import { once } from 'node:events';
import { cp, mkdtemp, mkdir, readFile, rm } from 'node:fs/promises';
import { createServer } from 'node:net';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';

export const ROOT = fileURLToPath(new URL('../../../..', import.meta.url));
export const OUT = process.env.OUT ?? join(ROOT, 'out', 'browser');
export const EXAMPLES = join(ROOT, 'examples');
export const COMMAND = process.env.HYSTERON ?? join(ROOT, 'target', 'debug', 'hysteron');
const CHROMIUM = process.env.CHROMIUM ?? '/usr/bin/chromium';

export const P885 = join(EXAMPLES, 'piezo-p885-200hz', 'identification_1hz.csv');

async function freePort() {
  const server = createServer().listen(0, '127.0.0.1');
  await once(server, 'listening');
  const { port } = server.address();
  server.close();
  await once(server, 'close');
  return port;
}

/** `hysteron app` on copies of `files`; one in `device` goes into a folder of its name there. */
export async function serve(files = [], device = {}) {
  const folder = await mkdtemp(join(tmpdir(), 'hysteron-app-'));
  for (const file of files) await cp(file, join(folder, file.split('/').pop()));
  for (const [name, file] of Object.entries(device)) {
    await mkdir(join(folder, name));
    await cp(file, join(folder, name, file.split('/').pop()));
  }
  const port = await freePort();
  const server = await start(folder, port);
  return {
    folder,
    port,
    url: `http://127.0.0.1:${port}/`,
    process: server,
    async restart() {
      this.process = await start(folder, port);
    },
    async kill(signal = 'SIGKILL') {
      const ended = once(this.process, 'exit');
      this.process.kill(signal);
      return ended;
    },
    async close() {
      if (this.process.exitCode === null && this.process.signalCode === null) await this.kill('SIGTERM');
      await rm(folder, { recursive: true, force: true });
    },
  };
}

async function start(folder, port) {
  const server = spawn(COMMAND, ['app', folder, '--port', String(port)], {
    stdio: ['ignore', 'pipe', 'pipe'],
  });
  let said = '';
  server.stdout.on('data', (text) => (said += text));
  server.stderr.on('data', (text) => (said += text));
  for (let i = 0; i < 100; i++) {
    if (server.exitCode !== null) throw new Error(`the server ended: ${said}`);
    const answer = await fetch(`http://127.0.0.1:${port}/api/v1/workspace`).catch(() => null);
    if (answer?.ok) return server;
    await new Promise((resolve) => setTimeout(resolve, 50));
  }
  server.kill('SIGKILL');
  throw new Error(`the server does not answer: ${said}`);
}

let browser;

/** With DIST: the page from that folder, under the headers of the server, whose own may be older. */
async function fresh(route) {
  const response = await route.fetch();
  const name = new URL(route.request().url()).pathname.slice(1) || 'index.html';
  await route.fulfill({ response, body: await readFile(join(process.env.DIST, name)) });
}

/** A page that keeps what it must not do: errors in the console, requests that leave this machine. */
export async function open(url, options = {}) {
  browser ??= await chromium.launch({ executablePath: CHROMIUM, args: ['--no-sandbox'] });
  const context = await browser.newContext({
    viewport: { width: options.width ?? 1440, height: options.height ?? 900 },
    colorScheme: options.theme ?? 'light',
    acceptDownloads: true,
  });
  if (process.env.DIST) await context.route(/\/(app\.js|app\.css)?$/, fresh);
  const page = await context.newPage();
  if (options.before) await page.addInitScript(options.before);
  const faults = [];
  page.on('console', (message) => {
    // A refused file answers 4xx, which the browser notes by itself: the page shows what the server said.
    if (message.type() === 'error' && !(options.refusals && /status of 4\d\d/.test(message.text()))) {
      faults.push(`console: ${message.text()}`);
    }
  });
  page.on('pageerror', (error) => faults.push(`error: ${error.stack}`));
  page.on('request', (request) => {
    const { protocol, hostname } = new URL(request.url());
    if (protocol !== 'blob:' && hostname !== '127.0.0.1') faults.push(`request to ${request.url()}`);
  });
  await page.goto(url);
  await page.waitForSelector('h1');
  page.faults = faults;
  return page;
}

export async function done(page) {
  await page.context().close();
}

export async function endBrowser() {
  await browser?.close();
  browser = undefined;
}

/** A window as high as the page, so that nothing lies under the dock. */
export async function whole(page) {
  const { width } = page.viewportSize();
  const height = await page.evaluate(() => Math.max(900, document.documentElement.scrollHeight));
  await page.setViewportSize({ width, height });
  await page.waitForTimeout(300);
}

/** The whole page in a window as high as itself, so that the dock stands at its end. */
export async function picture(page, name) {
  await mkdir(OUT, { recursive: true });
  const size = page.viewportSize();
  await whole(page);
  await page.screenshot({ path: join(OUT, `${name}.png`) });
  await page.setViewportSize(size);
}

/** Drops files onto the page, as a person does: the chooser takes the same way. */
export async function drop(page, ...files) {
  await page.setInputFiles('input[type=file]', files);
}

export async function identified(page, timeout = 120_000) {
  await page.waitForSelector('table.params', { timeout });
}
