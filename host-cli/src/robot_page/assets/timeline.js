// What of the last seconds the charts show: how much, up to when, and the values under a pointer.
'use strict';

class Timeline {
  static SPANS = [0.5, 1, 2, 5, 10];
  // A number that changes at every frame cannot be read.
  static TOLD_EVERY_MS = 200;

  constructor(charts, history, changed) {
    // `end` is the last time shown while paused. The cursor is a share of what is shown while live, and a time while paused.
    Object.assign(this, { charts, history, changed, span: SECONDS, kept: null, end: 0, cursor: null, pointers: new Map(), pinch: null, told: 0 });
    for (const chart of charts) this.listen(chart);
    find('pause').addEventListener('click', () => this.pause());
    find('shorter').addEventListener('click', () => this.step(-1));
    find('longer').addEventListener('click', () => this.step(1));
    find('earlier').addEventListener('click', () => this.pan(-this.span / 2));
    find('later').addEventListener('click', () => this.pan(this.span / 2));
    addEventListener('keydown', (event) => this.zoomKey(event));
  }

  get shown() {
    return this.kept ?? this.history;
  }

  // The newest time there is.
  get zero() {
    return this.shown.last('t') || 0;
  }

  get until() {
    return this.kept ? this.end : this.zero;
  }

  pause() {
    const cursor = this.cursorTime();
    this.kept = this.kept ? null : this.history.copy();
    this.end = this.zero;
    this.cursor = this.kept ? cursor : null;
    find('pause').setAttribute('aria-pressed', String(Boolean(this.kept)));
    this.told = 0;
    this.changed();
  }

  cursorTime() {
    if (this.cursor === null) return null;
    return this.kept ? this.cursor : this.until - this.span * (1 - this.cursor);
  }

  point(share) {
    this.cursor = share === null || !this.kept ? share : this.until - this.span * (1 - share);
    this.told = 0;
    this.changed();
  }

  // Shows so many seconds; while paused, what is at this share of the window stays there. False if nothing changes.
  zoom(span, share = 1) {
    const [least, most] = [Timeline.SPANS[0], Timeline.SPANS.at(-1)];
    const wanted = Math.min(Math.max(span, least), most);
    if (wanted === this.span) return false;
    const there = this.until - this.span * (1 - share);
    this.span = wanted;
    if (this.kept) this.end = there + this.span * (1 - share);
    this.pan(0);
    return true;
  }

  step(by) {
    const { SPANS } = Timeline;
    const next = by > 0 ? SPANS.find((span) => span > this.span * 1.01) : SPANS.findLast((span) => span < this.span * 0.99);
    const cursor = this.cursorTime();
    if (next) this.zoom(next, this.kept && cursor !== null ? 1 - (this.until - cursor) / this.span : 1);
  }

  // Moves in time, as far as there is something.
  pan(seconds) {
    if (this.kept && this.kept.size) {
      const first = this.kept.at('t', this.kept.first);
      this.end = Math.min(Math.max(this.end + seconds, Math.min(first + this.span, this.zero)), this.zero);
    }
    this.told = 0;
    this.changed();
  }

  // By key, the cursor moves, and takes the window with it.
  move(seconds) {
    const first = this.shown.size ? this.shown.at('t', this.shown.first) : 0;
    const cursor = Math.min(Math.max((this.cursorTime() ?? this.until) + seconds, first), this.zero);
    this.cursor = cursor;
    this.pan(Math.min(cursor - (this.until - this.span), 0) + Math.max(cursor - this.until, 0));
  }

  listen(chart) {
    const { canvas } = chart;
    canvas.addEventListener('wheel', (event) => {
      if (this.kept && Math.abs(event.deltaX) > Math.abs(event.deltaY)) {
        event.preventDefault();
        return this.pan((event.deltaX * this.span) / this.charts[0].surface.width);
      }
      // At the ends of the range the page scrolls on.
      if (this.zoom(this.span * Math.exp(event.deltaY * (event.deltaMode ? 0.05 : 0.0015)), chart.share(event.clientX))) event.preventDefault();
    }, { passive: false });
    // A click must not take the arrow keys away from the robot, unless they are to move in time.
    canvas.addEventListener('mousedown', (event) => !this.kept && event.preventDefault());
    canvas.addEventListener('pointerdown', (event) => this.press(chart, event));
    canvas.addEventListener('pointermove', (event) => this.drag(chart, event));
    for (const end of ['pointerup', 'pointercancel', 'lostpointercapture', 'pointerleave']) canvas.addEventListener(end, (event) => this.lift(event, end));
    canvas.addEventListener('keydown', (event) => this.timeKey(event));
    canvas.addEventListener('blur', () => !this.pointers.size && this.point(null));
  }

  press(chart, event) {
    chart.canvas.setPointerCapture(event.pointerId);
    this.pointers.set(event.pointerId, event.clientX);
    this.pinch = this.pointers.size === 2 ? { apart: this.apart(), span: this.span } : null;
    this.point(chart.share(event.clientX));
  }

  apart() {
    const [one, other] = [...this.pointers.values()];
    return Math.max(Math.abs(one - other), 20);
  }

  drag(chart, event) {
    const last = this.pointers.get(event.pointerId);
    if (last !== undefined) {
      this.pointers.set(event.pointerId, event.clientX);
      if (this.pinch && this.pointers.size === 2) {
        const middle = [...this.pointers.values()].reduce((sum, x) => sum + x / 2, 0);
        this.zoom((this.pinch.span * this.pinch.apart) / this.apart(), chart.share(middle));
        return;
      }
      const { width } = chart.canvas.getBoundingClientRect();
      if (this.kept) this.pan(((last - event.clientX) * this.span) / (width - Chart.LEFT - Chart.RIGHT));
    }
    this.point(chart.share(event.clientX));
  }

  // Over a chart a mouse shows values without a button; a finger leaves them there while paused.
  lift(event, end) {
    this.pointers.delete(event.pointerId);
    if (this.pointers.size < 2) this.pinch = null;
    const left = event.pointerType === 'mouse' ? end === 'pointerleave' : end !== 'pointerleave' && !this.kept;
    if (left) this.point(null);
  }

  timeKey(event) {
    if (!this.kept || event.ctrlKey || event.metaKey || event.altKey) return;
    const step = (this.span / 50) * (event.shiftKey ? 10 : 1);
    const moves = { ArrowLeft: -step, ArrowRight: step, PageUp: -this.span / 2, PageDown: this.span / 2, Home: -2 * SECONDS, End: 2 * SECONDS };
    if (!(event.key in moves)) return;
    event.preventDefault();
    this.move(moves[event.key]);
  }

  zoomKey(event) {
    if (event.defaultPrevented || event.ctrlKey || event.metaKey || event.altKey || event.target.closest(OWN_KEYS) || !isSeen(find('pause'))) return;
    if (event.key === '+' || event.key === '=') this.step(-1);
    else if (event.key === '-' || event.key === '_') this.step(1);
  }

  draw(chart) {
    chart.draw(this.shown, { end: this.until, span: this.span, zero: this.zero, cursor: this.cursorTime() });
  }

  tell() {
    const now = performance.now();
    if (now - this.told < Timeline.TOLD_EVERY_MS) return;
    this.told = now;
    const t = this.cursorTime() ?? this.zero;
    const back = this.zero - t;
    for (const chart of this.charts) chart.tell(this.shown, t, back < 0.005 ? 'now' : `${signed((-back).toFixed(2))} s`);
    const span = Number(this.span.toPrecision(2));
    find('span').textContent = `${span} s`;
    // Not `disabled`: that takes the focus away from who has just pressed the button.
    find('shorter').setAttribute('aria-disabled', String(this.span <= Timeline.SPANS[0]));
    find('longer').setAttribute('aria-disabled', String(this.span >= SECONDS));
    find('moves').hidden = !this.kept;
    const ago = (seconds) => (seconds < 0.005 ? 'now' : `${signed((-seconds).toFixed(1))} s`);
    find('charts-title').textContent = this.kept ? `Paused: ${ago(this.zero - this.until + this.span)} to ${ago(this.zero - this.until)}` : `The last ${span === 10 ? 'ten' : span} seconds`;
  }
}
