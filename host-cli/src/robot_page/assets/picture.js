// Pictures of what is to be measured, and where the robot is to be put. Seen from above; the robot faces to the right.
'use strict';

const Picture = (() => {
  function shape(name, attributes = {}, ...inside) {
    const made = document.createElementNS('http://www.w3.org/2000/svg', name);
    for (const [attribute, value] of Object.entries(attributes)) made.setAttribute(attribute, value);
    made.append(...inside);
    return made;
  }

  const line = (name, d) => shape('path', { class: name, d });
  const text = (x, y, words, more = {}) => shape('text', { x, y, ...more }, words);
  const turned = (x, y, degrees) => `translate(${x} ${y}) rotate(${-degrees})`;

  // The middle of the axle is at its origin, 34 lie between its wheels.
  const robot = (transform, name = '') => shape('g', { class: `robot ${name}`, transform },
    line('w', 'M-8 -17H8M-8 17H8'),
    shape('rect', { class: 'body', x: -16, y: -13, width: 32, height: 26, rx: 7 }),
    line('n', 'M4 -6L10 0L4 6'),
    shape('circle', { class: 'dot', r: 2.4 }));

  // An arrow from one point to another, with its head there.
  function arrow(x, y, toX, toY, name = 'arrow') {
    const angle = Math.atan2(toY - y, toX - x);
    const barb = (turn) => `${(toX - 9 * Math.cos(angle + turn)).toFixed(1)} ${(toY - 9 * Math.sin(angle + turn)).toFixed(1)}`;
    return line(name, `M${x} ${y}L${toX} ${toY}M${barb(0.5)}L${toX} ${toY}L${barb(-0.5)}`);
  }

  // Of an angle at a point, to the left, from the x axis.
  function angle(x, y, radius, degrees) {
    const turn = (degrees * Math.PI) / 180;
    const [toX, toY] = [x + radius * Math.cos(turn), y - radius * Math.sin(turn)];
    const way = [-Math.sin(turn), -Math.cos(turn)];
    const barb = (side) => `${(toX - 7 * way[0] + side * 5 * Math.cos(turn)).toFixed(1)} ${(toY - 7 * way[1] - side * 5 * Math.sin(turn)).toFixed(1)}`;
    return line('size', `M${x + radius} ${y}A${radius} ${radius} 0 ${degrees > 180 ? 1 : 0} 0 ${toX.toFixed(1)} ${toY.toFixed(1)}M${barb(1)}L${toX.toFixed(1)} ${toY.toFixed(1)}L${barb(-1)}`);
  }

  // A ruler whose zero is at the origin; its scale grows upwards.
  function ruler(x, y, length) {
    const marks = [];
    for (let at = 0; at <= length; at += 6) marks.push(`M0 ${-at}h${at % 30 ? 6 : 11}`);
    return shape('g', { transform: `translate(${x} ${y})` }, shape('rect', { class: 'ruler', x: 0, y: -length - 5, width: 24, height: length + 10, rx: 3 }), line('mark', marks.join('')));
  }

  const cross = (x, y) => line('cross', `M${x - 11} ${y}h22M${x} ${y - 11}v22`);

  const DRAWN = {
    line: () => [
      'The robot stands on its start line, the middle of its axle over the line, and faces along it; there is room ahead.',
      shape('rect', { class: 'room', x: 84, y: 46, width: 222, height: 88, rx: 10 }),
      line('start', 'M14 90H306'),
      robot(`${turned(52, 90, 0)} scale(1.25)`),
      arrow(104, 90, 288, 90),
      text(195, 74, 'room ahead', { 'text-anchor': 'middle' }),
      text(14, 170, 'start line under the middle of the axle'),
    ],
    offset: () => [
      'The robot stands at its end, to the left of the start line. A ruler reads the distance from the line to the middle of its axle: to the left it is positive.',
      line('start', 'M14 148H306'),
      robot(turned(38, 148, 0), 'past'),
      line('trace', 'M58 148C102 147 122 104 145 82'),
      line('help', 'M158 72H204'),
      robot(`${turned(158, 72, 32)} scale(1.2)`),
      ruler(204, 148, 88),
      line('size', 'M240 72V148M234 72h12M234 148h12'),
      text(252, 108, 'offset', { class: 'name' }),
      text(252, 127, 'left +'),
      text(14, 188, 'from the line to the middle of the axle'),
    ],
    ahead_left: () => [
      'The robot stands ahead of its mark and to the left of it; both distances are measured from the mark to the middle of the axle.',
      line('start', 'M14 138H306'),
      cross(84, 138),
      text(84, 170, 'its mark', { 'text-anchor': 'middle' }),
      line('size', 'M84 138H220M84 132v12'),
      line('size', 'M220 138V66M214 138h12'),
      robot(`${turned(220, 66, 8)} scale(1.2)`),
      text(152, 160, 'ahead', { class: 'name', 'text-anchor': 'middle' }),
      text(232, 120, 'left', { class: 'name' }),
    ],
    mark: (degrees) => [
      `The robot stands on its start mark and faces ${degrees} degrees to the left of the x axis.`,
      arrow(20, 106, 300, 106, 'axis'),
      text(300, 126, 'x', { 'text-anchor': 'end' }),
      cross(108, 106),
      ...(degrees ? [angle(108, 106, 58, degrees)] : []),
      robot(`${turned(108, 106, degrees)} scale(1.25)`),
      shape('g', { transform: turned(108, 106, degrees) }, arrow(30, 0, 88, 0)),
      text(308, 32, degrees ? `${degrees}\u00b0 to the left of x` : 'along x', { class: 'name', 'text-anchor': 'end' }),
      text(308, 170, 'middle of the axle', { 'text-anchor': 'end' }),
      text(308, 188, 'over the mark', { 'text-anchor': 'end' }),
    ],
    pose: () => [
      'From the start mark: x along the axis to the middle of the axle, y to the left, and the heading to the left of the axis.',
      arrow(36, 148, 304, 148, 'axis'),
      arrow(36, 148, 36, 18, 'axis'),
      text(304, 170, 'x', { 'text-anchor': 'end' }),
      text(18, 28, 'y'),
      cross(36, 148),
      text(18, 180, 'start mark'),
      line('size', 'M36 148H172M172 142v12'),
      line('size', 'M172 148V82'),
      text(108, 168, 'x', { class: 'name', 'text-anchor': 'middle' }),
      text(160, 130, 'y', { class: 'name', 'text-anchor': 'end' }),
      line('help', 'M172 82H256'),
      angle(172, 82, 62, 30),
      robot(`${turned(172, 82, 30)} scale(1.2)`),
      text(242, 56, 'heading', { class: 'name' }),
    ],
    heading: () => [
      'The heading is the angle between the x axis and the direction in which the robot faces, to the left positive.',
      arrow(30, 142, 304, 142, 'axis'),
      text(304, 164, 'x', { 'text-anchor': 'end' }),
      angle(86, 142, 112, 32),
      robot(`${turned(86, 142, 32)} scale(1.25)`),
      shape('g', { transform: turned(86, 142, 32) }, arrow(30, 0, 158, 0)),
      text(208, 118, 'heading', { class: 'name' }),
      text(14, 188, 'to the left positive'),
    ],
    // What a procedure drives, above its form.
    tune: () => [
      'The robot drives forwards and back on a free stretch of floor, and turns on the spot.',
      shape('rect', { class: 'room', x: 14, y: 44, width: 292, height: 96, rx: 10 }),
      arrow(112, 78, 286, 78),
      arrow(286, 106, 112, 106),
      angle(60, 92, 40, 150),
      robot(`${turned(60, 92, 0)} scale(1.25)`),
      text(160, 168, 'free floor', { 'text-anchor': 'middle' }),
    ],
    campaign: () => [
      'A campaign drives lines, arcs, squares and spins from one mark.',
      line('lines', 'M130 92H300M130 92H20M130 92V14'),
      line('arcs', 'M130 92A36 36 0 1 0 104 80M130 92A36 36 0 1 1 104 104'),
      line('squares', 'M130 92h106v-64h-106M130 92h106v64h-106v-56'),
      robot(turned(130, 92, 0)),
      text(20, 190, 'lines, arcs, squares, spins from one mark'),
    ],
  };

  // The angle that a question names: "facing 90 degrees to the left".
  const facing = (words) => Number(/facing (-?\d+(?:\.\d+)?) degrees/.exec(words)?.[1] ?? 0);

  return {
    shape,
    robot,
    // The picture of a question, or null.
    of(name, words) {
      const drawn = Object.hasOwn(DRAWN, name ?? '') ? DRAWN[name](facing(words)) : null;
      if (!drawn) return null;
      const [label, ...shapes] = drawn;
      return shape('svg', { class: 'picture', viewBox: '0 0 320 200', role: 'img', 'aria-label': label }, ...shapes);
    },
  };
})();
