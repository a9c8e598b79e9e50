// The floor in the frame of a campaign or of a line: planned, measured, and the run under way by the robot's own counts.
'use strict';

const CampaignFloor = (() => {
  const WIDTH = 600;
  // Around what is planned [m].
  const ROOM = 0.3;
  // Two points of the live path are at least so far apart [m].
  const APART = 0.004;
  const LIVE_MAX = 4000;

  const ofTitle = (title) => /^\s*\d+\/\d+\s+(\S+)/.exec(title ?? '')?.[1];
  const bare = (name) => name.replace(/^\d+_/, '');
  const same = (a, b) => a === b || bare(a) === bare(b);
  const isRecorded = (campaign, run) => campaign.recorded.some((one) => same(one.name, run.name));

  // The planned run that is driven, or is to be driven next; null if all are recorded.
  function present({ campaign, progress, question, running }) {
    if (!campaign || !running) return null;
    const named = ofTitle(progress?.title) ?? /^\s*([\w-]+):/.exec(question?.text ?? '')?.[1];
    return campaign.planned.find((run) => named && same(run.name, named)) ?? campaign.planned.find((run) => !isRecorded(campaign, run)) ?? null;
  }

  // The line of a calibration as if it were a campaign of one run.
  function ofLine(length) {
    return { planned: [{ name: 'line', heading_rad: 0, path: [[0, 0], [length, 0]] }], recorded: [] };
  }

  // What is driven since a motion began: in which run, where it began, and the path from there.
  const NOTHING = { run: null, title: null, share: 0, from: null };
  const live = { ...NOTHING, path: [] };

  // Takes in the news of a procedure. A way back goes on from the way out.
  function follow(progress) {
    const now = Robot.latest();
    if (progress && now) {
      const anew = progress.title !== live.title || progress.share < live.share - 0.3;
      if (anew && !(live.from && /\bback\b/.test(progress.title) && !ofTitle(progress.title))) {
        Object.assign(live, { from: now, path: [], run: ofTitle(progress.title) });
      }
      [live.title, live.share] = [progress.title, progress.share];
      const last = live.path.at(-1);
      if (!last || Math.hypot(now.x - last.x, now.y - last.y) > APART) live.path.push(now);
      if (live.path.length > LIVE_MAX) live.path = live.path.filter((_, k) => k % 2 === 0);
    } else if (!progress) {
      // The next motion under the same title is another one.
      live.title = null;
    }
  }

  function forget() {
    Object.assign(live, NOTHING, { path: [] });
  }

  // Poses by the robot's own counts, in the frame of the run: its start, turned to its heading.
  function inFrame(run) {
    const { x, y, heading } = live.from;
    const turn = run.heading_rad - heading;
    const [c, s] = [Math.cos(turn), Math.sin(turn)];
    const [atX, atY] = run.path[0] ?? [0, 0];
    return (pose) => [atX + c * (pose.x - x) - s * (pose.y - y), atY + s * (pose.x - x) + c * (pose.y - y), pose.heading + turn];
  }

  function bounds(campaign) {
    const points = [...campaign.planned, ...campaign.recorded].flatMap(({ path }) => path);
    const span = (values) => [Math.min(0, ...values) - ROOM, Math.max(0, ...values) + ROOM];
    return [span(points.map(([x]) => x)), span(points.map(([, y]) => y))];
  }

  // From metres on the floor to the drawing.
  function frameOf(campaign) {
    const [[left, right], [low, high]] = bounds(campaign);
    const scale = WIDTH / (right - left);
    const height = Math.round(Math.max(0.3 * WIDTH, Math.min(1.2 * WIDTH, (high - low) * scale)));
    const fit = Math.min(scale, height / (high - low));
    const middle = [(left + right) / 2, (low + high) / 2];
    return { height, scale: fit, at: (x, y) => [WIDTH / 2 + (x - middle[0]) * fit, height / 2 - (y - middle[1]) * fit], middle };
  }

  const d = (frame, points) => points.map(([x, y], k) => `${k ? 'L' : 'M'}${frame.at(x, y).map((value) => value.toFixed(1)).join(' ')}`).join('');

  function grid({ height, scale, at, middle }, step) {
    const [wide, high] = [WIDTH / 2 / scale, height / 2 / scale];
    const lines = [];
    for (let x = Math.ceil((middle[0] - wide) / step) * step; x < middle[0] + wide; x += step) lines.push(`M${at(x, 0)[0].toFixed(1)} 0V${height}`);
    for (let y = Math.ceil((middle[1] - high) / step) * step; y < middle[1] + high; y += step) lines.push(`M0 ${at(0, y)[1].toFixed(1)}H${WIDTH}`);
    return lines.join('');
  }

  function mark(frame) {
    const { shape } = Picture;
    const [x, y] = frame.at(0, 0);
    return shape('path', { class: 'cross', d: `M${x - 7} ${y}h14M${x} ${y - 7}v14` });
  }

  // What changes only with the campaign.
  function still(campaign, run, frame, step) {
    const { shape } = Picture;
    return shape('g', {},
      shape('path', { class: 'grid', d: grid(frame, step) }),
      ...campaign.recorded.map(({ path }) => shape('path', { class: 'measured', d: d(frame, path) })),
      mark(frame),
      ...(run ? [shape('path', { class: 'planned', d: d(frame, run.path) })] : []));
  }

  function robotAt(frame, [x, y, heading], name) {
    const [atX, atY] = frame.at(x, y);
    // 34 lie between the wheels of the picture.
    const size = Math.max(0.3, ((Robot.condition().track_width_m ?? 0.3) * frame.scale) / 34);
    return Picture.robot(`translate(${atX.toFixed(1)} ${atY.toFixed(1)}) rotate(${((-heading * 180) / Math.PI).toFixed(1)}) scale(${size.toFixed(3)})`, name);
  }

  let known = {};

  // Draws into an SVG, the robot at its start or where the motion has brought it; returns how long a side of the grid's squares is [m].
  function draw(svg, campaign, run, atStart) {
    if (known.campaign !== campaign || known.run !== run || known.svg !== svg) {
      const frame = frameOf(campaign);
      const step = Chart.step(WIDTH / frame.scale / 9);
      known = { svg, campaign, run, frame, step, group: still(campaign, run, frame, step) };
      svg.setAttribute('viewBox', `0 0 ${WIDTH} ${frame.height}`);
    }
    const { frame } = known;
    const moving = [];
    if (run && !atStart && live.from && (!live.run || same(live.run, run.name))) {
      const poses = live.path.map(inFrame(run));
      const now = inFrame(run)(Robot.latest());
      moving.push(Picture.shape('path', { class: 'live', d: d(frame, [...poses, now]) }), robotAt(frame, now));
    } else if (run) {
      moving.push(robotAt(frame, [...(run.path[0] ?? [0, 0]), run.heading_rad], 'past'));
    }
    svg.replaceChildren(known.group, ...moving);
    return known.step;
  }

  return { follow, forget, present, ofLine, draw, isRecorded, same };
})();
