// Robots that move in real time, and the pages on which they are driven.
import { spawn } from 'node:child_process';
import { createInterface } from 'node:readline';
import assert from 'node:assert/strict';
import { at, beeline } from './page.mjs';

// What a test that fails leaves behind.
const children = [];

/** Ends whatever was started. */
export const endAll = () => children.forEach((child) => child.kill());

/** A program in this folder, and the first line that it prints. */
export async function program(folder, command, args, env = {}) {
  const options = at(folder);
  const child = spawn(command, args, { ...options, env: { ...options.env, ...env }, stdio: ['ignore', 'pipe', 'inherit'] });
  children.push(child);
  const lines = createInterface(child.stdout);
  const [line] = await new Promise((found) => lines.once('line', (...line) => found(line)));
  return { child, lines, line };
}

/** A command of beeline, and the first line that it prints, as JSON. */
export async function started(folder, ...args) {
  const { child, lines, line } = await program(folder, beeline, [...args, '--json']);
  const first = JSON.parse(line);
  assert.equal(first.error, undefined);
  return { child, lines, first };
}

/** The page of a robot; without a port, of one that is simulated. */
export const servePage = (folder, port) => started(folder, 'serve', ...(port ? ['--port', port] : []), '--no-open', '--listen', '127.0.0.1:0');

/** Until the page shows one of these states. */
export const isState = (page, ...states) => page.waitForFunction((wanted) => wanted.includes(document.querySelector('#state').textContent), states, { polling: 100 });

/** So often is a motion begun that a busy machine has ended: it held the page up for longer than the robot moves without it. */
export const ATTEMPTS = 12;

/** For so long is a procedure. */
const PATIENCE_MS = 400_000;

/** Begins a motion, again and again until the page shows that the robot drives. */
export async function drives(page, begin) {
  for (let attempt = 0; attempt < ATTEMPTS; attempt += 1) {
    if ((await page.textContent('#state')) === 'faulted') await page.click('#clear');
    await isState(page, 'idle');
    await begin();
    const driving = page.waitForFunction(() => document.querySelector('#state').textContent === 'driving', null, { timeout: 5000, polling: 100 });
    if (await driving.then(() => true, () => false)) return;
  }
  assert.fail(`the robot never drives; the page says: ${await page.textContent('main')}`);
}

/** Begins a motion, again and again until it ends without a fault. */
export async function drivesToTheEnd(page, begin) {
  for (let attempt = 0; attempt < ATTEMPTS; attempt += 1) {
    await drives(page, begin);
    await isState(page, 'idle', 'faulted');
    if ((await page.textContent('#state')) === 'idle') return;
  }
  assert.fail(`the robot never drives to the end; the page says: ${await page.textContent('main')}`);
}

/** A procedure that a busy machine has ended: it held up the page, or the command behind it. */
const isHeldUp = () => {
  const words = document.querySelector('#ended-words');
  return words.getClientRects().length > 0 && /its messages came late|link_lost|time_to_live/.test(words.textContent);
};

/**
 * Goes through a procedure of this page. What a busy machine has ended is begun again by the button that the page offers for it,
 * and `steps` are gone through from their first. They wait by `unless`, which ends with the procedure, and are told which attempt
 * this is, from 0. `before` a procedure is begun again, its own traces are removed.
 */
export async function through(page, button, steps, before = () => {}) {
  const begun = Date.now();
  for (let attempt = 0; Date.now() - begun < PATIENCE_MS; attempt += 1) {
    const late = page.waitForFunction(isHeldUp, null, { timeout: 0, polling: 500 }).then(() => assert.fail('the page was held up'));
    // Whichever comes later is of no more interest.
    const ignore = (wait) => wait.catch(() => {});
    ignore(late);
    const unless = (wait) => {
      ignore(wait);
      return Promise.race([wait, late]);
    };
    try {
      return await steps(unless, attempt);
    } catch (error) {
      // Another page may have shown it first.
      const heldUp = await page.waitForFunction(isHeldUp, null, { timeout: 2000, polling: 100 }).then(() => true, () => false);
      if (!heldUp) {
        console.log(`the page says: ${await page.innerText('main')}`);
        throw error;
      }
    }
    console.log(`the page was held up: ${button}`);
    if ((await page.textContent('#state')) === 'faulted' && button !== '#continue') await page.click('#clear');
    await isState(page, 'idle', 'faulted');
    await before();
    await page.click(button);
    await page.waitForFunction(() => !document.querySelector('#ended').getClientRects().length);
  }
  assert.fail('the page is held up time and again');
}

/** A drive that the space bar stops, and a spin whose motors are cut: a latched fault, with its name. */
export async function stopAndCut(page) {
  await drives(page, async () => {
    await page.fill('#distance', '2');
    await page.press('#distance', 'Enter');
  });
  // The space bar brakes whatever has the focus.
  await page.focus('#straight button');
  await page.keyboard.press('Space');
  await isState(page, 'idle');
  await drives(page, () => page.click('#spin button'));
  await page.click('#cut');
  await isState(page, 'faulted');
  assert.match(await page.textContent('#words'), /^emergency_stop/);
}

/** Sends a signal to processes. */
export const signal = (pids, name) => pids.forEach((pid) => process.kill(pid, name));
