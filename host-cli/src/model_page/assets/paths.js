// Each run from above: as it was measured, as the nominal robot predicts it, as the model does.
'use strict';

const Paths = (() => {
  const WIDTH = 300;
  const HEIGHT = 230;
  const PAD = 18;
  const FIRST = 6;
  const host = document.getElementById('paths');
  const picker = document.getElementById('picker');
  let runs = [];
  let nominal = [];
  let now = [];
  let panels = [];
  let picked = 'largest errors';

  // Deviations from the measured path, averaged over a twentieth of the run.
  function deviations(measured, predicted) {
    const half = Math.floor(measured.length / 40);
    return measured.map((_, k) => {
      let [x, y, count] = [0, 0, 0];
      for (let j = Math.max(0, k - half); j <= Math.min(measured.length - 1, k + half); j += 1) {
        if (measured[j][0] === null || !predicted[j] || predicted[j][0] === null) continue;
        x += predicted[j][0] - measured[j][0];
        y += predicted[j][1] - measured[j][1];
        count += 1;
      }
      return count ? [x / count, y / count] : [0, 0];
    });
  }

  // A factor by which the nominal robot's deviations are seen: 1, 2, 5, 10, ...
  function factorOf(off, size) {
    const most = Math.max(...off.map(([x, y]) => Math.hypot(x, y)), 1e-9);
    const wanted = (0.14 * size) / most;
    return wanted <= 1 ? 1 : niceStep(wanted / 2, 1);
  }

  function panel(index) {
    const run = runs[index];
    const shape = nominal[index].way.length ? nominal[index].way : run.measured;
    const known = [...shape, ...run.measured].filter(([x]) => x !== null);
    const [xs, ys] = [known.map(([x]) => x), known.map(([, y]) => y)];
    const [low, high] = [[Math.min(...xs), Math.min(...ys)], [Math.max(...xs), Math.max(...ys)]];
    const size = Math.max(high[0] - low[0], high[1] - low[1], 0.1);
    const off = deviations(run.measured, nominal[index].predicted);
    const factor = factorOf(off, size);
    const room = 2 * PAD + 22;
    const scale = Math.min((WIDTH - room) / Math.max(high[0] - low[0], 0.1), (HEIGHT - room) / Math.max(high[1] - low[1], 0.1));
    const middle = [(low[0] + high[0]) / 2, (low[1] + high[1]) / 2];
    const at = ([x, y]) => [WIDTH / 2 + (x - middle[0]) * scale, HEIGHT / 2 - (y - middle[1]) * scale];
    const shifted = (deviation) => run.measured.map(([x, y], k) => at([x + factor * deviation[k][0], y + factor * deviation[k][1]]));
    const dots = run.measured.length <= 8;
    const seen = drawn('path', { class: 'seen', d: dots ? '' : line(run.measured.filter(([x]) => x !== null).map(at)) });
    const way = drawn('path', { class: 'way', d: line(nominal[index].way.map(at)) });
    const before = drawn('path', { class: 'p b', d: dots ? '' : line(shifted(off)) });
    const after = drawn('path', { class: 'p a' });
    const marks = drawn('g');
    const svg = drawn('svg', { class: 'd', viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: 'img', 'aria-label': `Run ${run.name} from above` }, way, seen, before, after, marks);
    svg.append(Object.assign(drawn('text', { class: 'tick', x: WIDTH - 4, y: HEIGHT - 6, 'text-anchor': 'end' }), { textContent: `deviations \u00d7 ${factor}` }));
    const name = element('b', { textContent: run.name });
    const caption = element('span', {});
    const figure = element('figure', {}, element('figcaption', {}, name, element('span', { textContent: run.held_out ? `${run.kind}, held out` : run.kind }), caption), svg);
    let flat = null;
    let stop = () => {};
    const show = () => {
      const target = shifted(deviations(run.measured, now[index].predicted)).flat();
      stop();
      const draw = (values) => {
        const points = [];
        for (let k = 0; k < values.length; k += 2) points.push([values[k], values[k + 1]]);
        flat = values;
        if (dots) {
          const one = (of, name2) => of.map(([x, y]) => drawn('circle', { class: name2, cx: x, cy: y, r: 4 }));
          marks.replaceChildren(...one(run.measured.map(at), 'fk'), ...one(shifted(off), 'fb'), ...one(points, 'fa'));
        } else after.setAttribute('d', line(points));
      };
      stop = glide(flat, target, draw);
      const [was, is] = [nominal[index].rms_m, now[index].rms_m];
      caption.replaceChildren(element('span', { className: 'before', textContent: text.milli(was, 'mm') }), ' \u2192 ', element('span', { className: 'after', textContent: text.milli(is, 'mm') }));
    };
    svg.addEventListener('pointermove', (event) => {
      const box = svg.getBoundingClientRect();
      const mouse = [((event.clientX - box.left) / box.width) * WIDTH, ((event.clientY - box.top) / box.height) * HEIGHT];
      const distances = run.measured.map((point) => Math.hypot(at(point)[0] - mouse[0], at(point)[1] - mouse[1]));
      const nearest = distances.indexOf(Math.min(...distances));
      const away = ({ predicted }) => Math.hypot(predicted[nearest][0] - run.measured[nearest][0], predicted[nearest][1] - run.measured[nearest][1]);
      const [x, y] = run.measured[nearest];
      showTip(event, `at ${x.toFixed(2)}, ${y.toFixed(2)} m: nominal ${text.milli(away(nominal[index]), 'mm')} off, now ${text.milli(away(now[index]), 'mm')}`);
    });
    svg.addEventListener('pointerleave', hideTip);
    return { figure, show };
  }

  function chosen() {
    const byError = runs.map((_, k) => k).sort((a, b) => nominal[b].rms_m - nominal[a].rms_m);
    if (picked === 'all runs') return runs.map((_, k) => k);
    if (picked !== 'largest errors') return byError.filter((k) => runs[k].kind === picked);
    // The worst of each kind first, then the others; a robot at rest shows the noise alone.
    byError.sort((a, b) => (runs[a].kind === 'rest') - (runs[b].kind === 'rest'));
    const first = byError.filter((k, at) => byError.findIndex((j) => runs[j].kind === runs[k].kind) === at);
    return [...first, ...byError.filter((k) => !first.includes(k))].slice(0, FIRST);
  }

  function rebuild() {
    panels = chosen().map(panel);
    host.replaceChildren(...panels.map((one) => one.figure));
    panels.forEach((one) => one.show());
  }

  function begin(campaign, baseline) {
    runs = campaign.runs;
    nominal = baseline.runs;
    now = baseline.runs;
    const kinds = [...new Set(runs.map((run) => run.kind))];
    const names = ['largest errors', ...(kinds.length > 1 ? kinds : []), 'all runs'];
    picker.replaceChildren(...names.map((name) => {
      const button = element('button', { type: 'button', textContent: name, 'aria-pressed': String(name === picked) });
      button.addEventListener('click', () => {
        picked = name;
        picker.querySelectorAll('button').forEach((other) => other.setAttribute('aria-pressed', String(other === button)));
        rebuild();
      });
      return button;
    }));
    rebuild();
  }

  return {
    begin,
    show(answer) {
      now = answer.runs;
      panels.forEach((one) => one.show());
    },
  };
})();
