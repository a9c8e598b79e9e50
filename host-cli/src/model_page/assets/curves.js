// The residuals against each variable. Axes stay as the nominal robot needs them, so that a curve is seen to flatten.
'use strict';

const Curves = (() => {
  const [LEFT, RIGHT, TOP, BOTTOM] = [54, 292, 24, 168];
  const PANELS = 6;
  const host = document.getElementById('curves');
  let panels = [];

  const same = (a, b) => a.axis === b.axis && a.component === b.component;
  const points = (curve) => curve.bins.map(([at, value, sigma]) => [at, value * 1e3, 1.96e3 * sigma]);

  function panel(curve) {
    const was = points(curve);
    const ends = was.map(([at]) => at);
    const [first, last] = [Math.min(...ends), Math.max(...ends)];
    const margin = 0.05 * (last - first || 1);
    const heights = was.flatMap(([, value, half]) => [value - half, value + half]);
    let [low, high] = [Math.min(0, ...heights), Math.max(0, ...heights)];
    const room = 0.08 * (high - low || 1);
    [low, high] = [low - room, high + room];
    const x = (at) => LEFT + ((at - first + margin) / (last - first + 2 * margin)) * (RIGHT - LEFT);
    const y = (value) => Math.min(BOTTOM + 14, Math.max(TOP - 14, BOTTOM - ((value - low) / (high - low)) * (BOTTOM - TOP)));
    const svg = drawn('svg', { class: 'd', viewBox: '0 0 300 194', role: 'img', 'aria-label': `Residual against ${curve.axis}` });
    const label = (at, words, attributes) => svg.append(Object.assign(drawn('text', { class: 'tick', ...at, ...attributes }), { textContent: words }));
    label({ x: LEFT, y: 10 }, curve.unit);
    const step = niceStep(high - low, 4);
    for (let level = Math.ceil(low / step) * step; level <= high; level += step) {
      const near = Math.abs(level) < step / 2 ? 0 : level;
      svg.append(drawn('path', { class: near === 0 ? 'zero' : 'g', d: `M${LEFT} ${y(near)}H${RIGHT}` }));
      label({ x: LEFT - 7, y: y(near) + 4, 'text-anchor': 'end' }, text.short(near));
    }
    const stride = niceStep(last - first + 2 * margin, 4);
    for (let stop = Math.ceil((first - margin) / stride) * stride; stop <= last + margin; stop += stride) {
      label({ x: x(stop), y: 187, 'text-anchor': 'middle' }, text.short(Math.abs(stop) < stride / 2 ? 0 : stop));
    }
    const after = drawn('path', { class: 'p a' });
    const whiskers = drawn('path', { class: 'whisker a' });
    const dots = drawn('g');
    svg.append(drawn('path', { class: 'p b', d: line(was.map(([at, value]) => [x(at), y(value)])) }), whiskers, after, dots);
    const figure = element('figure', {}, element('figcaption', {}, element('b', { textContent: `Against ${curve.axis}` })), svg);
    let flat = null;
    let stop = () => {};
    let now = was;
    const show = (answer) => {
      const found = answer.curves.find((other) => same(other, curve));
      now = found ? points(found) : [];
      stop();
      const draw = (values) => {
        flat = values;
        const at = now.map((_, k) => [x(values[3 * k]), y(values[3 * k + 1]), y(values[3 * k + 1] - values[3 * k + 2]), y(values[3 * k + 1] + values[3 * k + 2])]);
        after.setAttribute('d', line(at));
        whiskers.setAttribute('d', at.map(([px, , a, b]) => `M${px.toFixed(1)} ${a.toFixed(1)}V${b.toFixed(1)}`).join(''));
        dots.replaceChildren(...at.map(([px, py]) => drawn('circle', { class: 'fa', cx: px.toFixed(1), cy: py.toFixed(1), r: 3.2 })));
      };
      stop = glide(flat, now.flat(), draw);
    };
    svg.addEventListener('pointermove', (event) => {
      const box = svg.getBoundingClientRect();
      const mouse = ((event.clientX - box.left) / box.width) * 300;
      const distances = now.map(([at]) => Math.abs(x(at) - mouse));
      const nearest = now[distances.indexOf(Math.min(...distances))];
      if (nearest) showTip(event, `${text.short(nearest[0])}: ${text.short(nearest[1])} \u00b1 ${text.short(nearest[2])} ${curve.unit} (95 %)`);
    });
    svg.addEventListener('pointerleave', hideTip);
    return { figure, show };
  }

  return {
    begin(baseline) {
      const worst = [];
      for (const curve of [...baseline.curves].sort((a, b) => b.chi - a.chi)) {
        if (!worst.some((other) => other.axis === curve.axis)) worst.push(curve);
      }
      panels = worst.slice(0, PANELS).map(panel);
      host.replaceChildren(...panels.map((one) => one.figure));
      panels.forEach((one) => one.show(baseline));
    },
    show: (answer) => panels.forEach((one) => one.show(answer)),
  };
})();
