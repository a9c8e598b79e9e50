// The page on which effects are switched, in a real browser.
import assert from 'node:assert/strict';
import { createServer } from 'node:http';
import { after, before, test } from 'node:test';
import { join } from 'node:path';
import { campaign, launch, open, pictures, run, serve, words } from './page.mjs';

const mystery = campaign();
let browser;
let served;
let added;

before(async () => {
  browser = await launch();
  served = await serve(mystery);
  added = run(mystery.folder, 'model', 'add', 'speed_growth', 'my-robot');
});

after(async () => {
  served.stop();
  await browser.close();
  mystery.remove();
});

for (const width of [1280, 390]) {
  for (const scheme of ['light', 'dark']) {
    test(`an effect is switched on by the keyboard and the error falls: ${width} wide, ${scheme}`, async () => {
      const tab = await open(browser, served.link, { width, scheme });
      const { page } = tab;
      assert.equal(await tab.shown('cross_validated'), words(added.before.heldout));
      const before = await page.locator('[data-error=cross_validated] .is').boundingBox();
      await page.focus('#switch-speed_growth');
      await page.keyboard.press('Space');
      await page.waitForSelector('.on[data-effect=speed_growth] output');
      // Values and paths are there at once; what is cross-validated follows.
      await tab.settled();
      assert.equal(await tab.shown('cross_validated'), words(added.after.heldout));
      assert.equal(await tab.shown('fitted'), words(added.after.train));
      const after = await page.locator('[data-error=cross_validated] .is').boundingBox();
      const share = added.after.heldout.position_rms_m / added.before.heldout.position_rms_m;
      assert.ok(Math.abs(after.width / before.width - share) < 0.02, `${after.width} of ${before.width}, not ${share}`);
      const [{ value, sigma }] = added.effects[0].parameters;
      assert.match(await page.textContent('.on output'), new RegExp(`${value.toFixed(5)} . ${sigma.toFixed(5)} s\\^2/m\\^2`));
      const overflow = await page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
      assert.ok(overflow <= 0, `the page is ${overflow} px too wide`);
      await tab.accessible();
      await page.evaluate(() => scrollTo(0, 0));
      if (scheme === 'light' || pictures.endsWith('browser')) await page.screenshot({ path: join(pictures, `serve-${width}${scheme === 'dark' ? '-dark' : ''}.png`) });
      await page.focus('#undo');
      await page.keyboard.press('Enter');
      await tab.settled();
      assert.equal(await tab.shown('cross_validated'), words(added.before.heldout));
      tab.sound();
      await page.close();
    });
  }
}

test('a value is pulled by its handle, and the way back is there', async () => {
  const tab = await open(browser, served.link);
  const { page } = tab;
  await page.click('#switch-speed_growth');
  await page.waitForSelector('.on output');
  const fitted = await tab.shown('fitted');
  await page.focus('.on input[type=range]');
  for (let press = 0; press < 8; press += 1) await page.keyboard.press('PageDown');
  await page.waitForFunction(() => document.querySelector('.on .note').textContent === 'set by hand');
  await tab.settled();
  const away = Number.parseFloat(await tab.shown('fitted'));
  assert.ok(away > 2 * Number.parseFloat(fitted), `${away} mm by hand, ${fitted} fitted`);
  assert.equal(await tab.shown('cross_validated'), 'not fitted');
  assert.ok(await page.isDisabled('#save'));
  // The link leads to this very view.
  const other = await open(browser, page.url());
  await other.page.waitForFunction(() => document.querySelector('.on .note')?.textContent === 'set by hand');
  assert.equal(Number.parseFloat(await other.shown('fitted')), away);
  await page.keyboard.press('Control+z');
  await page.waitForFunction(() => document.querySelector('.on .note').textContent.startsWith('significant'));
  assert.equal(await tab.shown('fitted'), fitted);
  tab.sound();
  other.sound();
  await page.close();
  await other.page.close();
});

test('what explain found is one click; each other effect is previewed', async () => {
  const tab = await open(browser, served.link);
  const { page } = tab;
  await page.click('#preview');
  await page.waitForSelector('#preview:not([disabled])');
  assert.match(await page.textContent('[data-effect=speed_growth] .note'), /1\.4 mm, .77 %/);
  await page.click('#proposed');
  await page.waitForSelector('.on[data-effect=speed_growth] output');
  assert.equal(await page.locator('#effects > li').first().getAttribute('data-effect'), 'speed_growth');
  assert.match(await page.textContent('[data-effect=speed_growth] .why'), /^Explain 1: /);
  await page.click('#picker button:has-text("square")');
  const names = await page.locator('#paths figcaption b').allTextContents();
  assert.ok(names.length > 1 && names.every((name) => name.includes('square')), names.join());
  await page.locator('#paths svg').first().hover();
  assert.match(await page.textContent('#tip'), /nominal .* mm off, now .* mm/);
  tab.sound();
  await page.close();
});

test('an equation is checked as it is typed, and added', async () => {
  const tab = await open(browser, served.link);
  const { page } = tab;
  await page.fill('#equation', 'ds_left = k * v_lef^3');
  await page.waitForSelector('#equation-note.bad');
  assert.match(await page.textContent('#equation-note'), /v_lef/);
  assert.ok(await page.isDisabled('#add'));
  await page.fill('#equation', 'ds_left = k * v_left^3');
  await page.waitForSelector('#add:not([disabled])');
  assert.match(await page.textContent('#equation-note'), /k in s\^2\/m\^2/);
  await page.press('#equation', 'Enter');
  await page.waitForSelector('.on output');
  await tab.settled();
  assert.notEqual(await tab.shown('cross_validated'), words(added.before.heldout));
  assert.equal(await page.getAttribute('.on', 'data-effect'), 'custom_ds_left');
  // The browser tells of answers that refuse, such as that to the wrong equation; no error is the page's own.
  await page.close();
});

test('the page as one file switches effects without a server', async () => {
  const file = join(mystery.folder, 'try.html');
  run(mystery.folder, 'report', 'my-robot', '--interactive', '-o', file);
  const tab = await open(browser, `file://${file}`);
  const { page } = tab;
  // It opens with the campaign's own model.
  await page.waitForSelector('.on[data-effect=speed_growth] output');
  await page.click('#none');
  await tab.settled();
  assert.equal(await tab.shown('cross_validated'), words(added.before.heldout));
  await page.click('#switch-speed_growth');
  await page.waitForSelector('.on output');
  assert.equal(await tab.shown('cross_validated'), words(added.after.heldout));
  await page.click('#switch-scrub');
  await page.waitForSelector('.on[data-effect=scrub] output');
  await page.click('#switch-side_slip');
  await page.waitForFunction(() => document.querySelector('#message').textContent.includes('beeline serve'));
  assert.ok(!(await page.isChecked('#switch-side_slip')));
  assert.deepEqual(tab.requests.filter((url) => !url.startsWith('file:') && !url.startsWith('data:')), []);
  tab.sound();
  await page.close();
});

test('another page in the same browser reads nothing and writes nothing', async () => {
  const stranger = createServer((_, response) => response.setHeader('Content-Type', 'text/html').end('<title>stranger</title>'));
  await new Promise((ready) => stranger.listen(0, '127.0.0.1', ready));
  const page = await browser.newPage();
  await page.goto(`http://127.0.0.1:${stranger.address().port}/`);
  const outcomes = await page.evaluate(async (link) => {
    const tried = async (path, options) => {
      try {
        const response = await fetch(link + path, options);
        return response.type === 'opaque' ? 'opaque' : await response.text();
      } catch {
        return 'refused';
      }
    };
    const body = JSON.stringify({ effects: [{ id: 'scrub' }] });
    return Promise.all([
      tried('api/campaign'),
      tried('api/model', { method: 'POST', headers: { 'Content-Type': 'application/json' }, body }),
      tried('api/save', { method: 'POST', mode: 'no-cors', headers: { 'Content-Type': 'text/plain' }, body }),
    ]);
  }, served.link);
  assert.deepEqual(outcomes.slice(0, 2), ['refused', 'refused']);
  assert.ok(['refused', 'opaque'].includes(outcomes[2]));
  const model = run(mystery.folder, 'model', 'show', 'my-robot');
  assert.deepEqual(model.effects.map(({ effect }) => effect), ['speed_growth'], 'what `model add` wrote is still there');
  await page.close();
  stranger.close();
});
