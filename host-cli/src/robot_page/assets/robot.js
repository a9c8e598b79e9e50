// What the robot does: its news are taken in, and shown.
'use strict';

// A problem of this page's own stays so long.
const TOLD_MS = 8000;
const telemetry = new Telemetry();
let condition = {};
let failure = null;
let dirty = true;
const onNews = [];
const onDraw = [];
const changed = () => (dirty = true);

const wheels = (name) => [new Line(`left${name}`, 'left', 'before'), new Line(`right${name}`, 'right', 'after')];
const charts = [
  new Chart(find('speeds'), wheels('Speed').flatMap((line) => [line, new Line(line.column.replace('Speed', 'Wanted'), 'of', 'ink', true)]), 0.1, 3, changed),
  new Chart(find('errors'), wheels('Error'), 2, 2, changed),
  new Chart(find('duties'), wheels('Duty'), 20, 1, changed),
];
const timeline = new Timeline(charts, telemetry, changed);
const floor = new Floor(find('floor'), changed);

// What the other scripts of this page ask.
const Robot = {
  onNews: (told) => void onNews.push(told),
  onDraw: (drawn) => void onDraw.push(drawn),
  latest: () => telemetry.latest(),
  condition: () => condition,
  isPaused: () => Boolean(timeline.kept),
};

function take(row) {
  // A robot that has restarted begins anew.
  if (row[0] * 1e-6 < telemetry.last('t')) {
    telemetry.clear();
    floor.restart();
  }
  telemetry.push(row);
  floor.take(telemetry, condition);
}

const write = (id, text) => {
  if (find(id).textContent !== text) find(id).textContent = text;
};

function heading() {
  const last = telemetry.latest();
  write('name', condition.problem ? 'No robot' : condition.name || (condition.board ? 'Robot' : 'Looking for the robot'));
  const state = condition.problem ? 'no link' : last?.probing ? 'probing' : condition.state ?? 'no link';
  write('state', state);
  find('state').className = `pill ${state.replace(' ', '-')}`;
  figures(last);
  write('about', condition.board ? `${condition.board}, firmware ${condition.firmware}${condition.frames_lost ? `, ${condition.frames_lost} frame${condition.frames_lost === 1 ? '' : 's'} lost` : ''}` : '');
  const trouble = condition.problem ? { words: condition.problem, remedy: condition.advice } : condition.fault;
  find('trouble').hidden = !trouble;
  write('words', trouble?.words ?? '');
  const remedy = trouble?.remedy ?? '';
  write('remedy', remedy.replace(/^./, (letter) => letter.toUpperCase()).replace(/([^.?!])$/, '$1.'));
  find('clear').hidden = !condition.fault || Boolean(condition.problem);
  write('message', message());
  write('speed-out', `${speed().toFixed(2)} m/s`);
  const procedure = !mayDrive();
  find('controls').disabled = procedure;
  find('stick').setAttribute('aria-disabled', String(procedure));
}

// Figures of a robot that moves change five times a second: faster, nobody can read them.
let figured = 0;
function figures(last) {
  const now = performance.now();
  if (last && Telemetry.moves(STATES.indexOf(last.state)) && now - figured < Timeline.TOLD_EVERY_MS) return;
  figured = now;
  write('supply', last ? `${last.supply.toFixed(1)} V` : '');
  const degrees = last && (last.heading * 180) / Math.PI;
  write('pose', last ? `x ${signed(last.x.toFixed(3))} m, y ${signed(last.y.toFixed(3))} m, ${signed(degrees.toFixed(1))}\u00b0` : '');
}

function message() {
  if (!mayDrive()) return 'A procedure drives the robot: stop it, or watch.';
  if (failure && performance.now() < failure.until) return failure.words;
  if (condition.message) return condition.message;
  const page = condition.page && condition.page !== Drive.page ? 'page' : '';
  const who = condition.driven_by_another ? 'program' : page;
  return who && `Another ${who} drives this robot: you can watch it, and stop it.`;
}

// On a fast computer all parts are drawn at once. Where frames of the screen come late because of that, parts take turns, and
// then also wait: so many parts, every so many frames.
const PACES = [[4, 1], [2, 1], [1, 1], [1, 2], [1, 3]];
const LATE_MS = 24;
const TRY_AFTER_MS = 4000;
const parts = [() => onDraw.forEach((drawn) => drawn()), () => floor.draw(telemetry, condition), ...charts.map((chart) => () => timeline.draw(chart))];
const pace = { level: 0, late: 0, since: 0, wait: TRY_AFTER_MS, last: 0, frame: 0, next: 0, due: 0 };

// Goes slower after some late frames, and after a while tries to go faster; if that was too fast, later the next time.
function keepPace(now) {
  pace.late = now - pace.last > LATE_MS ? pace.late + 1 : Math.max(pace.late - 0.05, 0);
  if (pace.late >= 3 && pace.level < PACES.length - 1) {
    pace.wait = now - pace.since < TRY_AFTER_MS ? Math.min(pace.wait * 2, 60_000) : TRY_AFTER_MS;
    [pace.level, pace.late, pace.since] = [pace.level + 1, 0, now];
  } else if (pace.level > 0 && pace.late < 0.5 && now - pace.since > pace.wait) {
    [pace.level, pace.since] = [pace.level - 1, now];
  }
  pace.last = now;
}

function drawParts(now) {
  keepPace(now);
  const [most, every] = PACES[pace.level];
  pace.frame += 1;
  if (pace.frame % every) return;
  for (let k = Math.min(most, pace.due); k > 0; k -= 1) {
    parts[pace.next]();
    pace.next = (pace.next + 1) % parts.length;
    pace.due -= 1;
  }
}

function draw(now) {
  if (dirty && !document.hidden) {
    dirty = false;
    pace.due = parts.length;
    heading();
    timeline.tell();
  }
  drawParts(now);
  requestAnimationFrame(draw);
}

find('speed').addEventListener('input', changed);
find('forget').addEventListener('click', () => {
  floor.clear();
  changed();
});
matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => {
  readColours();
  changed();
});
Drive.onFailure((words) => {
  failure = { words, until: performance.now() + TOLD_MS };
  changed();
});

// A new stream begins with the last ten seconds, some of which are known.
function hear(news, first) {
  condition = news.condition ?? {};
  // What a page holds is over when a procedure begins; it is not stopped by that.
  if (condition.procedure_drives && Drive.isMoving()) Drive.drop();
  const rows = news.rows ?? [];
  const newest = telemetry.size ? telemetry.last('t') : -1;
  const again = first && (rows.at(-1)?.[0] ?? 0) * 1e-6 >= newest;
  for (const row of rows) if (!again || row[0] * 1e-6 > newest) take(row);
  for (const row of news.camera ?? []) if (row[0] * 1e-6 > floor.seen.last) floor.seen.take(row, telemetry);
  if ('prediction' in news) floor.predicted = news.prediction;
  Drive.hear(news.now_ms, condition.ended ?? 0);
  onNews.forEach((told) => told(news));
  changed();
}

// A browser has few connections to one server, and a stream takes one for itself: a tab that nobody sees gives it back, so
// that Stop never waits for one.
let source = null;
function listen() {
  source = Drive.telemetry();
  let first = true;
  source.addEventListener('message', ({ data }) => {
    hear(JSON.parse(data), first);
    first = false;
  });
  source.addEventListener('error', () => {
    condition = { problem: 'beeline serve does not answer', advice: 'start it again; the robot has stopped by itself' };
    first = true;
    changed();
  });
}
addEventListener('visibilitychange', () => (document.hidden ? source?.close() : listen()));
// The scripts after this one hear the first news as well.
addEventListener('DOMContentLoaded', listen);
requestAnimationFrame(draw);
