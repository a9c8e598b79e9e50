// What the tests share: a served campaign, a browser, and what must never happen on a page.
import { execFileSync, spawn } from 'node:child_process';
import { cpSync, mkdirSync, mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import { join, resolve } from 'node:path';
import { createInterface } from 'node:readline';
import assert from 'node:assert/strict';
import { chromium } from 'playwright-core';

const root = resolve(import.meta.dirname, '../..');
export const beeline = process.env.BEELINE ?? join(root, 'target/debug/beeline');
const axe = readFileSync(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');

/** Where pictures go; the tests remake those in docs/ if BEELINE_PICTURES=write. */
export const pictures = process.env.BEELINE_PICTURES === 'write' ? join(root, 'docs') : join(root, 'target/browser');
mkdirSync(pictures, { recursive: true });

/** A copy of an example campaign that is removed at the end. */
export function campaign(example = 'mystery-robot') {
  const folder = mkdtempSync(join(tmpdir(), 'beeline-'));
  const path = join(folder, 'my-robot');
  cpSync(join(root, 'examples', example), path, { recursive: true });
  return { folder, path, remove: () => rmSync(folder, { recursive: true }) };
}

/** Where a command runs: what it keeps for later is not the user's, and gone with the folder. */
export const at = (folder) => ({ cwd: folder, env: { ...process.env, XDG_CACHE_HOME: join(folder, '.cache') } });

/** What a command prints as JSON. */
export const run = (folder, ...args) => JSON.parse(execFileSync(beeline, [...args, '--json'], { ...at(folder), encoding: 'utf8', stdio: ['ignore', 'pipe', 'ignore'] }) || 'null');

/** The page of a campaign, served. */
export async function serve({ folder }) {
  const child = spawn(beeline, ['serve', 'my-robot', '--no-open', '--json', '--listen', '127.0.0.1:0'], { ...at(folder), stdio: ['ignore', 'pipe', 'inherit'] });
  const [first] = await new Promise((found) => createInterface(child.stdout).once('line', (...line) => found(line)));
  return { link: JSON.parse(first).link, stop: () => child.kill() };
}

/** A browser that is nobody's. */
export const launch = () =>
  chromium.launch({
    executablePath: execFileSync('sh', ['-c', 'command -v chromium'], { encoding: 'utf8' }).trim(),
    args: [
      '--disable-gpu',
      '--disable-quic',
      '--no-first-run',
      '--disable-background-networking',
      '--disable-component-update',
      '--disable-sync',
      ...(process.getuid?.() === 0 ? ['--no-sandbox'] : []),
    ],
  });

/** A tab of this width and colour scheme, open at a link; what goes wrong in it fails the test. */
export async function openPage(browser, link, { width = 1280, scheme = 'light', ...more } = {}) {
  const page = await browser.newPage({ viewport: { width, height: 1000 }, colorScheme: scheme, reducedMotion: 'reduce', ...more });
  // Other tests may keep the machine busy.
  page.setDefaultTimeout(180_000);
  const problems = [];
  const requests = [];
  page.on('console', (message) => ['error', 'warning'].includes(message.type()) && problems.push(message.text()));
  page.on('pageerror', (error) => problems.push(error.message));
  page.on('request', (request) => requests.push(request.url()));
  await page.goto(link);
  return {
    page,
    requests,
    sound: () => assert.deepEqual(problems, []),
    /** Serious findings about accessibility: none. */
    accessible: async () => {
      // By the debugger's way in: the page's own policy lets no other script run.
      const found = await page.evaluate(`${axe}; axe.run().then((result) => result.violations.map(({ id, impact, nodes }) => ({ id, impact, nodes: nodes.slice(0, 3).map((node) => node.html) })))`);
      assert.deepEqual(found.filter(({ impact }) => ['serious', 'critical'].includes(impact)), []);
    },
    /** The error that a bar shows now. */
    shown: async (error) => (await page.textContent(`[data-error=${error}] .after`)).trim(),
    /** Waits until all that was asked is answered and shown. */
    settled: () => page.waitForFunction(() => !document.body.hasAttribute('aria-busy')),
  };
}

/** The page of a campaign, explained. */
export async function open(browser, link, options) {
  const tab = await openPage(browser, link, options);
  await tab.page.waitForFunction(() => document.querySelector('#headline').textContent.includes('missing'));
  return tab;
}

/** An error as the page writes it. */
export const words = ({ position_rms_m: metres, heading_rms_rad: radians }) => {
  const milli = (value) => (value * 1e3).toFixed(value < 1e-3 ? 2 : 1);
  return `${milli(metres)} mm, ${milli(radians)} mrad`;
};
