// What the robot does, and the buttons.
'use strict';

const find = (id) => document.getElementById(id);
const STATES = ['boot', 'idle', 'armed', 'driving', 'stopping', 'faulted'];
const SECONDS = 10;
const frames = [];
const path = [];
let condition = {};
let paused = null;
let dirty = true;

const wheel = (row, at) => ({ setpoint: row[at] * 1e-6, error: row[at + 1] * 1e-3, speed: row[at + 2] * 1e-6, duty: row[at + 3] / 327.67 });

// Setpoints come as places: their speed is the change from frame to frame.
function take(row) {
  const before = frames.at(-1);
  const frame = { t: row[0] * 1e-6, state: STATES[row[1]], probing: row[2] === 1, x: row[3] * 1e-6, y: row[4] * 1e-6, heading: row[5] * 1e-6, supply: row[6] * 1e-3, left: wheel(row, 7), right: wheel(row, 11) };
  // A robot that has restarted begins anew.
  if (before && frame.t < before.t) {
    frames.length = 0;
    path.length = 0;
  }
  for (const side of ['left', 'right']) {
    const past = before && frame.t > before.t ? before[side] : null;
    frame[side].wanted = past ? (frame[side].setpoint - past.setpoint) / (frame.t - before.t) : 0;
  }
  frames.push(frame);
  while (frames[0].t < frame.t - SECONDS) frames.shift();
  const last = path.at(-1);
  if (!last || Math.hypot(last.x - frame.x, last.y - frame.y) > 0.005) path.push(frame);
  if (path.length > 4000) path.splice(0, path.length, ...path.filter((_, k) => k % 2 === 0));
}

function heading() {
  const last = frames.at(-1);
  find('name').textContent = condition.problem ? 'No robot' : condition.name || (condition.board ? 'Robot' : 'Looking for the robot');
  const state = condition.problem ? 'no link' : last?.probing ? 'probing' : condition.state ?? 'no link';
  find('state').textContent = state;
  find('state').className = `pill ${state.replace(' ', '-')}`;
  find('supply').textContent = last ? `${last.supply.toFixed(1)} V` : '';
  find('pose').textContent = last ? `x ${last.x.toFixed(3)} m, y ${last.y.toFixed(3)} m, ${((last.heading * 180) / Math.PI).toFixed(1)}\u00b0` : '';
  find('about').textContent = condition.board ? `${condition.board}, firmware ${condition.firmware}${condition.frames_lost ? `, ${condition.frames_lost} frames lost` : ''}` : '';
  const trouble = condition.problem ? { words: condition.problem, remedy: condition.advice } : condition.fault;
  find('trouble').hidden = !trouble;
  find('words').textContent = trouble?.words ?? '';
  find('remedy').textContent = trouble?.remedy ? `Try: ${trouble.remedy}.` : '';
  find('clear').hidden = !condition.fault || Boolean(condition.problem);
  const page = condition.page && condition.page !== Drive.page ? 'page' : '';
  const who = condition.driven_by_another ? 'program' : page;
  const another = who && `Another ${who} drives this robot: you can watch it, and stop it.`;
  find('message').textContent = condition.message ?? another;
  find('speed-out').textContent = `${speed().toFixed(2)} m/s`;
}

function floor() {
  const svg = find('floor');
  const last = frames.at(-1);
  if (!last) return;
  const xs = [...path.map(({ x }) => x), last.x];
  const ys = [...path.map(({ y }) => y), last.y];
  const [low, high] = [[Math.min(...xs), Math.min(...ys)], [Math.max(...xs), Math.max(...ys)]];
  // The robot itself is to be seen as well.
  const body = condition.track_width_m ?? 0.3;
  const span = Math.max(2.5, (high[0] - low[0] + body) * 1.1, (high[1] - low[1] + body) * 1.1 * (600 / 360));
  const scale = 600 / span;
  const middle = [(low[0] + high[0]) / 2, (low[1] + high[1]) / 2];
  const at = (x, y) => [300 + (x - middle[0]) * scale, 180 - (y - middle[1]) * scale];
  const step = Chart.step(span / 6);
  const lines = [];
  for (let x = Math.ceil((middle[0] - 300 / scale) / step) * step; x < middle[0] + 300 / scale; x += step) lines.push(`M${at(x, 0)[0].toFixed(1)} 0V360`);
  for (let y = Math.ceil((middle[1] - 180 / scale) / step) * step; y < middle[1] + 180 / scale; y += step) lines.push(`M0 ${at(0, y)[1].toFixed(1)}H600`);
  const driven = [...path, last].map(({ x, y }, k) => `${k ? 'L' : 'M'}${at(x, y).map((value) => value.toFixed(1)).join(' ')}`).join('');
  const [x, y] = at(last.x, last.y);
  const half = Math.max(7, ((condition.track_width_m ?? 0.3) / 2) * scale);
  const shape = (name, attributes) => {
    const made = document.createElementNS('http://www.w3.org/2000/svg', name);
    for (const [attribute, value] of Object.entries(attributes)) made.setAttribute(attribute, value);
    return made;
  };
  const robot = shape('g', { transform: `translate(${x} ${y}) rotate(${(-last.heading * 180) / Math.PI})` });
  robot.append(shape('circle', { class: 'body', r: half }), shape('path', { class: 'wheels', d: `M${-half / 2.5} ${half}h${half / 1.25}M${-half / 2.5} ${-half}h${half / 1.25}` }), shape('path', { class: 'nose', d: `M0 0H${half}` }));
  svg.replaceChildren(shape('path', { class: 'grid', d: lines.join('') }), shape('path', { class: 'driven', d: driven }), robot);
  find('scale').textContent = `a square is ${Number(step.toPrecision(2))} m`;
}

const both = (of) => [
  { of: (frame) => of(frame.left), colour: '--before' },
  { of: (frame) => of(frame.right), colour: '--after' },
];
const charts = [
  new Chart(find('speeds'), [{ of: (frame) => frame.left.wanted, colour: '--line', dashed: true }, { of: (frame) => frame.right.wanted, colour: '--line', dashed: true }, ...both((one) => one.speed)], 0.1),
  new Chart(find('errors'), both((one) => one.error), 2),
  new Chart(find('duties'), both((one) => one.duty), 20),
];

function draw() {
  if (dirty && !document.hidden) {
    dirty = false;
    heading();
    floor();
    charts.forEach((chart) => chart.draw(paused ?? frames, SECONDS));
  }
  requestAnimationFrame(draw);
}

const speed = () => ((condition.speed_mps_max ?? 0) * Number(find('speed').value)) / 100;

// The velocity of a direction: a spin turns the wheels at the chosen speed.
function velocity(forward, turn) {
  const share = Math.abs(forward) + Math.abs(turn) > 1 ? 0.6 : 1;
  return { velocity: { forward_mps: forward * speed() * share, turn_rad_s: (turn * speed() * share) / ((condition.track_width_m ?? 0.3) / 2) } };
}

// Arrow keys and WASD: what is down makes the direction.
const KEYS = { ArrowUp: [1, 0], KeyW: [1, 0], ArrowDown: [-1, 0], KeyS: [-1, 0], ArrowLeft: [0, 1], KeyA: [0, 1], ArrowRight: [0, -1], KeyD: [0, -1] };
const down = new Set();
function keys() {
  if (!down.size) return Drive.release();
  const [forward, turn] = [...down].map((code) => KEYS[code]).reduce((sum, one) => [sum[0] + one[0], sum[1] + one[1]], [0, 0]);
  Drive.change(velocity(Math.sign(forward), Math.sign(turn)));
}

addEventListener('keydown', (event) => {
  if (event.code === 'Space') {
    event.preventDefault();
    down.clear();
    if (!event.repeat) Drive.stop();
  } else if (KEYS[event.code] && event.target.tagName !== 'INPUT' && !event.ctrlKey && !event.metaKey && !event.altKey) {
    event.preventDefault();
    if (!event.repeat) {
      down.add(event.code);
      keys();
    }
  }
}, true);
addEventListener('keyup', (event) => {
  // A button that has the focus would be pressed by the space bar.
  if (event.code === 'Space') event.preventDefault();
  if (down.delete(event.code)) keys();
}, true);
addEventListener('blur', () => down.clear());

for (const button of document.querySelectorAll('.pad button')) {
  const wanted = () => velocity(Number(button.dataset.forward), Number(button.dataset.turn));
  button.addEventListener('pointerdown', (event) => {
    button.setPointerCapture(event.pointerId);
    Drive.begin(wanted());
  });
  for (const end of ['pointerup', 'pointercancel', 'lostpointercapture']) button.addEventListener(end, Drive.release);
  button.addEventListener('contextmenu', (event) => event.preventDefault());
  button.addEventListener('keydown', (event) => event.code === 'Enter' && !event.repeat && Drive.begin(wanted()));
  button.addEventListener('keyup', (event) => event.code === 'Enter' && Drive.release());
  button.addEventListener('blur', Drive.release);
}

function form(id, motion) {
  find(id).addEventListener('submit', (event) => {
    event.preventDefault();
    Drive.begin(motion());
  });
}
form('straight', () => ({ straight: { distance_m: Number(find('distance').value), speed_mps: speed() } }));
form('spin', () => ({ spin: { angle_rad: (Number(find('angle').value) * Math.PI) / 180, speed_mps: speed() } }));

find('stop').addEventListener('click', Drive.stop);
find('cut').addEventListener('click', Drive.cut);
find('clear').addEventListener('click', Drive.clear);
find('speed').addEventListener('input', () => (dirty = true));
find('forget').addEventListener('click', () => {
  path.length = 0;
  dirty = true;
});
find('pause').addEventListener('click', () => {
  paused = paused ? null : [...frames];
  find('pause').setAttribute('aria-pressed', String(Boolean(paused)));
  dirty = true;
});
Drive.onFailure((words) => {
  condition = { ...condition, message: words };
  dirty = true;
});

// A browser has few connections to one server, and a stream takes one for itself: a tab that nobody sees gives it back, so
// that Stop never waits for one.
let source = null;
function listen() {
  source = Drive.telemetry();
  let first = true;
  source.addEventListener('message', ({ data }) => {
    const news = JSON.parse(data);
    condition = news.condition ?? {};
    // A new stream begins with the last ten seconds, some of which are known.
    const known = frames.at(-1)?.t ?? -1;
    const again = first && (news.rows.at(-1)?.[0] ?? 0) * 1e-6 >= known;
    first = false;
    news.rows.filter((row) => !again || row[0] * 1e-6 > known).forEach(take);
    Drive.hear(news.now_ms, condition.ended ?? 0);
    dirty = true;
  });
  source.addEventListener('error', () => {
    condition = { problem: 'beeline serve does not answer', advice: 'start it again; the robot has stopped by itself' };
    first = true;
    dirty = true;
  });
}
addEventListener('visibilitychange', () => (document.hidden ? source.close() : listen()));
listen();
draw();
