// Calibrate, tune and campaign on the page of a robot, in a real browser and in real time; and the page of the emulated board.
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { mkdirSync, mkdtempSync, readdirSync, rmSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { tmpdir } from 'node:os';
import { launch, openPage, pictures, run } from './page.mjs';
import { ATTEMPTS, drives, drivesToTheEnd, endAll, isState, program, servePage, started, stopAndCut, through } from './robots.mjs';

// Whatever hangs must not hang for ever.
const LIMIT = { timeout: 600_000 };

// Three short runs.
const PLAN = `acceleration_mps2 = 0.5

[[run]]
name = "out_and_back"
shows = "unequal wheel radii"
pieces = [{ straight_m = 0.6, speed_mps = 0.3 }, { straight_m = -0.6, speed_mps = 0.3 }]

[[run]]
name = "spin"
shows = "the track width"
pieces = [{ spin_deg = 360.0, speed_mps = 0.2 }]

[[run]]
name = "arc"
shows = "both together"
heading_deg = 90.0
pieces = [{ arc_deg = 180.0, radius_m = 0.4, speed_mps = 0.2 }]
`;

let folder;
let browser;

before(async () => {
  folder = mkdtempSync(join(tmpdir(), 'beeline-'));
  browser = await launch();
});

after(async () => {
  endAll();
  await browser.close();
  rmSync(folder, { recursive: true });
});

const shot = (page, name) => page.screenshot({ path: join(pictures, name), fullPage: true });
const text = async (page, id) => (await page.textContent(id)).trim();
const isShown = (page, id) => page.waitForSelector(id, { state: 'visible' });

async function fits(tab) {
  await tab.accessible();
  const overflow = await tab.page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
  assert.ok(overflow <= 0, `the page is ${overflow} px too wide`);
}

test('a person with a ruler is guided through a calibration, by the keyboard alone', LIMIT, async () => {
  const robot = await started(folder, 'sim', '--listen', 'tcp:127.0.0.1:0');
  const port = robot.first.listening;
  const { child, first } = await servePage(folder, port);
  const tab = await openPage(browser, first.link);
  const { page } = tab;
  await isState(page, 'idle');
  await page.focus('#tab-drive');
  await page.keyboard.press('ArrowRight');
  const weight = () => run(folder, 'config', 'get', 'geometry.wheel_weight', '--port', port);
  await page.fill('#calibrate-distance', '4');
  await page.press('#calibrate-distance', 'Enter');
  await through(page, '#again', async (unless) => {
    // Where a ruler would read what this robot's radii make of four turns, and nothing once they are known.
    for (const offset of ['-9.1mm', '0mm']) {
      await unless(isShown(page, '#choices button'));
      assert.match(await text(page, '#question-text'), /start line/);
      await page.keyboard.press('Enter');
      await unless(isShown(page, '#answer-0'));
      assert.match(await text(page, '#question-text'), /offset from the line/);
      if (offset !== '0mm') {
        await fits(tab);
        await shot(page, 'calibrate-1280.png');
        // Without a unit it is no length, and the question stays.
        await page.keyboard.type('-9.1');
        await page.keyboard.press('Enter');
        await isShown(page, '#answer-trouble');
        // What cannot be read is asked again, with the reason beside it and what was typed.
        await page.fill('#answer-0', '1,5mm');
        await page.keyboard.press('Enter');
        await page.waitForFunction(() => document.querySelector('#answer-trouble').textContent.includes('no unit'));
        assert.equal(await page.inputValue('#answer-0'), '1,5mm');
        await page.fill('#answer-0', '');
      }
      await page.keyboard.type(offset);
      await page.keyboard.press('Enter');
    }
    await unless(isShown(page, '#ended.ok'));
  }, () => {
    // What was held up in its second drive has saved the first one's result.
    if (weight() !== 1) run(folder, 'config', 'set', 'geometry.wheel_weight', '1', '--port', port);
  });
  assert.ok(Math.abs(weight() - 0.9918) < 3e-4, `W_T is ${weight()}`);
  await page.waitForFunction(() => document.querySelector('#drawing img').naturalWidth > 200);
  await fits(tab);
  await page.click('#undo');
  await page.waitForFunction(() => /again, as before/.test(document.querySelector('#transcript').textContent));
  await isShown(page, '#ended.ok');
  assert.equal(weight(), 1);
  tab.sound();
  await page.close();
  child.kill();
  robot.child.kill();
});

test('a campaign of three runs is recorded on the page, its errors are shown, and its effects can be switched', LIMIT, async () => {
  mkdirSync(join(folder, 'my-robot'));
  writeFileSync(join(folder, 'my-robot', 'plan.toml'), PLAN);
  const { child, first } = await servePage(folder);
  const tab = await openPage(browser, `${first.link}#campaign`);
  const { page } = tab;
  await isState(page, 'idle');
  for (const id of ['#campaign-along', 'input[name=across]']) await page.fill(id, '');
  // Another page sees it, and does not keep it alive. While the robot drives on, it is away: two pages are much for a slow machine.
  const narrow = () => openPage(browser, `${first.link}#campaign`, { width: 390, scheme: 'dark' });
  let watcher = await narrow();
  await page.bringToFront();
  await page.press('#campaign-folder', 'Enter');
  await through(page, '#continue', async (unless, attempt) => {
    if (watcher) {
      await unless(isShown(watcher.page, '#watching'));
      watcher.sound();
      await watcher.page.close();
      watcher = null;
    }
    await unless(page.waitForFunction(() => document.querySelectorAll('#runs li').length === 3));
    await unless(page.waitForFunction(() => document.querySelector('#motion-title').textContent.startsWith('3/3') && Number.parseInt(document.querySelector('#motion-share').textContent, 10) > 60));
    // On a slow machine the picture itself holds the page up.
    if (attempt === 0) await shot(page, 'campaign-1280.png');
    await unless(page.waitForFunction(() => document.querySelector('#campaign-count').textContent.startsWith('3')));
    await unless(isShown(page, '#ended.ok'));
  });
  await page.waitForFunction(() => document.querySelector('#found').children.length > 0);
  const shown = Number.parseFloat(await text(page, '#campaign-error'));
  const explained = run(folder, 'explain', 'my-robot');
  assert.equal(await text(page, '#found li'), explained.verdict);
  const told = explained.baseline.heldout.position_rms_m * 1e3;
  assert.ok(Math.abs(shown - told) < 0.051, `the page says ${shown} mm, explain ${told}`);
  await fits(tab);
  const model = page.context().waitForEvent('page');
  await page.click('#explain');
  const switches = await model;
  await switches.waitForFunction(() => document.querySelector('#headline')?.textContent.length > 10);
  await switches.close();
  watcher = await narrow();
  await isShown(watcher.page, '#ended.ok');
  await fits(watcher);
  await shot(watcher.page, 'campaign-390-dark.png');
  for (const each of [tab, watcher]) {
    each.sound();
    await each.page.close();
  }
  child.kill();
});

test('what a camera sees, and what a model predicts, stands beside the odometry', LIMIT, async () => {
  const { child, first } = await servePage(folder);
  const tab = await openPage(browser, first.link);
  const { page } = tab;
  await isState(page, 'idle');
  await page.fill('#speed', '90');
  await page.fill('#radius', '0.8');
  await page.fill('#arc-angle', '100');
  // This robot's right wheel is 0.8 % smaller than its counts say: the camera sees it elsewhere, and the band has it.
  for (let apart = 0, attempt = 0; apart <= 5; attempt += 1) {
    assert.ok(attempt < ATTEMPTS, `the camera sees the robot ${apart} mm apart`);
    await drives(page, () => page.click('#arc button'));
    await page.waitForTimeout(4200);
    await shot(page, 'robot-1280.png');
    await isState(page, 'idle', 'faulted');
    // The picture may come before the last of the camera.
    await page.waitForTimeout(500);
    apart = Number.parseFloat(await text(page, '#apart'));
  }
  assert.match(await text(page, '#predicted-of'), /radii and track width/);
  // The camera measures a calibration too, by itself; the space bar ends it.
  await page.click('#tab-calibrate');
  await page.click('#panel-calibrate .main');
  await through(page, '#again', async (unless) => {
    await unless(isState(page, 'driving'));
    await page.keyboard.press('Space');
    await unless(isShown(page, '#ended.failed'));
    assert.match(await text(page, '#ended-words'), /^Stopped on the page/);
  });
  await isState(page, 'idle');
  tab.sound();
  await page.close();
  child.kill();
  // With a campaign, its model predicts.
  run(folder, 'model', 'add', 'wheel_radius_ratio', 'my-robot');
  const robot = await started(folder, 'sim', '--listen', 'tcp:127.0.0.1:0');
  const both = await started(folder, 'serve', 'my-robot', '--port', robot.first.listening, '--no-open', '--listen', '127.0.0.1:0');
  const model = await openPage(browser, both.first.link);
  await isState(model.page, 'idle');
  await drives(model.page, async () => {
    await model.page.fill('#distance', '0.3');
    await model.page.press('#distance', 'Enter');
  });
  await model.page.waitForFunction(() => document.querySelector('#predicted-of').textContent.includes('my-robot: wheel_radius_ratio'));
  model.sound();
  await model.page.close();
  both.child.kill();
  robot.child.kill();
});

test('a procedure ends when its page is hidden, and says so; a page that does not hold it changes nothing', LIMIT, async () => {
  const { child, first } = await servePage(folder);
  const tab = await openPage(browser, `${first.link}#tune`);
  const { page } = tab;
  await isState(page, 'idle');
  const other = await openPage(browser, `${first.link}#tune`);
  await page.bringToFront();
  await page.click('#panel-tune .main');
  // The tab in the background is hidden for a real browser; a headless one has to be told.
  const hide = (value) => page.evaluate((value) => Object.defineProperty(document, 'hidden', { value, configurable: true }), value);
  await through(page, '#again', async (unless, attempt) => {
    await unless(isState(page, 'driving'));
    await unless(isShown(other.page, '#watching'));
    if (attempt === 0) await shot(other.page, 'tune-1280.png');
    await hide(true);
    try {
      // The words of this end are those of a page that was held up: whichever it was, the other page shows it.
      await isShown(other.page, '#ended.failed');
      assert.match(await text(other.page, '#ended-words'), /not in front/);
    } catch (error) {
      // A page in the background clears no fault.
      await hide(false);
      throw error;
    }
  });
  await isState(other.page, 'idle', 'faulted');
  other.sound();
  await other.page.close();
  await page.close();
  child.kill();
});

const emulator = process.env.BEELINE_EMULATOR;
test('the flashed image on an emulated board is driven, stopped, cut and cleared on the page', { ...LIMIT, skip: !emulator && 'no emulator was built' }, async () => {
  const board = await program(folder, emulator, ['--listen', '127.0.0.1:0']);
  const port = `tcp:${board.line.match(/127\.0\.0\.1:\d+/)[0]}`;
  const { child, first } = await servePage(folder, port);
  const tab = await openPage(browser, first.link);
  const { page } = tab;
  await isState(page, 'idle');
  await drivesToTheEnd(page, async () => {
    await page.fill('#distance', '0.3');
    await page.press('#distance', 'Enter');
  });
  await stopAndCut(page);
  await page.click('#clear');
  await isState(page, 'idle');
  // The board goes, and comes back.
  board.child.kill('SIGSTOP');
  await isState(page, 'no link');
  board.child.kill('SIGCONT');
  await isState(page, 'idle', 'faulted');
  tab.sound();
  await page.close();
  child.kill();
  board.child.kill();
});

test('nothing is left behind in the folder but what was asked for', () => {
  const left = readdirSync(folder).filter((name) => !name.startsWith('.'));
  assert.deepEqual(left.sort(), ['beeline-calibration.svg', 'my-robot']);
});
