// Lines over the last seconds. Nothing here is made or looked at anew for each sample of each drawn frame.
'use strict';

// The style sheet's colours, asked once for each scheme: to ask for each drawn frame is slow.
const COLOURS = {};
function readColours() {
  const style = getComputedStyle(document.documentElement);
  for (const name of ['paper', 'ink', 'soft', 'faint', 'line', 'before', 'after']) COLOURS[name] = style.getPropertyValue(`--${name}`).trim();
}
readColours();

// A canvas in the window's pixels; `changed` is called when what it shows no longer fits.
class Surface {
  constructor(canvas, changed) {
    Object.assign(this, { canvas, changed, width: 0, height: 0, context: canvas.getContext('2d') });
    new ResizeObserver(([{ contentRect }]) => {
      [this.width, this.height] = [contentRect.width, contentRect.height];
      changed();
    }).observe(canvas);
  }

  // An empty context, or null while nobody sees it.
  begin() {
    const { canvas, context, width, height } = this;
    if (!width || !height) return null;
    const ratio = devicePixelRatio;
    const [across, along] = [Math.round(width * ratio), Math.round(height * ratio)];
    if (canvas.width !== across) canvas.width = across;
    if (canvas.height !== along) canvas.height = along;
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, width, height);
    return context;
  }
}

// A line through many points, of which only those are drawn that it needs: the others are nearer to it than a fraction of a
// pixel. Long lines are slow to stroke.
class Pen {
  static NEAR = 0.3;

  begin(context) {
    this.context = context;
    this.open = false;
    context.beginPath();
  }

  to(x, y, lifted) {
    if (lifted || !this.open) {
      this.end(false);
      this.open = true;
      this.context.moveTo(x, y);
      [this.fromX, this.fromY, this.x, this.y] = [x, y, x, y];
      this.free();
      return;
    }
    if (!this.holds(x, y)) {
      this.context.lineTo(this.x, this.y);
      [this.fromX, this.fromY] = [this.x, this.y];
      this.free();
      this.holds(x, y);
    }
    [this.x, this.y] = [x, y];
  }

  free() {
    [this.middle, this.low, this.high] = [NaN, -Infinity, Infinity];
  }

  // Whether one line from the last corner goes near this point and near all points since; then directions narrow to those.
  holds(x, y) {
    const [dx, dy] = [x - this.fromX, y - this.fromY];
    const far = Math.hypot(dx, dy);
    if (far < Pen.NEAR) return true;
    const angle = Math.atan2(dy, dx);
    if (Number.isNaN(this.middle)) this.middle = angle;
    let by = angle - this.middle;
    if (by > Math.PI) by -= 2 * Math.PI;
    else if (by < -Math.PI) by += 2 * Math.PI;
    if (by < this.low || by > this.high) return false;
    const room = Math.asin(Pen.NEAR / far);
    [this.low, this.high] = [Math.max(this.low, by - room), Math.min(this.high, by + room)];
    // Back towards the corner is another line.
    const [pastX, pastY] = [this.x - this.fromX, this.y - this.fromY];
    return far > Math.hypot(pastX, pastY) - Pen.NEAR;
  }

  end(stroked = true) {
    if (this.open) this.context.lineTo(this.x, this.y);
    if (stroked) this.context.stroke();
  }
}
const PEN = new Pen();

// One line of a chart: of each column of pixels the least and the largest value.
class Line {
  static MASK = 4095;

  constructor(column, words, colour, dashed = false) {
    Object.assign(this, { column, words, colour, dashed, history: null });
    for (const name of ['least', 'most']) this[name] = new Float32Array(Line.MASK + 1);
    this.time = new Float64Array(Line.MASK + 1);
    this.begins = new Uint8Array(Line.MASK + 1);
  }

  // Columns stand at multiples of their width in time: so they do not flicker while time goes on, and those of before stay.
  gather(history, from, to, width) {
    const goesOn = history === this.history && width === this.width && from >= this.since && this.next >= history.first && this.next <= history.end;
    if (!goesOn) Object.assign(this, { history, width, next: Math.max(history.from(from) - 1, history.first), first: 0, end: 0, here: NaN, before: -Infinity });
    this.since = from;
    const { time, least, most, begins } = this;
    const [times, values] = [history.columns.t, history.columns[this.column]];
    const stop = Math.min(history.from(to) + 1, history.end);
    for (; this.next < stop; this.next += 1) {
      const t = times[this.next & Telemetry.MASK];
      const value = values[this.next & Telemetry.MASK];
      const here = Math.floor(t / width);
      const gap = t - this.before >= GAP_S;
      if (gap || here !== this.here) {
        const n = this.end & Line.MASK;
        [time[n], least[n], most[n], begins[n]] = [t, value, value, gap ? 1 : 0];
        this.here = here;
        this.end += 1;
      } else {
        const n = (this.end - 1) & Line.MASK;
        if (value < least[n]) least[n] = value;
        if (value > most[n]) most[n] = value;
      }
      this.before = t;
    }
    this.first = Math.max(this.first, this.end - Line.MASK - 1);
    while (this.first + 1 < this.end && time[(this.first + 1) & Line.MASK] <= from) this.first += 1;
    this.samples = stop - history.from(from);
  }

  low() {
    let low = 0;
    for (let n = this.first; n < this.end; n += 1) low = Math.min(low, this.least[n & Line.MASK]);
    return low;
  }

  high() {
    let high = 0;
    for (let n = this.first; n < this.end; n += 1) high = Math.max(high, this.most[n & Line.MASK]);
    return high;
  }

  // From times and values to pixels: x = left + across * (time - since), y = zero - up * value.
  draw(context, left, across, zero, up) {
    // Columns of several samples each are a band; fewer samples are points on a line.
    if (this.samples > 1.5 * (this.end - this.first) && !this.dashed) this.band(context, left, across, zero, up);
    else this.stroke(context, left, across, zero, up);
  }

  stroke(context, left, across, zero, up) {
    const { time, least, most, begins, since } = this;
    PEN.begin(context);
    for (let k = this.first; k < this.end; k += 1) {
      const n = k & Line.MASK;
      PEN.to(left + across * (time[n] - since), zero - (up * (least[n] + most[n])) / 2, begins[n]);
    }
    PEN.end();
  }

  // An area is filled much faster than a line that goes up and down in each column is stroked.
  band(context, left, across, zero, up) {
    context.beginPath();
    for (let k = this.first, first = k; k < this.end; k += 1) {
      if (k + 1 < this.end && !this.begins[(k + 1) & Line.MASK]) continue;
      this.piece(context, first, k, left, across, zero, up);
      first = k + 1;
    }
    context.fill();
  }

  piece(context, first, last, left, across, zero, up) {
    const { time, least, most, since } = this;
    const half = context.lineWidth / 2;
    const x = (k) => left + across * (time[k & Line.MASK] - since);
    // Each column reaches as far as its neighbours: a steep line has no gaps.
    const top = (k) => zero - half - up * Math.max(most[k & Line.MASK], least[Math.max(k - 1, first) & Line.MASK], least[Math.min(k + 1, last) & Line.MASK]);
    const bottom = (k) => zero + half - up * Math.min(least[k & Line.MASK], most[Math.max(k - 1, first) & Line.MASK], most[Math.min(k + 1, last) & Line.MASK]);
    context.moveTo(x(first) - half, top(first));
    for (let k = first; k <= last; k += 1) context.lineTo(x(k), top(k));
    context.lineTo(x(last) + half, top(last));
    context.lineTo(x(last) + half, bottom(last));
    for (let k = last; k >= first; k -= 1) context.lineTo(x(k), bottom(k));
    context.lineTo(x(first) - half, bottom(first));
    context.closePath();
  }
}

class Chart {
  static LEFT = 46;
  static RIGHT = 6;
  // Pixels of a column in which only the least and the largest value are drawn.
  static COLUMN = 1.5;

  // `least` is the smallest range of values shown; `digits` are those of a value in words.
  constructor(canvas, lines, least, digits, changed) {
    Object.assign(this, { canvas, lines, least, digits, surface: new Surface(canvas, changed) });
    this.readout = document.createElement('span');
    this.readout.className = 'readout';
    this.when = document.createElement('span');
    this.values = lines.map(({ words, colour }) => {
      const value = document.createElement('b');
      const label = document.createElement('span');
      label.className = `value ${colour}`;
      label.append(words, ' ', value);
      this.readout.append(label, ' ');
      return value;
    });
    canvas.parentElement.querySelector('figcaption').append(' ', this.when, ' ', this.readout);
    // Setpoints lie over what follows them.
    this.order = [...lines].sort((one, other) => Number(one.dashed) - Number(other.dashed));
  }

  // The time at a place in the window, as a share of what is shown.
  share(clientX) {
    const { left, width } = this.canvas.getBoundingClientRect();
    return Math.min(Math.max((clientX - left - Chart.LEFT) / (width - Chart.LEFT - Chart.RIGHT), 0), 1);
  }

  // Samples from `end - span` to `end`; what the labels count from is `zero`.
  draw(history, { end, span, zero, cursor }) {
    const context = this.surface.begin();
    if (!context) return;
    const { width, height } = this.surface;
    const [left, top, bottom] = [Chart.LEFT, 6, height - 20];
    const across = (width - left - Chart.RIGHT) / span;
    const from = end - span;
    for (const line of this.lines) line.gather(history, from, end, Chart.COLUMN / across);
    let low = Math.min(...this.lines.map((line) => line.low()));
    let high = Math.max(...this.lines.map((line) => line.high()));
    const room = Math.max(this.least - high + low, 0) / 2 + 0.08 * Math.max(high - low, this.least);
    [low, high] = [low - room, high + room];
    const up = (bottom - top) / (high - low);
    const level = bottom + low * up;
    this.axes(context, { low, high, up, level, across, from, end, span, zero, bottom, width });
    context.save();
    context.beginPath();
    context.rect(left, 0, width - left - Chart.RIGHT + 1, bottom + 2);
    context.clip();
    context.lineJoin = 'round';
    for (const line of this.order) {
      context.lineWidth = line.dashed ? 1.2 : 1.8;
      [context.strokeStyle, context.fillStyle] = [COLOURS[line.colour], COLOURS[line.colour]];
      context.setLineDash(line.dashed ? [5, 4] : []);
      line.draw(context, left, across, level, up);
    }
    context.setLineDash([]);
    if (cursor !== null) this.mark(context, history, left + across * (cursor - from), cursor, level, up, bottom);
    context.restore();
  }

  axes(context, { low, high, up, level, across, from, end, span, zero, bottom, width }) {
    const left = Chart.LEFT;
    context.font = '12px system-ui,-apple-system,"Segoe UI",Roboto,sans-serif';
    context.fillStyle = COLOURS.soft;
    context.lineWidth = 1;
    const step = Chart.step((high - low) / 4.2);
    context.textAlign = 'right';
    for (let k = Math.ceil(low / step); k * step <= high; k += 1) {
      const y = Math.round(level - up * k * step) + 0.5;
      context.strokeStyle = k ? COLOURS.faint : COLOURS.line;
      context.beginPath();
      context.moveTo(left, y);
      context.lineTo(width - Chart.RIGHT, y);
      context.stroke();
      if (y < bottom - 2) context.fillText(signed(Number((k * step).toPrecision(3))), left - 8, y + 4);
    }
    context.textAlign = 'center';
    const every = Chart.step(span / 5.01);
    for (let k = Math.ceil((zero - end) / every); zero - k * every >= from - 1e-9; k += 1) {
      const x = left + across * (zero - k * every - from);
      context.fillText(k ? `${signed(-Number((k * every).toPrecision(3)))} s` : 'now', Math.min(x, width - 17), bottom + 16);
    }
  }

  // The values at the cursor.
  mark(context, history, x, cursor, level, up, bottom) {
    context.strokeStyle = COLOURS.ink;
    context.lineWidth = 1;
    context.beginPath();
    context.moveTo(x, 0);
    context.lineTo(x, bottom);
    context.stroke();
    const k = Chart.nearest(history, cursor);
    if (k === null) return;
    for (const line of this.lines) {
      context.fillStyle = COLOURS[line.colour];
      context.beginPath();
      context.arc(x, level - up * history.at(line.column, k), 3.5, 0, 2 * Math.PI);
      context.fill();
    }
  }

  // In words, what the lines are at this time.
  tell(history, t, when) {
    const k = Chart.nearest(history, t);
    this.when.textContent = when;
    this.lines.forEach((line, n) => {
      this.values[n].textContent = k === null ? '\u2013' : signed(history.at(line.column, k).toFixed(this.digits));
    });
  }

  static nearest(history, t) {
    if (!history.size) return null;
    const after = Math.min(history.from(t), history.end - 1);
    const before = Math.max(after - 1, history.first);
    const k = t - history.at('t', before) < history.at('t', after) - t ? before : after;
    return Math.abs(history.at('t', k) - t) < GAP_S ? k : null;
  }

  // 1, 2 or 5 times a power of ten.
  static step(rough) {
    const power = 10 ** Math.floor(Math.log10(rough));
    return power * ([1, 2, 5].find((step) => step * power >= rough * 0.999) ?? 10);
  }
}
