// What a procedure shows: its question, its motion, its lines, its end, and what a campaign has found.
'use strict';

const ProcedureView = (() => {
  const byId = (id) => document.getElementById(id);
  const NAMES = { calibrate: 'Calibration', tune: 'Tuning', campaign: 'Campaign' };
  const DONE = { calibrate: 'The calibration is done.', tune: 'The tuning is done.', campaign: 'The campaign is recorded.' };

  function made(name, className, ...inside) {
    const element = document.createElement(name);
    if (className) element.className = className;
    element.append(...inside);
    return element;
  }

  const plain = (line) => line.map(([, text]) => text).join('');

  // A sentence runs on; what is set in columns keeps them, and goes on below its second column where it is too long.
  function lineOf(pieces) {
    const text = plain(pieces);
    if (!text.trim()) return made('div', 'blank');
    const columns = /^ |\S {2,}\S/.test(text);
    const line = made('div', columns ? 'columned' : 'sentence', ...pieces.map(([style, words]) => made('span', style, words)));
    if (columns) {
      const first = /^( *\S(?:\S| (?! ))* {2,})\S/.exec(text)?.[1].length ?? Infinity;
      const below = first <= 16 ? first : /^ */.exec(text)[0].length + 4;
      line.style.paddingLeft = `${below}ch`;
      line.style.textIndent = `${-below}ch`;
    }
    return line;
  }

  // The lines only ever grow, until another procedure begins.
  let written = [];
  function transcript(lines) {
    const log = byId('transcript');
    const grown = lines.length >= written.length && written.every((text, k) => text === plain(lines[k]));
    if (!grown) {
      log.replaceChildren();
      written = [];
    }
    const follows = log.scrollHeight - log.scrollTop - log.clientHeight < 30;
    log.append(...lines.slice(written.length).map(lineOf));
    written = lines.map(plain);
    if (follows) log.scrollTop = log.scrollHeight;
    byId('log').hidden = !lines.length;
  }

  function motion(progress, drives) {
    byId('motion').hidden = !progress || !drives;
    if (!progress) return;
    const share = Math.round(100 * Math.min(1, Math.max(0, progress.share)));
    byId('motion-title').textContent = progress.title.trim().replaceAll('_', ' ');
    byId('motion-share').textContent = `${share} %`;
    byId('motion-bar').setAttribute('aria-valuenow', share);
    byId('motion-bar').firstElementChild.style.width = `${share}%`;
  }

  // What the command said last of all that was good, or else a sentence.
  function result({ kind, lines, ended, campaign }) {
    if (kind === 'campaign' && ended.ok && campaign) return `${campaign.recorded.length} runs are recorded.`;
    if (!ended.ok) return ended.error.replace(/^./, (letter) => letter.toUpperCase());
    const words = lines.filter((line) => /^(good|warn)$/.test(line.find(([, text]) => text.trim())?.[0])).map(plain).at(-1);
    return words?.trim().replace(/^./, (letter) => letter.toUpperCase()) ?? DONE[kind];
  }

  function sign(ok) {
    const { shape } = Picture;
    return shape('svg', { viewBox: '0 0 40 40', 'aria-hidden': 'true' }, shape('circle', { cx: 20, cy: 20, r: 18 }), shape('path', { d: ok ? 'M12 21l6 6l11 -13' : 'M20 11v11M20 28v1' }));
  }

  function end(procedure) {
    const { ended } = procedure;
    byId('ended').hidden = !ended;
    if (!ended) return;
    byId('ended').className = ended.ok ? 'ok' : 'failed';
    byId('ended-sign').replaceChildren(sign(ended.ok));
    byId('ended-words').textContent = result(procedure);
    const hint = ended.ok ? '' : ended.hint;
    byId('ended-hint').textContent = hint ? `Try: ${hint.replace(/\.?$/, '.')}` : '';
    byId('ended-hint').hidden = !hint;
  }

  function drawing({ kind, drawing: path, ended, lines }) {
    const shown = Boolean(path) && kind === 'calibrate';
    byId('drawing').hidden = !shown;
    if (!shown) return;
    const image = byId('drawing').querySelector('img');
    // An image sends no header: the key of the link goes with it.
    const key = new URLSearchParams(location.search).get('key');
    const source = key ? `${path}${path.includes('?') ? '&' : '?'}key=${encodeURIComponent(key)}` : path;
    if (image.getAttribute('src') !== source) image.src = source;
    image.alt = `The paths of the calibration from above. ${ended ? result({ kind, ended, lines }) : ''}`.trim();
  }

  const named = (name) => name.replace(/^\d+_/, '').replaceAll('_', ' ');
  const millimetres = (metres) => `${(metres * 1e3).toFixed(metres < 1e-3 ? 2 : 1)} mm`;

  function runOf({ name, shows, held_out: heldOut }, state, error, most) {
    const item = made('li', state, made('span', 'name', named(name), ...(heldOut ? [made('em', '', 'held out')] : [])));
    if (state === 'now') item.setAttribute('aria-current', 'step');
    if (error === undefined) {
      item.append(made('span', 'shows', state === 'now' ? 'now' : 'planned'));
    } else if (error === null) {
      item.append(made('span', 'shows', 'not measured'));
    } else {
      const bar = made('i', '');
      bar.style.width = `${Math.max(1, (100 * error) / most)}%`;
      const track = made('span', 'bar', bar);
      track.setAttribute('aria-hidden', 'true');
      item.append(track, made('span', 'size', millimetres(error)));
    }
    if (state === 'now' && shows) item.append(made('small', '', shows));
    return item;
  }

  function runs(campaign, present) {
    const most = Math.max(1e-6, ...campaign.recorded.map((run) => run.error_m ?? 0));
    const planned = campaign.planned.filter((run) => run === present || !CampaignFloor.isRecorded(campaign, run));
    byId('runs').replaceChildren(
      ...campaign.recorded.map((run) => runOf(run, 'recorded', run.error_m, most)),
      ...planned.map((run) => runOf(run, run === present ? 'now' : 'planned')));
  }

  let seen = {};
  function ofCampaign(procedure, present) {
    const { campaign } = procedure;
    const shown = procedure.kind === 'campaign' && Boolean(campaign);
    byId('campaign').hidden = !shown;
    const found = shown ? campaign.found : [];
    const next = shown ? campaign.next : null;
    byId('findings').hidden = !found.length && !next;
    if (!shown || (seen.campaign === campaign && seen.present === present)) return;
    seen = { campaign, present };
    byId('campaign-error').textContent = campaign.error_m === null ? '\u2013' : millimetres(campaign.error_m);
    const { length } = campaign.recorded;
    const planned = campaign.planned.filter((run) => !CampaignFloor.isRecorded(campaign, run)).length;
    byId('campaign-count').textContent = `${length} of ${length + planned}`;
    runs(campaign, present);
    byId('found').replaceChildren(...found.map((line) => made('li', '', line.replace(/^\s*\d+\s+/, '').trim())));
    byId('found').parentElement.hidden = !found.length;
    byId('next').textContent = next ?? '';
    byId('next-box').hidden = !next;
  }

  function floor(procedure, campaign, present) {
    const shown = Boolean(campaign) && (procedure.kind === 'campaign' || (procedure.kind === 'calibrate' && !procedure.drawing));
    byId('run-floor').hidden = !shown;
    if (!shown || document.hidden) return;
    byId('run-floor-title').textContent = procedure.kind === 'campaign' ? 'The floor, in the frame of the campaign' : 'The line, to scale';
    byId('legend-measured').hidden = !campaign.recorded.length;
    byId('legend-planned').hidden = !present;
    const step = CampaignFloor.draw(byId('run-floor-drawing'), campaign, present, ['line', 'mark'].includes(procedure.question?.picture));
    byId('run-floor-scale').textContent = `a square is ${Number(step.toPrecision(2))} m`;
  }

  function title({ kind, folder, ended }) {
    const of = folder ? ` ${folder}` : '';
    // A command that has run to its end may say no.
    const how = ended?.said_no ? ': nothing changed' : ': ended early';
    return `${NAMES[kind]}${of}${ended && !ended.ok ? how : ''}`;
  }

  return {
    floor,
    result,
    plain,
    // All but the question and the floor.
    show(procedure, present) {
      byId('run').dataset.kind = procedure.kind;
      byId('run-title').textContent = title(procedure);
      motion(procedure.progress, procedure.running && !procedure.question);
      transcript(procedure.lines);
      end(procedure);
      drawing(procedure);
      ofCampaign(procedure, present);
    },
  };
})();
