// How fast the pages are: frames a second, from the robot to the screen, beside eight who watch; and a switch of an effect.
// Nothing else should run beside it.
import { execFileSync } from 'node:child_process';
import { mkdtempSync, rmSync } from 'node:fs';
import { join } from 'node:path';
import { tmpdir } from 'node:os';
import { at, beeline, campaign, launch, openPage, run, serve } from './page.mjs';
import { endAll, isState, servePage, started } from './robots.mjs';

const median = (values) => [...values].sort((a, b) => a - b)[Math.floor(values.length / 2)];
const worst = (values) => Math.max(...values);
const ms = (value) => `${value.toFixed(0)} ms`;
const sleep = (time) => new Promise((done) => setTimeout(done, time));

/** Frames a second for five seconds. */
const framesOf = (page) => page.evaluate(() => new Promise((done) => {
  const begun = performance.now();
  let frames = 0;
  requestAnimationFrame(function count(now) {
    frames += 1;
    if (now - begun < 5000) requestAnimationFrame(count);
    else done((frames * 1000) / (now - begun));
  });
}));

/** Keeps when each newest sample was drawn: the robot's time, and that of this computer [ms]. */
const watchScreen = (page) => page.evaluate(() => {
  globalThis.drawn = [];
  Robot.onDraw(() => {
    const { t } = Robot.latest() ?? {};
    requestAnimationFrame(() => globalThis.drawn.push([t * 1e3, Date.now()]));
  });
});

async function robotPage(folder, browser) {
  const robot = await started(folder, 'sim', '--listen', 'tcp:127.0.0.1:0');
  const port = robot.first.listening;
  const { first } = await servePage(folder, port);
  const { page } = await openPage(browser, first.link);
  await isState(page, 'idle');
  // The quickest frames of a host on the same line tell the robot's clock.
  const clock = await started(folder, 'watch', '--port', port, '--rate', '500');
  let behind = Infinity;
  clock.lines.on('line', (line) => (behind = Math.min(behind, Date.now() - JSON.parse(line).t_us * 1e-3)));
  await sleep(2000);
  clock.child.kill();
  const links = [];
  const streams = [];
  for (let k = 0; k < 8; k += 1) {
    const { first: other } = k % 2 ? await servePage(folder, port) : { first };
    links.push(other.link);
    const stream = { bytes: 0, stop: new AbortController() };
    streams.push(stream);
    fetch(`${other.link}api/telemetry`, { signal: stream.stop.signal }).then(async ({ body }) => {
      for await (const part of body) stream.bytes += part.length;
    }).catch(() => {});
  }
  await sleep(1000);
  await watchScreen(page);
  const before = run(folder, 'identify', '--port', port).status;
  const drive = started(folder, 'record', 'bench', 'straight', '2m', '--rate', '500', '--port', port);
  await isState(page, 'driving');
  const fps = await framesOf(page);
  const { first: recorded } = await drive;
  const after = run(folder, 'identify', '--port', port).status;
  const drawn = await page.evaluate(() => globalThis.drawn);
  const late = drawn.map(([t, now]) => now - t - behind);
  console.log(`eight streams beside a drive at 500 Hz: ${fps.toFixed(1)} frames a second on the page that is seen`);
  console.log(`  from the robot to the screen: median ${ms(median(late))}, worst ${ms(worst(late))}, of ${late.length} frames`);
  console.log(`  control ticks lost: ${after.ticks_lost - before.ticks_lost} of ${after.ticks - before.ticks}; worst delay of a tick ${after.tick_delay_us_max} us`);
  console.log(`  telemetry that the robot dropped: ${after.link.telemetry_dropped - before.link.telemetry_dropped}; the driver has ${JSON.stringify(recorded)}`);
  console.log(`  each stream: ${(median(streams.map(({ bytes }) => bytes)) / 1e3).toFixed(0)} kB`);
  streams.forEach(({ stop }) => stop.abort());
  // A slow computer: a quarter of this one.
  const session = await page.context().newCDPSession(page);
  await session.send('Emulation.setCPUThrottlingRate', { rate: 4 });
  console.log(`alone, on a quarter of this processor: ${(await framesOf(page)).toFixed(1)} frames a second`);
}

/** A person who switches effects, one after another, and looks at each for so long. */
async function switches(example, pause) {
  const home = campaign(example);
  const { link, stop } = await serve(home);
  const ask = async (path, question) => (await fetch(`${link}api/${path}`, question && { method: 'POST', headers: { 'Content-Type': 'application/json' }, body: JSON.stringify(question) })).json();
  let answer = null;
  while (!answer) {
    await sleep(100);
    ({ answer } = await ask('explanation'));
  }
  const { catalogue } = await ask('campaign');
  const ids = catalogue.map(({ id }) => id);
  const found = answer.steps.map(({ effect }) => effect);
  const others = ids.filter((id) => !found.includes(id));
  // What was found, one by one; then each of the others in its turn, on and off.
  const models = [[], ...found.map((_, k) => found.slice(0, k + 1)), ...others.flatMap((id) => [[...found, id], found])];
  const [shown, whole] = [[], []];
  for (const model of models) {
    // As the page asks: in the order of the catalogue, quickly first.
    const effects = ids.filter((id) => model.includes(id)).map((id) => ({ id }));
    const begun = performance.now();
    const { quick } = await ask('model', { effects, quick: true });
    shown.push(performance.now() - begun);
    if (quick) await ask('model', { effects });
    whole.push(performance.now() - begun);
    await sleep(pause);
  }
  stop();
  home.remove();
  const told = (values) => `median ${ms(median(values))}, worst ${ms(worst(values))}`;
  console.log(`${example}, ${pause / 1000} s between two switches: paths after ${told(shown)}; cross-validated after ${told(whole)}; of ${whole.length}`);
}

const folder = mkdtempSync(join(tmpdir(), 'beeline-'));
const browser = await launch();
console.log(execFileSync(beeline, ['--version'], { ...at(folder), encoding: 'utf8' }).trim());
try {
  await robotPage(folder, browser);
  for (const example of ['mystery-robot', 'optiodom']) {
    for (const pause of [0, 1000, 3000]) await switches(example, pause);
  }
} finally {
  endAll();
  await browser.close();
  rmSync(folder, { recursive: true });
}
