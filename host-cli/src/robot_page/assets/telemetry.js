// The telemetry of the last seconds.
'use strict';

const find = (id) => document.getElementById(id);
const STATES = ['boot', 'idle', 'armed', 'driving', 'stopping', 'faulted'];
const SECONDS = 10;
// What is lost for longer is a gap in a line.
const GAP_S = 0.2;

// Telemetry of the last ten seconds, a column for each quantity. Samples are numbered from the first one ever; where number k
// stands is `k & MASK`.
class Telemetry {
  static MASK = 8191;
  static NAMES = ['t', 'state', 'probing', 'x', 'y', 'heading', 'supply', ...['left', 'right'].flatMap((side) => ['Setpoint', 'Error', 'Speed', 'Duty', 'Wanted'].map((name) => side + name))];

  constructor() {
    this.columns = Object.fromEntries(Telemetry.NAMES.map((name) => [name, new Float64Array(Telemetry.MASK + 1)]));
    [this.first, this.end] = [0, 0];
  }

  clear() {
    this.first = this.end;
  }

  get size() {
    return this.end - this.first;
  }

  // A pause keeps what there is.
  copy() {
    const other = new Telemetry();
    for (const name of Telemetry.NAMES) other.columns[name].set(this.columns[name]);
    [other.first, other.end] = [this.first, this.end];
    return other;
  }

  at(name, k) {
    return this.columns[name][k & Telemetry.MASK];
  }

  last(name) {
    return this.size ? this.at(name, this.end - 1) : NaN;
  }

  push(row) {
    const { columns } = this;
    const k = this.end & Telemetry.MASK;
    const past = (this.end - 1) & Telemetry.MASK;
    columns.t[k] = row[0] * 1e-6;
    columns.state[k] = row[1];
    columns.probing[k] = row[2];
    columns.x[k] = row[3] * 1e-6;
    columns.y[k] = row[4] * 1e-6;
    columns.heading[k] = row[5] * 1e-6;
    columns.supply[k] = row[6] * 1e-3;
    // Setpoints come as places: their speed is the change from frame to frame. Where a motion begins or ends they jump.
    const drives = !row[2] && !columns.probing[past];
    const goes = this.size > 0 && drives && Telemetry.moves(row[1]) && columns.state[past] === row[1];
    const step = columns.t[k] - columns.t[past];
    this.wheel('left', k, past, row, 7, goes && step > 0 ? step : 0);
    this.wheel('right', k, past, row, 11, goes && step > 0 ? step : 0);
    this.end += 1;
    this.first = Math.max(this.first, this.end - Telemetry.MASK - 1);
    while (this.at('t', this.first) < columns.t[k] - SECONDS) this.first += 1;
  }

  wheel(side, k, past, row, at, step) {
    const { columns } = this;
    const setpoints = columns[`${side}Setpoint`];
    setpoints[k] = row[at] * 1e-6;
    columns[`${side}Error`][k] = row[at + 1] * 1e-3;
    columns[`${side}Speed`][k] = row[at + 2] * 1e-6;
    columns[`${side}Duty`][k] = row[at + 3] / 327.67;
    columns[`${side}Wanted`][k] = step ? (setpoints[k] - setpoints[past]) / step : 0;
  }

  static moves(state) {
    return STATES[state] === 'driving' || STATES[state] === 'stopping';
  }

  // The first sample that is not before this time.
  from(t) {
    let [low, high] = [this.first, this.end];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.at('t', middle) < t) low = middle + 1;
      else high = middle;
    }
    return low;
  }

  // Where the robot was at this time by its own counts; outside of what is kept, where it was nearest to it.
  pose(t) {
    const after = Math.min(Math.max(this.from(t), this.first), this.end - 1);
    const before = Math.max(after - 1, this.first);
    const [t0, t1] = [this.at('t', before), this.at('t', after)];
    const share = t1 > t0 ? Math.min(Math.max((t - t0) / (t1 - t0), 0), 1) : 1;
    const between = (name) => this.at(name, before) + share * (this.at(name, after) - this.at(name, before));
    return { x: between('x'), y: between('y'), heading: between('heading') };
  }

  // The last frame in one piece.
  latest() {
    if (!this.size) return null;
    const k = this.end - 1;
    const wheel = (side) => ({ setpoint: this.at(`${side}Setpoint`, k), error: this.at(`${side}Error`, k), speed: this.at(`${side}Speed`, k), duty: this.at(`${side}Duty`, k), wanted: this.at(`${side}Wanted`, k) });
    return { t: this.at('t', k), state: STATES[this.at('state', k)], probing: this.at('probing', k) === 1, x: this.at('x', k), y: this.at('y', k), heading: this.at('heading', k), supply: this.at('supply', k), left: wheel('left'), right: wheel('right') };
  }
}

// A number with a minus sign as it is printed; what rounds to zero has none.
function signed(number) {
  const text = String(number);
  return /^-[0.]*$/.test(text) ? text.slice(1) : text.replace('-', '\u2212');
}
