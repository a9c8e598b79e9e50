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
export const isState = (page, ...states) => page.waitForFunction((wanted) => wanted.includes(document.querySelector('#state').textContent), states);

/** A drive that the space bar stops, and a spin whose motors are cut: a latched fault, with its name. */
export async function stopAndCut(page) {
  await page.fill('#distance', '2');
  await page.press('#distance', 'Enter');
  await isState(page, 'driving');
  // The space bar brakes whatever has the focus.
  await page.focus('#straight button');
  await page.keyboard.press('Space');
  await isState(page, 'idle');
  await page.click('#spin button');
  await isState(page, 'driving');
  await page.click('#cut');
  await isState(page, 'faulted');
  assert.match(await page.textContent('#words'), /^emergency_stop/);
}

/** Sends a signal to processes. */
export const signal = (pids, name) => pids.forEach((pid) => process.kill(pid, name));
