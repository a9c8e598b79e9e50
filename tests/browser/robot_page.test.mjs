// The page on which a robot is watched and driven, in a real browser. In real time: nothing else should run beside it.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { after, before, beforeEach, test } from 'node:test';
import { mkdtempSync, readdirSync, readFileSync, rmSync } from 'node:fs';
import { join } from 'node:path';
import { tmpdir } from 'node:os';
import { beeline, launch, openPage, pictures } from './page.mjs';
import { ATTEMPTS, drivesToTheEnd, endAll, isState, servePage, signal, started, stopAndCut } from './robots.mjs';

// So often each way of losing the page is tried.
const TIMES = Number(process.env.BEELINE_TIMES ?? 4);
// Whatever hangs must not hang for ever.
const LIMIT = { timeout: 100_000 + 10_000 * TIMES };

let folder;
let browser;
let robot;
// What a test that fails leaves behind.
const browsers = [];

const serve = (port) => servePage(folder, port);

/** Another program that watches: the robot's states as they come, in the robot's own words. */
async function watch(port) {
  const { child, lines, first } = await started(folder, 'watch', '--port', port, '--rate', '100');
  const seen = { last: first };
  let told = () => {};
  lines.on('line', (line) => {
    const frame = JSON.parse(line);
    if (frame.wheels) seen.last = frame;
    told();
  });
  return {
    frame: () => seen.last,
    stop: () => child.kill(),
    // The first frame for which this holds; null if there is none in this time.
    until: (holds, ms = 10_000) => new Promise((found) => {
      setTimeout(() => found(null), ms);
      told = () => holds(seen.last) && found(seen.last);
      told();
    }),
  };
}

/** A browser that is closed at the end. */
async function another() {
  browsers.push(await launch());
  return browsers.at(-1);
}

before(async () => {
  folder = mkdtempSync(join(tmpdir(), 'beeline-'));
  browser = await another();
  // A robot of its own process: what becomes of the page's server does not touch it.
  robot = await started(folder, 'sim', '--listen', 'tcp:127.0.0.1:0');
});

after(async () => {
  endAll();
  await Promise.all(browsers.map((each) => each.close()));
  rmSync(folder, { recursive: true });
});

const port = () => robot.first.listening;

// A robot without a fault: where nobody spoke with it for long enough, it has one, as the link was lost.
function sound() {
  for (const command of ['stop', 'clear']) execFileSync(beeline, [command, '--port', port()], { stdio: 'ignore' });
}

beforeEach(sound);

for (const width of [1280, 390]) {
  for (const scheme of ['light', 'dark']) {
    test(`a robot is driven by the keyboard, stopped, cut and cleared: ${width} wide, ${scheme}`, LIMIT, async () => {
      const { child, first } = await serve(port());
      const tab = await openPage(browser, first.link, { width, scheme });
      const { page } = tab;
      await isState(page, 'idle');
      const x = async () => Number.parseFloat((await page.textContent('#pose')).replace('\u2212', '-').replace(/.*x /, ''));
      // A machine that is busy may hold the page up, and the robot brakes: it is driven again.
      for (let attempt = 0, drives = false; !drives; attempt += 1) {
        assert.ok(attempt < ATTEMPTS, 'the robot never goes on driving');
        sound();
        await isState(page, 'idle');
        await page.keyboard.down('ArrowUp');
        await isState(page, 'driving');
        await page.waitForTimeout(1200);
        await page.keyboard.down('ArrowLeft');
        await page.waitForTimeout(900);
        drives = (await page.textContent('#state')) === 'driving';
        if (!drives) for (const key of ['ArrowLeft', 'ArrowUp']) await page.keyboard.up(key);
      }
      if (pictures.endsWith('browser')) await page.screenshot({ path: join(pictures, `drive-${width}-${scheme}.png`) });
      await page.keyboard.up('ArrowLeft');
      await page.keyboard.up('ArrowUp');
      await isState(page, 'idle');
      const before = await x();
      await page.waitForTimeout(300);
      assert.equal(await x(), before, 'it stands');
      await stopAndCut(page);
      await tab.accessible();
      await page.focus('#clear');
      await page.keyboard.press('Enter');
      await isState(page, 'idle');
      const overflow = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
      assert.ok(overflow <= 0, `the page is ${overflow} px too wide`);
      tab.sound();
      await page.close();
      child.kill();
    });
  }
}

/** The processes that run pages. */
const renderers = () => readdirSync('/proc').filter((pid) => {
  try {
    return readFileSync(`/proc/${pid}/cmdline`, 'utf8').includes('--type=renderer');
  } catch {
    return false;
  }
}).map(Number);

// The robot drives; then the page is gone in one way or another. How long until it brakes, as another program sees it?
async function deadMan(name, gone, times = TIMES) {
  const found = [];
  for (let time = 0; time < times; time += 1) {
    const { child, first } = await serve(port());
    const others = renderers();
    const own = await another();
    const { page } = await openPage(own, first.link);
    await isState(page, 'idle');
    const seen = await watch(port());
    // A machine that is busy may hold the page up, and the robot brakes: the key is pressed again.
    let fast = null;
    for (let attempt = 0; fast === null; attempt += 1) {
      const { state, wheels } = seen.frame();
      const shown = attempt === ATTEMPTS && (await page.textContent('main'));
      assert.ok(attempt < ATTEMPTS, `${name}: the robot never gets fast; it is ${state} at ${wheels?.left.speed_um_s} um/s, and the page says: ${shown}`);
      await page.keyboard.up('ArrowUp');
      await page.keyboard.down('ArrowUp');
      fast = await seen.until((frame) => frame.state === 'driving' && frame.wheels.left.speed_um_s > 80_000, 3000);
    }
    // By the robot's own clock: this program, and the one that watches, may be held up as well.
    const begun = seen.frame().t_us;
    const undo = gone({ child, page, renderers: renderers().filter((pid) => !others.includes(pid)) });
    const braked = await seen.until((frame) => frame.state !== 'driving');
    assert.notEqual(braked, null, `${name}: the robot goes on`);
    found.push((braked.t_us - begun) / 1e3);
    await seen.until((frame) => ['idle', 'armed', 'faulted'].includes(frame.state));
    if (undo) {
      await undo();
      // The key is still down; a robot that drives off by itself, minutes later, is worse than one that goes on for a moment.
      assert.equal(await seen.until((frame) => frame.state === 'driving', 1500), null, `${name}: it is undone, and the robot drives off`);
    }
    seen.stop();
    await own.close();
    child.kill();
    sound();
  }
  found.sort((a, b) => a - b);
  console.log(`${name}: the robot brakes after ${found.map((ms) => ms.toFixed(0)).join(', ')} ms`);
  // The lease is 200 ms. The last frame that this program had seen may be older than what it did then, never younger.
  assert.ok(found[0] < 250 && found.at(-1) < 500, `${name}: ${found.join(', ')} ms`);
}

test('a tab that is closed stops the robot', LIMIT, () => deadMan('tab closed', ({ page }) => void page.close()));

test('a server that is killed stops the robot', LIMIT, () => deadMan('server killed', ({ child }) => void child.kill('SIGKILL')));

test('a page that is frozen stops the robot', LIMIT, () =>
  deadMan('page frozen', ({ renderers }) => {
    signal(renderers, 'SIGSTOP');
    return () => signal(renderers, 'SIGCONT');
  }));

test('a host that sleeps stops the robot', LIMIT, () =>
  deadMan('host asleep', ({ child, renderers }) => {
    const all = [...renderers, child.pid];
    signal(all, 'SIGSTOP');
    return () => signal(all, 'SIGCONT');
  }));

test('a network that is cut stops the robot', LIMIT, () =>
  deadMan('network cut', ({ page }) => {
    const offline = page.context().setOffline(true);
    return async () => {
      await offline;
      await page.context().setOffline(false);
    };
  }));

test('two pages and another program watch one drive; only one drives', LIMIT, async () => {
  const { child, first } = await serve(port());
  const driver = await openPage(browser, first.link);
  const other = await serve(port());
  // A window of its own: a tab that nobody sees gives its stream back.
  const second = await another();
  const watcher = await openPage(second, other.first.link);
  await Promise.all([driver, watcher].map(({ page }) => isState(page, 'idle')));
  let watched = null;
  await drivesToTheEnd(driver.page, async () => {
    await driver.page.fill('#distance', '0.6');
    await driver.page.press('#distance', 'Enter');
    const isWatched = () => document.querySelector('#state').textContent === 'driving' && document.querySelector('#message').textContent.includes('Another program drives');
    watched ??= watcher.page.waitForFunction(isWatched, null, { polling: 100 });
  });
  await watched;
  await isState(watcher.page, 'idle');
  const poses = await Promise.all([driver, watcher].map(({ page }) => page.textContent('#pose')));
  assert.equal(poses[0], poses[1]);
  for (const tab of [driver, watcher]) {
    assert.doesNotMatch(await tab.page.textContent('#about'), /lost/);
    tab.sound();
    await tab.page.close();
  }
  await second.close();
  child.kill();
  other.child.kill();
});
