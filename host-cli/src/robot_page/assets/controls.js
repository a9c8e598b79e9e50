// Arrow keys, buttons, the stick, and motions of a given length.
'use strict';

// Whoever has the focus here uses arrow keys and letters otherwise.
const OWN_KEYS = 'input, select, textarea, [role=tablist], [role=log], [contenteditable]';
const isSeen = (element) => element.getClientRects().length > 0;

const speed = () => ((Robot.condition().speed_mps_max ?? 0) * Number(find('speed').value)) / 100;
const mayDrive = () => !Robot.condition().procedure_drives;

// The velocity of a direction: a spin turns the wheels at the chosen speed.
function velocity(forward, turn) {
  const share = Math.abs(forward) + Math.abs(turn) > 1 ? 0.5 : 1;
  return turned(forward * share, turn * share);
}

// Shares of the chosen speed: of the middle, and of the wheels against each other, to the left positive.
function turned(forward, turn) {
  return { velocity: { forward_mps: forward * speed(), turn_rad_s: (turn * speed()) / ((Robot.condition().track_width_m ?? 0.3) / 2) } };
}

// Arrow keys and WASD: what is down makes the direction.
const KEYS = { ArrowUp: [1, 0], KeyW: [1, 0], ArrowDown: [-1, 0], KeyS: [-1, 0], ArrowLeft: [0, 1], KeyA: [0, 1], ArrowRight: [0, -1], KeyD: [0, -1] };
const down = new Set();
function keys() {
  if (!down.size) return Drive.release();
  const [forward, turn] = [...down].map((code) => KEYS[code]).reduce((sum, one) => [sum[0] + one[0], sum[1] + one[1]], [0, 0]);
  Drive.change(velocity(Math.sign(forward), Math.sign(turn)));
}

// Where arrows move something else: the floor when it has the focus, the charts while they are paused.
function movesView({ target }) {
  return target === find('floor') || (Robot.isPaused() && Boolean(target.closest('.charts')));
}

addEventListener('keydown', (event) => {
  if (event.code === 'Space') {
    event.preventDefault();
    down.clear();
    if (!event.repeat) Drive.stop();
  } else if (KEYS[event.code] && !event.target.closest(OWN_KEYS) && !event.ctrlKey && !event.metaKey && !event.altKey) {
    if (!isSeen(find('controls')) || (event.key.startsWith('Arrow') && movesView(event))) return;
    event.preventDefault();
    if (!event.repeat && mayDrive()) {
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
    if (mayDrive()) Drive.begin(wanted());
  });
  for (const end of ['pointerup', 'pointercancel', 'lostpointercapture']) button.addEventListener(end, Drive.release);
  button.addEventListener('contextmenu', (event) => event.preventDefault());
  button.addEventListener('keydown', (event) => event.code === 'Enter' && !event.repeat && mayDrive() && Drive.begin(wanted()));
  button.addEventListener('keyup', (event) => event.code === 'Enter' && Drive.release());
  button.addEventListener('blur', Drive.release);
}

// The stick: it drives only while the pointer that took it holds it.
const Stick = (() => {
  // As shares of the way that the knob can go.
  const DEAD = 0.14;
  const stick = find('stick');
  const knob = find('knob');
  let pointer = null;
  let begun = false;
  let middle = null;

  // How far the knob's middle can go [px].
  const reach = () => (stick.clientWidth - knob.offsetWidth) / 2 - 4;

  function show(x, y, share) {
    knob.style.transform = x || y ? `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px)` : '';
    stick.classList.toggle('held', pointer !== null);
    stick.classList.toggle('drives', share > 0);
    find('stick-out').textContent = pointer === null ? '' : `${(share * speed()).toFixed(2)} m/s`;
  }

  function letGo() {
    if (pointer === null) return;
    const held = pointer;
    [pointer, begun] = [null, false];
    if (stick.hasPointerCapture(held)) stick.releasePointerCapture(held);
    show(0, 0, 0);
  }

  // Up is forward, left turns left. The distance from the middle is the share of the chosen speed that the faster wheel gets.
  function follow({ clientX, clientY }) {
    const [x, y] = [clientX - middle.x, clientY - middle.y];
    const far = Math.hypot(x, y) / reach();
    const share = Math.max(Math.min(far, 1) - DEAD, 0) / (1 - DEAD);
    const short = 1 / Math.max(far, 1);
    show(x * short, y * short, share);
    if (!share && !begun) return;
    begun = true;
    const both = Math.abs(x) + Math.abs(y) || 1;
    Drive.change(turned((-y / both) * share, (-x / both) * share));
  }

  stick.addEventListener('pointerdown', (event) => {
    if (pointer !== null || event.button !== 0 || !mayDrive()) return;
    event.preventDefault();
    stick.setPointerCapture(event.pointerId);
    pointer = event.pointerId;
    // While it is held, its middle stays where it was, even if the page below it moves.
    const { left, top, width, height } = stick.getBoundingClientRect();
    middle = { x: left + width / 2, y: top + height / 2 };
    follow(event);
  });
  stick.addEventListener('pointermove', (event) => {
    if (event.pointerId === pointer) follow(event);
  });
  for (const end of ['pointerup', 'pointercancel', 'lostpointercapture']) {
    stick.addEventListener(end, (event) => event.pointerId === pointer && Drive.release());
  }
  // No text is selected by what moves the robot.
  stick.addEventListener('mousedown', (event) => event.preventDefault());
  stick.addEventListener('contextmenu', (event) => event.preventDefault());
  // Stop, a fault, another window in front: the stick has to be taken anew.
  Drive.onLetGo(letGo);
  return { isHeld: () => pointer !== null };
})();

function form(id, motion) {
  find(id).addEventListener('submit', (event) => {
    event.preventDefault();
    const wanted = motion();
    if (wanted && mayDrive()) Drive.begin(wanted);
  });
}

// The number in a field; if there is none, the field says so.
function number(id, holds = Number.isFinite) {
  const field = find(id);
  const value = field.valueAsNumber;
  if (holds(value)) return value;
  field.setCustomValidity(field.title);
  field.reportValidity();
  return NaN;
}
for (const field of document.querySelectorAll('#controls input[type=number]')) field.addEventListener('input', () => field.setCustomValidity(''));

const radians = (degrees) => (degrees * Math.PI) / 180;
const known = (...values) => values.every(Number.isFinite);
form('straight', () => {
  const distance_m = number('distance', (metres) => Math.abs(metres) > 0);
  return known(distance_m) && { straight: { distance_m, speed_mps: speed() } };
});
form('arc', () => {
  const radius_m = number('radius', (metres) => metres > 0);
  const angle_rad = radians(number('arc-angle', (degrees) => Math.abs(degrees) > 0));
  return known(radius_m, angle_rad) && { arc: { radius_m, angle_rad, speed_mps: speed() } };
});
form('spin', () => {
  const angle_rad = radians(number('angle', (degrees) => Math.abs(degrees) > 0));
  return known(angle_rad) && { spin: { angle_rad, speed_mps: speed() } };
});

find('stop').addEventListener('click', Drive.stop);
find('cut').addEventListener('click', Drive.cut);
find('clear').addEventListener('click', Drive.clear);
