// The page: which effects are on, what that leaves, and the way back.
'use strict';

const find = (id) => document.getElementById(id);
const state = { on: [], hand: null };
const past = [];
let campaign;
let baseline;
let answer;
let explanation = null;
let busy = null;
let asked = 0;

const ordered = (ids) => Effects.ids().filter((id) => ids.includes(id));
const request = ({ on, hand }) => on.map((id) => (hand ? { id, values: hand[id] } : { id }));

// One question at a time; of those asked meanwhile only the last counts.
async function update() {
  asked += 1;
  if (busy) return;
  while (busy !== asked) {
    busy = asked;
    document.body.setAttribute('aria-busy', 'true');
    const wanted = { on: [...state.on], hand: state.hand };
    try {
      const question = request(wanted);
      let found = await Source.model(question, !wanted.hand);
      if (found.quick) {
        // Paths and residuals move at once; what is predicted of other runs follows.
        answer = found;
        draw(wanted);
        found = await Source.model(question);
      }
      answer = found;
      say('');
      show(wanted);
    } catch (error) {
      say(error.message, true);
      if (answer && !state.hand && busy === asked) back();
    }
  }
  busy = null;
  document.body.removeAttribute('aria-busy');
}

function say(words, bad = false) {
  find('message').textContent = words;
  find('message').classList.toggle('bad', bad);
}

function draw(wanted) {
  Effects.show(wanted.on, answer);
  Paths.show(answer);
  Curves.show(answer);
  bars();
}

function show(wanted) {
  draw(wanted);
  remember(wanted);
  location.replace(`#${link(wanted)}`);
}

const link = ({ on, hand }) => on.map((id) => (hand ? `${id}=${hand[id].map((value) => Number(value.toPrecision(6))).join(':')}` : id)).join(',');

// The link as the page was opened with it: what is shown first writes its own.
const opened = decodeURIComponent(location.hash.slice(1));

function fromLink() {
  const parts = opened.split(',').filter(Boolean).map((part) => part.split('='));
  const known = parts.filter(([id]) => Effects.ids().includes(id));
  const hand = known.length && known.every(([, values]) => values) ? Object.fromEntries(known.map(([id, values]) => [id, values.split(':').map(Number)])) : null;
  return { on: ordered(known.map(([id]) => id)), hand };
}

// Before and now, as bars; the upright mark is what any model could reach.
function bars() {
  const rows = [
    ['Cross-validated', 'each run predicted by a fit to all others', 'cross_validated'],
    ['Fitted', state.hand ? 'at the values set by hand' : 'the fit to all runs', 'fitted'],
    ['On held-out runs', 'used neither to fit nor to select', 'held_out'],
  ].filter(([, , key]) => baseline.errors[key]);
  const most = Math.max(...rows.flatMap(([, , key]) => [baseline.errors[key].position_rms_m, answer.errors[key]?.position_rms_m ?? 0]));
  const host = find('bars');
  const floor = explanation?.floor?.position_rms_m;
  for (const [index, [title, words, key]] of rows.entries()) {
    let bar = host.children[index];
    if (!bar) {
      bar = element('div', { className: 'error' },
        element('div', { className: 'name' }, element('b', { textContent: title }), element('small')),
        element('div', { className: 'track' }, element('i', { className: 'was' }), element('i', { className: 'is' }), element('i', { className: 'floor', hidden: true, title: 'error floor: any model at all' })),
        element('div', { className: 'figures' }));
      bar.dataset.error = key;
      host.append(bar);
    }
    const [was, is] = [baseline.errors[key], answer.errors[key]];
    const width = (errors) => `${(100 * (errors?.position_rms_m ?? 0)) / most}%`;
    bar.querySelector('small').textContent = words;
    bar.querySelector('.was').style.width = width(was);
    // A bar whose error is still being computed stays as it was.
    if (is || !answer.quick) bar.querySelector('.is').style.width = width(is);
    const mark = bar.querySelector('.floor');
    mark.hidden = floor === undefined || key === 'held_out';
    if (!mark.hidden) mark.style.left = `${Math.min(100, (100 * floor) / most)}%`;
    const heading = (errors) => element('span', { className: 'heading', textContent: errors?.heading_rms_rad === undefined ? '' : `, ${text.milli(errors.heading_rms_rad, 'mrad')}` });
    bar.querySelector('.figures').replaceChildren(
      element('span', { className: 'before' }, text.milli(was.position_rms_m, 'mm'), heading(was)), ' \u2192 ',
      element('span', { className: 'after' }, is ? text.milli(is.position_rms_m, 'mm') : answer.quick ? 'fitting \u2026' : 'not fitted', heading(is)), ' ',
      element('small', { textContent: is ? text.change(was.position_rms_m, is.position_rms_m) : '' }));
  }
  find('note').textContent = floor === undefined ? '' : `Root mean square distance over all runs. Upright mark: ${text.milli(floor, 'mm')}, the error floor that any model reaches on runs that it was not fitted to.`;
}

// What a model has more or less than the one before it.
function label(before, { on, hand }, words) {
  if (hand) return 'by hand';
  const more = on.filter((id) => !before?.on.includes(id));
  const less = before?.on.filter((id) => !on.includes(id)) ?? [];
  if (before && on.length && more.length + less.length === 1) return more.length ? `+ ${Effects.name(more[0])}` : `\u2212 ${Effects.name(less[0])}`;
  return on.length > 1 ? `${on.length} effects` : words;
}

// Every model tried, as a column; a click goes back to it.
function remember(wanted) {
  const words = wanted.on.length ? wanted.on.map(Effects.name).join(' + ') : 'nominal robot';
  const entry = { ...wanted, words, label: label(past.at(-1), wanted, words), error: answer.errors.cross_validated?.position_rms_m ?? answer.errors.fitted.position_rms_m };
  const last = past.at(-1);
  if (last?.hand && entry.hand && link({ ...last, hand: null }) === link({ ...entry, hand: null })) past.pop();
  if (link(past.at(-1) ?? { on: ['?'], hand: null }) !== link(entry)) past.push(entry);
  const most = Math.max(...past.map((one) => one.error));
  find('history').replaceChildren(...past.slice(-12).map((one) => {
    const column = element('i');
    column.style.height = `${Math.max(3, (34 * one.error) / most)}px`;
    const button = element('button', { type: 'button', title: one.words }, column, element('span', { textContent: text.milli(one.error, 'mm') }), element('small', { textContent: one.label }));
    button.addEventListener('click', () => go(one));
    return element('li', {}, button);
  }));
  find('undo').disabled = past.length < 2;
  find('save').disabled = Boolean(wanted.hand);
}

function go({ on, hand }) {
  Object.assign(state, { on: ordered(on), hand });
  update();
}

function back() {
  const last = past.at(-1) ?? { on: [], hand: null };
  Object.assign(state, { on: [...last.on], hand: last.hand });
  Effects.show(state.on, answer);
}

function undo() {
  if (past.length < 2) return;
  past.pop();
  go(past.at(-1));
}

function toggle(id, isOn) {
  go({ on: isOn ? [...state.on, id] : state.on.filter((other) => other !== id), hand: null });
}

function pull(id, index, value) {
  const hand = Object.fromEntries(state.on.map((other) => [other, Effects.values(other)]));
  hand[id][index] = value;
  go({ on: state.on, hand });
}

// What each effect that is off would make of the error.
async function preview() {
  const [button, on] = [find('preview'), [...state.on]];
  button.disabled = true;
  for (const id of Effects.ids().filter((other) => !on.includes(other))) {
    const more = ordered([...on, id]);
    if (!Source.has(more)) continue;
    try {
      const found = await Source.model(more.map((other) => ({ id: other })));
      const [was, is] = [answer, found].map((of) => (of.errors.cross_validated ?? of.errors.fitted).position_rms_m);
      Effects.preview(id, `\u2192 ${text.milli(is, 'mm')}, ${text.change(was, is)}`);
    } catch (error) {
      Effects.preview(id, error.message);
    }
  }
  button.disabled = false;
}

async function save() {
  const folder = campaign.folder;
  if (Source.recorded) return say(`In a terminal: beeline model add ${state.on.join(' ')} ${folder}`);
  if (!state.on.length) return say('Switch an effect on first: the nominal robot needs no model.', true);
  try {
    const saved = await Source.save(request({ on: state.on, hand: null }));
    say(`${saved.file} written. Next: ${saved.next}`);
  } catch (error) {
    say(error.message, true);
  }
}

// An equation is checked as it is typed.
function own() {
  const [input, note, button] = [find('equation'), find('equation-note'), find('add')];
  const usual = note.textContent;
  let timer;
  input.addEventListener('input', () => {
    clearTimeout(timer);
    button.disabled = true;
    timer = setTimeout(async () => {
      const equation = input.value.trim();
      note.classList.remove('bad');
      if (!equation) return (note.textContent = usual);
      try {
        const effect = await Source.equation(equation, false);
        const units = effect.parameters.map((parameter) => `${parameter.name} in ${parameter.unit}`);
        note.textContent = `${effect.equation}: ${units.join(', ')} will be fitted.`;
        button.disabled = false;
      } catch (error) {
        note.textContent = [error.message, error.hint].filter(Boolean).join('\n');
        note.classList.add('bad');
      }
    }, 250);
  });
  find('own').addEventListener('submit', async (event) => {
    event.preventDefault();
    try {
      const effect = await Source.equation(input.value.trim(), true);
      Effects.add(effect);
      input.value = '';
      button.disabled = true;
      note.textContent = usual;
      toggle(effect.id, true);
    } catch (error) {
      note.textContent = error.message;
    }
  });
  find('own').hidden = Source.recorded;
}

// Explain goes on beside the page; its findings appear as they come.
async function explain() {
  for (;;) {
    const found = await Source.explanation();
    if (found.answer) {
      if (found.answer.error) return (find('headline').textContent = found.answer.error);
      explanation = found.answer;
      break;
    }
    find('headline').textContent = ['Explaining', ...found.found].join(' \u00b7 ');
    await new Promise((wake) => setTimeout(wake, 200));
  }
  find('headline').textContent = explanation.verdict;
  Effects.explained(explanation);
  find('proposed').disabled = explanation.steps.length === 0;
  bars();
}

async function begin() {
  campaign = await Source.campaign();
  document.title = `${campaign.robot}: what is missing`;
  find('robot').textContent = `${campaign.robot} \u00b7 ${campaign.runs.length} runs \u00b7 ${campaign.folder}`;
  Effects.begin(campaign.catalogue, { toggle, values: pull });
  baseline = await Source.model([]);
  answer = baseline;
  Paths.begin(campaign, baseline);
  Curves.begin(baseline);
  show({ on: [], hand: null });
  find('undo').addEventListener('click', undo);
  find('none').addEventListener('click', () => go({ on: [], hand: null }));
  find('proposed').addEventListener('click', () => go({ on: explanation.steps.map((step) => step.effect), hand: null }));
  find('preview').addEventListener('click', preview);
  find('save').addEventListener('click', save);
  addEventListener('keydown', (event) => {
    if ((event.ctrlKey || event.metaKey) && event.key === 'z' && event.target.id !== 'equation') {
      event.preventDefault();
      undo();
    }
  });
  own();
  if (opened) go(fromLink());
  else if (campaign.model.length) go({ on: campaign.model, hand: null });
  await explain();
}

begin().catch((error) => {
  find('headline').textContent = error.message;
  find('headline').classList.add('bad');
});
