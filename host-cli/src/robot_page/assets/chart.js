// Lines over the last seconds, drawn once a frame.
'use strict';

class Chart {
  // Each line: what of a frame it shows, its colour, whether it is dashed. `least` is the smallest span shown.
  constructor(canvas, lines, least) {
    Object.assign(this, { canvas, lines, least });
  }

  draw(frames, seconds) {
    const { canvas } = this;
    const ratio = devicePixelRatio;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    if (canvas.width !== Math.round(width * ratio) || canvas.height !== Math.round(height * ratio)) {
      canvas.width = Math.round(width * ratio);
      canvas.height = Math.round(height * ratio);
    }
    const colours = getComputedStyle(document.documentElement);
    const colour = (name) => colours.getPropertyValue(name);
    const context = canvas.getContext('2d');
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, width, height);
    const values = frames.flatMap((frame) => this.lines.map((line) => line.of(frame))).filter(Number.isFinite);
    let [low, high] = [Math.min(0, ...values), Math.max(0, ...values)];
    if (high - low < this.least) [low, high] = [low - (this.least - high + low) / 2, high + (this.least - high + low) / 2];
    const room = 0.08 * (high - low);
    const [left, top, bottom] = [46, 6, height - 18];
    const end = frames.at(-1)?.t ?? 0;
    const x = (t) => left + ((t - end + seconds) / seconds) * (width - left - 4);
    const y = (value) => bottom - ((value - low + room) / (high - low + 2 * room)) * (bottom - top);
    context.font = '12px system-ui,sans-serif';
    context.fillStyle = colour('--soft');
    context.lineWidth = 1;
    const step = Chart.step((high - low) / 3);
    context.textAlign = 'right';
    for (let level = Math.ceil(low / step) * step; level <= high; level += step) {
      context.strokeStyle = colour(Math.abs(level) < step / 2 ? '--line' : '--faint');
      context.beginPath();
      context.moveTo(left, y(level));
      context.lineTo(width, y(level));
      context.stroke();
      context.fillText(Number(level.toPrecision(3)).toString().replace('-', '\u2212'), left - 6, y(level) + 4);
    }
    context.textAlign = 'center';
    for (let back = 0; back <= seconds; back += 2) context.fillText(back ? `\u2212${back} s` : 'now', Math.min(x(end - back), width - 14), height - 3);
    context.lineWidth = 1.8;
    for (const line of this.lines) {
      context.strokeStyle = colour(line.colour);
      context.setLineDash(line.dashed ? [5, 4] : []);
      context.beginPath();
      let last = -Infinity;
      for (const frame of frames) {
        // A gap is a gap: what was lost is not drawn.
        if (frame.t - last > 0.2) context.moveTo(x(frame.t), y(line.of(frame)));
        else context.lineTo(x(frame.t), y(line.of(frame)));
        last = frame.t;
      }
      context.stroke();
    }
    context.setLineDash([]);
  }

  // 1, 2 or 5 times a power of ten.
  static step(rough) {
    const power = 10 ** Math.floor(Math.log10(rough));
    return power * ([1, 2, 5].find((step) => step * power >= rough) ?? 10);
  }
}
