// Where the robot has been: by its own counts, as it was commanded, and as a camera sees it.
'use strict';

// Points of a path that have some distance. When there are too many, every second one goes.
class Trace {
  static MOST = 2000;
  static GAP_M = 0.004;

  constructor() {
    [this.xs, this.ys] = [new Float64Array(Trace.MOST), new Float64Array(Trace.MOST)];
    // Where a new piece begins.
    this.begins = new Uint8Array(Trace.MOST);
    this.clear();
  }

  clear() {
    [this.count, this.gap, this.fresh] = [0, Trace.GAP_M, true];
    [this.low, this.high] = [{ x: Infinity, y: Infinity }, { x: -Infinity, y: -Infinity }];
  }

  // What comes next is not joined to what was.
  lift() {
    this.fresh = true;
  }

  add(x, y) {
    const last = this.count - 1;
    if (!this.fresh && Math.hypot(this.xs[last] - x, this.ys[last] - y) < this.gap) return;
    if (this.count === Trace.MOST) this.thin();
    const k = this.count;
    [this.xs[k], this.ys[k], this.begins[k]] = [x, y, this.fresh ? 1 : 0];
    this.count += 1;
    this.fresh = false;
    [this.low.x, this.low.y] = [Math.min(this.low.x, x), Math.min(this.low.y, y)];
    [this.high.x, this.high.y] = [Math.max(this.high.x, x), Math.max(this.high.y, y)];
  }

  thin() {
    let kept = 0;
    let begins = 0;
    for (let k = 0; k < this.count; k += 1) {
      begins |= this.begins[k];
      if (k % 2) continue;
      [this.xs[kept], this.ys[kept], this.begins[kept]] = [this.xs[k], this.ys[k], begins];
      begins = 0;
      kept += 1;
    }
    this.count = kept;
    this.gap *= 2;
  }

  // Draws through a map from metres to pixels, and on to where the robot is now.
  draw(context, { a, b, c, d, e, f }, now) {
    PEN.begin(context);
    for (let k = 0; k < this.count; k += 1) PEN.to(a * this.xs[k] + c * this.ys[k] + e, b * this.xs[k] + d * this.ys[k] + f, this.begins[k]);
    if (now && this.count && !this.fresh) PEN.to(a * now.x + c * now.y + e, b * now.x + d * now.y + f, false);
    PEN.end();
  }
}

// A pose moved by another: `by` says where the frame of `pose` lies.
const placed = (by, { x, y, heading }) => {
  const [cos, sin] = [Math.cos(by.heading), Math.sin(by.heading)];
  return { x: by.x + cos * x - sin * y, y: by.y + sin * x + cos * y, heading: by.heading + heading };
};
const wrapped = (angle) => Math.atan2(Math.sin(angle), Math.cos(angle));
const apart = (one, other) => Math.hypot(one.x - other.x, one.y - other.y);

// The path that was commanded: each wheel's setpoints, from where the robot stood by its counts when the motion began.
class Commanded {
  constructor() {
    Object.assign(this, { trace: new Trace(), pose: null, left: 0, right: 0, driving: false });
  }

  clear() {
    this.trace.clear();
    if (!this.driving) this.pose = null;
  }

  // The newest sample; `track` is the track width [m], `fastest` the largest speed of a wheel [m/s].
  take(history, track, fastest) {
    const state = history.last('state');
    const driving = STATES[state] === 'driving';
    const [left, right] = [history.last('leftSetpoint'), history.last('rightSetpoint')];
    const by = [left - this.left, right - this.right];
    const before = history.end - 2;
    const seconds = before >= history.first ? history.last('t') - history.at('t', before) : 0;
    // Setpoints that jump are those of another motion.
    const most = 1.5 * fastest * seconds + 0.005;
    const begins = (driving && !this.driving) || !this.pose || Math.abs(by[0]) > most || Math.abs(by[1]) > most;
    [this.left, this.right, this.driving] = [left, right, driving];
    if (!Telemetry.moves(state)) return;
    if (begins) {
      this.pose = { x: history.last('x'), y: history.last('y'), heading: history.last('heading') };
      this.trace.lift();
    } else {
      const turn = (by[1] - by[0]) / track;
      const ahead = (by[0] + by[1]) / 2;
      const { pose } = this;
      pose.x += ahead * Math.cos(pose.heading + turn / 2);
      pose.y += ahead * Math.sin(pose.heading + turn / 2);
      pose.heading += turn;
    }
    this.trace.add(this.pose.x, this.pose.y);
  }
}

// The path that a camera sees. It has a frame of its own: that lies so that where the path begins, the camera sees the robot
// where the robot's counts have it. While the robot still stands there, more rows make that surer.
class Seen {
  static ROWS = 50;
  static STILL_M = 0.001;
  static LOST_S = 0.6;
  static CARRIED_M = 0.02;

  constructor() {
    this.trace = new Trace();
    this.restart();
  }

  restart() {
    Object.assign(this, { last: -Infinity, waiting: [] });
    this.clear();
  }

  clear() {
    this.trace.clear();
    Object.assign(this, { start: null, mean: null, rows: 0, still: true, frame: null, raw: null, pose: null, apart: NaN });
  }

  take(row, history) {
    // A frame of the camera may be here before the robot's.
    this.waiting.push(row);
    if (this.waiting.length > 200) this.waiting.shift();
    const newest = history.last('t');
    while (this.waiting.length && !(this.waiting[0][0] * 1e-6 > newest && this.waiting[0][0] * 1e-6 < newest + 2)) this.place(this.waiting.shift(), history);
  }

  place(row, history) {
    if (!history.size) return;
    const t = row[0] * 1e-6;
    const seen = { x: row[1] * 1e-6, y: row[2] * 1e-6, heading: row[3] * 1e-6 };
    const counted = history.pose(t);
    // A robot that is somewhere else although its wheels stood was carried: both begin anew from there.
    if (this.raw && apart(seen, this.raw) > Seen.CARRIED_M && apart(counted, this.counted) < Seen.STILL_M) this.clear();
    this.counted = counted;
    this.start ??= counted;
    this.mean ??= seen;
    this.still &&= this.rows < Seen.ROWS && apart(counted, this.start) < Seen.STILL_M && Math.abs(wrapped(counted.heading - this.start.heading)) < 1e-3 && apart(seen, this.mean) < 0.01;
    if (this.still || !this.rows) {
      this.rows += 1;
      const { mean } = this;
      const share = 1 / this.rows;
      this.mean = { x: mean.x + (seen.x - mean.x) * share, y: mean.y + (seen.y - mean.y) * share, heading: mean.heading + wrapped(seen.heading - mean.heading) * share };
      const turn = this.start.heading - this.mean.heading;
      const back = placed({ x: 0, y: 0, heading: turn }, this.mean);
      this.frame = { x: this.start.x - back.x, y: this.start.y - back.y, heading: turn };
    }
    if (t - this.last > Seen.LOST_S) this.trace.lift();
    this.last = t;
    this.raw = seen;
    this.pose = placed(this.frame, seen);
    this.apart = apart(this.pose, counted);
    this.trace.add(seen.x, seen.y);
  }
}
