// The floor from above, with all paths on it, to be zoomed and moved.
'use strict';

class Floor {
  static LEAST_M = 2;

  constructor(canvas, changed) {
    Object.assign(this, { canvas, changed, surface: new Surface(canvas, changed), driven: new Trace(), commanded: new Commanded(), seen: new Seen(), view: null, told: 0, predicted: null });
    new FloorView(this);
  }

  // The robot has restarted: nothing of before has a place any more.
  restart() {
    this.clear();
    this.commanded.pose = null;
    this.seen.restart();
  }

  clear() {
    this.driven.clear();
    this.commanded.clear();
    this.seen.clear();
    this.predicted = null;
    this.told = 0;
  }

  take(history, condition) {
    this.driven.add(history.last('x'), history.last('y'));
    this.commanded.take(history, condition.track_width_m || 0.3, condition.speed_mps_max || 1);
  }

  // The part of the floor that has everything in it.
  fitted(now, track) {
    const [low, high] = [{ x: now.x, y: now.y }, { x: now.x, y: now.y }];
    const widen = (x, y) => {
      if (!Number.isFinite(x) || !Number.isFinite(y)) return;
      [low.x, low.y] = [Math.min(low.x, x), Math.min(low.y, y)];
      [high.x, high.y] = [Math.max(high.x, x), Math.max(high.y, y)];
    };
    for (const { low: least, high: most } of [this.driven, this.commanded.trace]) {
      widen(least.x, least.y);
      widen(most.x, most.y);
    }
    const { frame, trace } = this.seen;
    if (frame && trace.count) {
      for (const x of [trace.low.x, trace.high.x]) for (const y of [trace.low.y, trace.high.y]) {
        const corner = placed(frame, { x, y, heading: 0 });
        widen(corner.x, corner.y);
      }
    }
    const { width, height } = this.surface;
    // The robot itself is to be seen as well.
    const room = 1.6 * track;
    const span = Math.max(Floor.LEAST_M, high.x - low.x + room, ((high.y - low.y + room) * width) / height);
    return { x: (low.x + high.x) / 2, y: (low.y + high.y) / 2, scale: width / span };
  }

  draw(history, condition) {
    const context = history.size ? this.surface.begin() : null;
    if (!context) return;
    const { width, height } = this.surface;
    const track = condition.track_width_m || 0.3;
    const now = { x: history.last('x'), y: history.last('y'), heading: history.last('heading') };
    this.shown = this.view ?? this.fitted(now, track);
    const { x, y, scale } = this.shown;
    const map = { a: scale, b: 0, c: 0, d: -scale, e: width / 2 - x * scale, f: height / 2 + y * scale };
    const step = this.grid(context, map, width, height);
    const { seen } = this;
    context.lineJoin = 'round';
    this.band(context, map);
    context.globalAlpha = 0.6;
    context.lineCap = 'butt';
    this.line(context, this.commanded.trace, map, null, COLOURS.line, 7, [6, 7]);
    context.globalAlpha = 1;
    context.lineCap = 'round';
    if (seen.frame) {
      const [cos, sin] = [scale * Math.cos(seen.frame.heading), scale * Math.sin(seen.frame.heading)];
      const there = { a: cos, b: -sin, c: -sin, d: -cos, e: map.e + scale * seen.frame.x, f: map.f - scale * seen.frame.y };
      this.line(context, seen.trace, there, seen.raw, COLOURS.before, 2.5, []);
    }
    this.line(context, this.driven, map, now, COLOURS.after, 3, []);
    if (this.driven.count) this.dot(context, map, this.driven.xs[0], this.driven.ys[0]);
    if (seen.pose) this.robot(context, map, seen.pose, track, COLOURS.before, 0.4);
    this.robot(context, map, now, track, COLOURS.after, 1);
    this.tell(history, step);
  }

  // Where a model predicts the robot: its path, and two sigma to either side.
  band(context, { a, e, f }) {
    const points = this.predicted?.points;
    if (!points || points.length < 2) return;
    const at = ([x, y, heading, sigma], side) => [a * (x - 2 * side * sigma * Math.sin(heading)) + e, f - a * (y + 2 * side * sigma * Math.cos(heading))];
    [context.fillStyle, context.strokeStyle, context.lineWidth] = [COLOURS.line, COLOURS.ink, 1.5];
    context.beginPath();
    for (const point of points) context.lineTo(...at(point, 1));
    for (let k = points.length - 1; k >= 0; k -= 1) context.lineTo(...at(points[k], -1));
    context.globalAlpha = 0.3;
    context.fill();
    context.globalAlpha = 1;
    context.beginPath();
    for (const point of points) context.lineTo(...at(point, 0));
    context.stroke();
  }

  line(context, trace, map, now, colour, width, dashes) {
    [context.strokeStyle, context.lineWidth] = [colour, width];
    context.setLineDash(dashes);
    trace.draw(context, map, now);
    context.setLineDash([]);
  }

  grid(context, { a, e, f }, width, height) {
    const step = Chart.step(width / a / 6);
    [context.strokeStyle, context.lineWidth] = [COLOURS.faint, 1];
    context.beginPath();
    for (let k = Math.ceil(-e / a / step); k * step * a + e < width; k += 1) {
      const x = Math.round(k * step * a + e) + 0.5;
      context.moveTo(x, 0);
      context.lineTo(x, height);
    }
    for (let k = Math.ceil((f - height) / a / step); f - k * step * a > 0; k += 1) {
      const y = Math.round(f - k * step * a) + 0.5;
      context.moveTo(0, y);
      context.lineTo(width, y);
    }
    context.stroke();
    return step;
  }

  // Where the path begins.
  dot(context, { a, e, f }, x, y) {
    [context.fillStyle, context.strokeStyle, context.lineWidth] = [COLOURS.paper, COLOURS.after, 2.5];
    context.beginPath();
    context.arc(a * x + e, f - a * y, 5, 0, 2 * Math.PI);
    context.fill();
    context.stroke();
  }

  robot(context, { a, e, f }, { x, y, heading }, track, colour, opacity) {
    // From above, the track is two units wide; a robot that would be too small to see is larger than it is.
    const half = Math.max((track / 2) * a, 9);
    context.save();
    context.translate(a * x + e, f - a * y);
    context.rotate(-heading);
    context.scale(half, half);
    [context.globalAlpha, context.strokeStyle, context.fillStyle] = [opacity, colour, COLOURS.paper];
    context.lineWidth = 0.1;
    context.beginPath();
    context.roundRect(-0.8, -0.72, 1.6, 1.44, 0.3);
    context.fill();
    context.stroke();
    context.lineWidth = 0.24;
    context.beginPath();
    for (const side of [-1, 1]) {
      context.moveTo(-0.4, side);
      context.lineTo(0.4, side);
    }
    context.stroke();
    context.lineWidth = 0.12;
    context.beginPath();
    context.moveTo(0.2, -0.3);
    context.lineTo(0.5, 0);
    context.lineTo(0.2, 0.3);
    context.stroke();
    context.restore();
  }

  tell(history, step) {
    const now = performance.now();
    if (now - this.told < Timeline.TOLD_EVERY_MS) return;
    this.told = now;
    const { seen } = this;
    find('scale').textContent = `a square is ${Number(step.toPrecision(2))} m`;
    find('fit').setAttribute('aria-pressed', String(!this.view));
    find('predicted').hidden = !this.predicted;
    find('predicted-of').textContent = this.predicted ? `predicted, \u00b1 2 sigma (${this.predicted.of})` : '';
    for (const each of document.querySelectorAll('.camera')) each.hidden = !seen.pose;
    if (!seen.pose) return;
    const lost = history.last('t') - seen.last > Seen.LOST_S;
    const millimetres = seen.apart * 1e3;
    find('apart').textContent = lost ? '\u2013' : `${millimetres.toFixed(millimetres < 100 ? 1 : 0)} mm`;
    find('apart-words').textContent = lost ? 'the camera does not see the robot' : 'from camera to odometry';
  }
}

// Zooms and moves the floor: wheel, pinch, drag, keys and buttons. Until then, and after "Fit", everything is in view.
class FloorView {
  // Pixels for a metre.
  static LEAST = 2;
  static MOST = 5000;

  constructor(floor) {
    Object.assign(this, { floor, pointers: new Map() });
    const { canvas } = floor;
    canvas.addEventListener('wheel', (event) => {
      event.preventDefault();
      this.zoom(Math.exp(-event.deltaY * (event.deltaMode ? 0.05 : 0.0015)), this.place(event));
    }, { passive: false });
    // A click must not take the arrow keys away from the robot.
    canvas.addEventListener('mousedown', (event) => event.preventDefault());
    canvas.addEventListener('pointerdown', (event) => {
      canvas.setPointerCapture(event.pointerId);
      this.pointers.set(event.pointerId, this.place(event));
    });
    canvas.addEventListener('pointermove', (event) => this.drag(event));
    for (const end of ['pointerup', 'pointercancel', 'lostpointercapture']) canvas.addEventListener(end, ({ pointerId }) => this.pointers.delete(pointerId));
    canvas.addEventListener('keydown', (event) => this.key(event));
    find('nearer').addEventListener('click', () => this.zoom(1.4));
    find('farther').addEventListener('click', () => this.zoom(1 / 1.4));
    find('fit').addEventListener('click', () => this.fit());
  }

  place({ clientX, clientY }) {
    const { left, top } = this.floor.canvas.getBoundingClientRect();
    return { x: clientX - left, y: clientY - top };
  }

  change(view) {
    this.floor.view = view;
    this.floor.told = 0;
    // A finger scrolls the page up and down over a floor that is all in view.
    this.floor.canvas.classList.toggle('moved', Boolean(view));
    this.floor.changed();
  }

  fit() {
    this.change(null);
  }

  // What is at this place stays there.
  zoom(factor, place) {
    const { shown, surface } = this.floor;
    if (!shown) return;
    const scale = Math.min(Math.max(shown.scale * factor, FloorView.LEAST), FloorView.MOST);
    const [dx, dy] = place ? [place.x - surface.width / 2, place.y - surface.height / 2] : [0, 0];
    const by = 1 / shown.scale - 1 / scale;
    this.floor.shown = { x: shown.x + dx * by, y: shown.y - dy * by, scale };
    this.change(this.floor.shown);
  }

  move(dx, dy) {
    const { shown } = this.floor;
    if (!shown) return;
    this.floor.shown = { x: shown.x - dx / shown.scale, y: shown.y + dy / shown.scale, scale: shown.scale };
    this.change(this.floor.shown);
  }

  drag(event) {
    const last = this.pointers.get(event.pointerId);
    if (!last) return;
    const here = this.place(event);
    const [other] = [...this.pointers].filter(([id]) => id !== event.pointerId).map(([, place]) => place);
    this.pointers.set(event.pointerId, here);
    const share = other ? 0.5 : 1;
    if (other) this.zoom(Math.hypot(here.x - other.x, here.y - other.y) / Math.max(Math.hypot(last.x - other.x, last.y - other.y), 10), { x: (here.x + other.x) / 2, y: (here.y + other.y) / 2 });
    this.move((here.x - last.x) * share, (here.y - last.y) * share);
  }

  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const acts = {
      ArrowLeft: () => this.move(60, 0),
      ArrowRight: () => this.move(-60, 0),
      ArrowUp: () => this.move(0, 60),
      ArrowDown: () => this.move(0, -60),
      '+': () => this.zoom(1.4),
      '=': () => this.zoom(1.4),
      '-': () => this.zoom(1 / 1.4),
      0: () => this.fit(),
    };
    if (!acts[event.key]) return;
    event.preventDefault();
    acts[event.key]();
  }
}
