// The guided procedures: begins them, keeps them alive, answers them, ends them.
'use strict';

(() => {
  const byId = (id) => document.getElementById(id);
  const NAMES = { calibrate: 'calibration', tune: 'tuning', campaign: 'campaign' };
  const HOLD_EVERY_MS = 60;
  const HOLDS_WAITING_MAX = 2;
  // So long a procedure that was begun may take to appear in the news.
  const APPEARS_MS = 2000;

  let procedure = null;
  // What this tab has begun last, {kind, options}: kept over a reload, if the browser keeps anything.
  let begun = null;
  try {
    begun = JSON.parse(sessionStorage.getItem('procedure'));
  } catch {
    // Then the defaults count.
  }
  function remember(what) {
    begun = what;
    try {
      sessionStorage.setItem('procedure', JSON.stringify(what));
    } catch {
      // As above.
    }
  }
  let begunAt = -Infinity;
  // Whether this page keeps the procedure alive. A page that only watches does not.
  let mine = false;
  // An ended procedure makes room for the form.
  let aside = false;
  let heard = 0;
  let waiting = 0;
  let ended = null;
  let first = true;

  // The answer, or {error}.
  async function ask(path, question = {}) {
    const headers = { 'Content-Type': 'application/json' };
    const key = new URLSearchParams(location.search).get('key');
    if (key) headers['X-Beeline-Key'] = key;
    try {
      const response = await fetch(path, { method: 'POST', headers, body: JSON.stringify(question) });
      const answer = await response.json();
      return response.ok ? answer : { error: answer.error ?? 'the server refuses that' };
    } catch {
      return { error: 'beeline serve does not answer' };
    }
  }

  async function hold(take = false) {
    const lives = procedure?.running || performance.now() - begunAt < APPEARS_MS;
    // A line that is held up must not get a queue.
    if (!(mine || take) || !lives || document.hidden || waiting >= HOLDS_WAITING_MAX) return;
    waiting += 1;
    await ask('api/procedure/hold', { page: Drive.page, take, heard_ms: heard });
    waiting -= 1;
  }
  setInterval(() => hold(), HOLD_EVERY_MS);

  function trouble(words) {
    const box = byId('begin-trouble');
    box.textContent = words ? `${words.replace(/^./, (letter) => letter.toUpperCase()).replace(/\.?$/, '.')}` : '';
    const place = procedure && !aside ? byId('ended') : byId(`panel-${Tabs.front()}`)?.querySelector('.offer');
    place?.after(box);
  }

  async function begin(kind, options) {
    trouble('');
    const before = mine;
    mine = true;
    begunAt = performance.now();
    const { error } = await ask('api/procedure/begin', { page: Drive.page, kind, options });
    if (error) {
      mine = before;
      begunAt = -Infinity;
      return trouble(error);
    }
    remember({ kind, options });
    aside = false;
    show();
  }

  const OPTIONS = {
    calibrate: ({ distance, unit, runs, out_and_back: back, measure }) => ({
      distance: `${Number(distance.value)}${unit.value}`,
      measure: measure.value,
      ...(back.checked ? { out_and_back: true } : {}),
      ...(!back.checked && Number(runs.value) > 1 ? { runs: runs.value } : {}),
    }),
    tune: ({ floor, stiffness }) => ({ floor: `${Number(floor.value)}m`, stiffness: stiffness.value }),
    campaign: ({ folder, along, across, measure }) => ({
      folder: folder.value.trim(),
      measure: measure.value,
      ...(along.value && across.value ? { floor: `${Number(along.value)}mx${Number(across.value)}m` } : {}),
    }),
  };

  for (const offer of document.querySelectorAll('.offer')) {
    const { kind } = offer.dataset;
    const form = offer.querySelector('form');
    offer.append(Picture.of(offer.dataset.picture, ''));
    form.addEventListener('submit', (event) => {
      event.preventDefault();
      begin(kind, OPTIONS[kind](form.elements));
    });
    offer.querySelector('.undo')?.addEventListener('click', () => begin(kind, { undo: true }));
  }
  byId('calibrate-back').addEventListener('input', ({ target }) => (byId('calibrate-runs').disabled = target.checked));
  byId('tune-stiffness').addEventListener('input', ({ target }) => (document.querySelector('label[for=tune-stiffness] output').textContent = Number(target.value).toFixed(1)));

  // The simulator has a camera.
  let simulated = null;
  function measures(now) {
    if (simulated === now) return;
    simulated = now;
    for (const select of document.querySelectorAll('select[name=measure]')) {
      select.querySelector('[value=camera]')?.remove();
      if (now) {
        select.prepend(new Option('the simulator\u2019s camera', 'camera'));
        select.selectedIndex = 0;
      }
    }
  }

  // The line of a calibration, as its lines tell it.
  let line = null;
  function lineDriven() {
    const text = procedure.lines.map(ProcedureView.plain).join('\n');
    const UNITS = { mm: 1e-3, cm: 1e-2, m: 1, rev: 1 };
    const [, distance, unit] = /Driving ([\d.]+) (rev|cm|m)\b/.exec(text) ?? [null, 2, 'm'];
    const [, radius, of] = /wheels ([\d.]+) (mm|cm|m)\b/.exec(text) ?? [null, 4, 'cm'];
    const length = distance * UNITS[unit] * (unit === 'rev' ? 2 * Math.PI * radius * UNITS[of] : 1);
    if (line?.length !== length) line = { length, floor: CampaignFloor.ofLine(length) };
    return line.floor;
  }

  function floor() {
    if (!procedure || byId('run').hidden) return;
    const campaign = procedure.kind === 'calibrate' ? lineDriven() : procedure.campaign;
    const present = procedure.kind === 'calibrate' ? campaign.planned[0] : CampaignFloor.present(procedure);
    ProcedureView.floor(procedure, campaign, present);
  }

  // The run that `explain` asks for, as the command takes it.
  const nextKind = () => procedure.campaign?.next_kind;

  // What can be done after the end.
  function ends() {
    const { kind, campaign } = procedure;
    const ok = procedure.ended?.ok ?? false;
    const isCampaign = kind === 'campaign';
    const wasUndo = begun?.kind === kind && begun.options.undo === true;
    const can = (id, on) => (byId(id).hidden = !on);
    can('explain', isCampaign && campaign?.recorded.length > 1);
    byId('explain').classList.toggle('main', ok);
    can('continue', isCampaign && !ok && procedure.folder);

    can('record-next', isCampaign && ok && nextKind());
    byId('record-next').textContent = `Record ${nextKind() ?? ''}`;
    can('again', !isCampaign && begun?.kind === kind && !wasUndo);
    byId('again').classList.toggle('main', !ok);
    can('undo', !isCampaign && ok && !wasUndo);
    byId('others').textContent = isCampaign ? 'Another campaign' : 'Other options';
  }

  // The offers while a procedure runs elsewhere.
  function offers() {
    for (const offer of document.querySelectorAll('.offer')) {
      offer.hidden = Boolean(procedure) && procedure.kind === offer.dataset.kind && !aside;
      const busy = Boolean(procedure?.running);
      for (const button of offer.querySelectorAll('button')) button.disabled = busy;
      const told = offer.querySelector('.busy-told');
      told.hidden = !busy;
      told.textContent = busy ? `A ${NAMES[procedure.kind]} is under way: it ends first.` : '';
    }
  }

  // The focus was on what has gone.
  const isLost = (element) => element === document.body || element.disabled || !element.getClientRects().length;

  function show() {
    offers();
    const run = byId('run');
    run.hidden = !procedure || aside;
    Tabs.mark(procedure?.kind, procedure?.running && (procedure.question ? 'asks' : 'runs'));
    if (!procedure) return;
    const panel = byId(`panel-${procedure.kind}`);
    if (run.parentElement !== panel) panel.append(run);
    ProcedureView.show(procedure, CampaignFloor.present(procedure));
    byId('run-stop').hidden = !procedure.running;
    byId('watching').hidden = mine || !procedure.running;
    const isNew = QuestionView.show(procedure.running ? procedure.question : null, mine);
    const front = Tabs.front() === procedure.kind;
    if (isNew) {
      byId('said').textContent = procedure.question.text;
      if (mine && front) QuestionView.focus();
    }
    ends();
    floor();
    const over = procedure.running ? null : procedure.ended;
    if (over && !ended && mine) {
      byId('said').textContent = ProcedureView.result(procedure);
      if (front && isLost(document.activeElement)) byId('run-title').focus({ preventScroll: true });
    }
    ended = over;
    if (!procedure.running && performance.now() - begunAt > APPEARS_MS) mine = false;
  }

  function take(news) {
    heard = news.now_ms;
    measures(news.condition?.simulated === true);
    const changed = 'procedure' in news;
    if (changed) {
      const before = procedure;
      procedure = news.procedure;
      // Another server than the one that it ran on.
      if (!procedure && before?.running) procedure = { ...before, running: false, question: null, progress: null, ended: { ok: false, error: 'the procedure has ended with beeline serve', hint: null } };
      if (procedure?.running) mine = procedure.held_by === Drive.page;
      if (procedure?.running && !before?.running) {
        CampaignFloor.forget();
        aside = false;
      }
      // Who opens the page while a procedure runs wants to see it.
      if (first && procedure?.running && !Tabs.isNamed()) Tabs.select(procedure.kind);
      first = false;
    }
    byId('continue').textContent = news.condition?.fault ? 'Clear the fault and continue' : 'Continue';
    CampaignFloor.follow(procedure?.running ? procedure.progress : null);
    if (changed) show();
  }

  QuestionView.onAnswer(async (number, text) => {
    const { error } = await ask('api/procedure/answer', { number, text });
    if (error) QuestionView.refuse(error);
  });
  byId('run-stop').addEventListener('click', () => ask('api/procedure/stop'));
  byId('take-over').addEventListener('click', () => {
    hold(true);
    show();
    if (procedure?.question) QuestionView.focus();
    else byId('run-stop').focus();
  });
  byId('again').addEventListener('click', () => begin(begun.kind, begun.options));
  byId('undo').addEventListener('click', () => begin(procedure.kind, { undo: true }));
  const ofThisCampaign = () => (begun?.kind === 'campaign' && begun.options.folder === procedure.folder ? begun.options : { folder: procedure.folder });
  // Without its options the campaign's own plan counts.
  byId('continue').addEventListener('click', async () => {
    // What stopped it may have left a fault: who goes on clears it, as the button says.
    if (Robot.condition().fault) {
      await ask('api/clear');
      for (let k = 0; k < 20 && Robot.condition().fault; k += 1) await new Promise((done) => setTimeout(done, 100));
    }
    begin('campaign', ofThisCampaign());
  });
  byId('record-next').addEventListener('click', () => {
    const { measure } = ofThisCampaign();
    begin('campaign', { folder: procedure.folder, run: nextKind(), ...(measure ? { measure } : {}) });
  });
  byId('others').addEventListener('click', () => {
    aside = true;
    trouble('');
    show();
    byId(`panel-${procedure.kind}`).querySelector('input').focus();
  });
  byId('explain').addEventListener('click', async () => {
    const box = byId('explain-link');
    const { link: served, error } = await ask('api/procedure/explain');
    if (error) return trouble(error);
    // The server may not know by which name it is reached.
    const link = Object.assign(new URL(served), { hostname: location.hostname }).href;
    // A browser may keep the tab from being opened: the link is there as well.
    window.open(link, '_blank');
    const anchor = Object.assign(document.createElement('a'), { href: link, target: '_blank', rel: 'noopener', textContent: link });
    box.replaceChildren('In a tab of its own: ', anchor);
    box.hidden = false;
  });

  Tabs.onShow(() => trouble(''));
  Robot.onNews(take);
  Robot.onDraw(floor);
  Tabs.begin();
})();
