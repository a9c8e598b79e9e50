// The effects as switches, each with its values as handles.
'use strict';

const Effects = (() => {
  const list = document.getElementById('effects');
  let catalogue = [];
  let rows = new Map();
  let changed = { toggle() {}, values() {} };
  const capital = (name) => name[0].toUpperCase() + name.slice(1);

  function row(effect) {
    const box = element('input', { type: 'checkbox', role: 'switch', id: `switch-${effect.id}` });
    const name = element('label', { htmlFor: box.id, textContent: capital(effect.name) });
    const note = element('span', { className: 'note' });
    const why = element('p', { className: 'why', hidden: true });
    const values = element('div', { className: 'values' });
    const rejected = element('p', { hidden: true });
    const more = element('details', {}, element('summary', { textContent: effect.id }), rejected,
      element('code', { textContent: effect.equation }),
      element('p', { textContent: effect.signature ? `It shows as: ${effect.signature}.` : 'An effect of your own.' }));
    if (effect.compensation) more.append(element('p', { textContent: `Remedy: ${effect.compensation}.` }));
    const item = element('li', {}, element('div', { className: 'switch' }, box, name, note), why, values, more);
    item.dataset.effect = effect.id;
    box.addEventListener('change', () => changed.toggle(effect.id, box.checked));
    return { effect, item, box, name, note, why, rejected, values, proposal: '' };
  }

  // A handle over the interval; it spans zero, half the value and six standard errors.
  function handle(one, parameter, index) {
    const fitted = parameter.sigma !== undefined;
    const old = one.values.children[index];
    if (old && !fitted) {
      // It is being pulled: its ends stay.
      old.querySelector('output').textContent = text.value(parameter.value, 0, parameter.unit);
      old.querySelector('.interval').hidden = true;
      return;
    }
    const reach = Math.max(6 * (parameter.sigma ?? 0), Math.abs(parameter.value) / 2) || 1e-3;
    const [low, high] = [Math.min(0, parameter.value - reach), Math.max(0, parameter.value + reach)];
    const input = element('input', { type: 'range', min: low, max: high, step: (high - low) / 500, value: parameter.value, 'aria-label': `${one.effect.name}, ${parameter.name}` });
    input.value = parameter.value;
    input.addEventListener('input', () => changed.values(one.effect.id, index, Number(input.value)));
    const share = (value) => `${(100 * (value - low)) / (high - low)}%`;
    const band = element('span', { className: 'band' });
    if (fitted) {
      band.style.left = share(parameter.low95);
      band.style.width = `calc(${share(parameter.high95)} - ${share(parameter.low95)})`;
      const zero = element('span', { className: 'zero-mark' });
      zero.style.left = share(0);
      band.after(zero);
      one.zero = zero;
    }
    const interval = element('small', { className: 'interval', textContent: fitted ? `95 %: ${text.interval(parameter.low95, parameter.high95)}` : '' });
    const made = element('div', { className: 'parameter' },
      element('span', { textContent: parameter.name }),
      element('output', { textContent: text.value(parameter.value, parameter.sigma ?? 0, parameter.unit) }), interval,
      element('div', { className: 'slide' }, ...(fitted ? [one.zero] : []), band, input));
    if (old) old.replaceWith(made);
    else one.values.append(made);
  }

  function show(on, answer) {
    for (const one of rows.values()) {
      const isOn = on.includes(one.effect.id);
      one.box.checked = isOn;
      one.item.classList.toggle('on', isOn);
      const found = answer.effects.find((other) => other.id === one.effect.id);
      if (!found) {
        one.values.replaceChildren();
        one.note.textContent = one.proposal;
        one.note.className = 'note';
        continue;
      }
      found.parameters.forEach((parameter, index) => handle(one, parameter, index));
      one.note.textContent = found.verdict ?? (answer.quick ? 'fitting \u2026' : 'set by hand');
      one.note.className = `note ${found.verdict ? (found.better ? 'good' : 'bad') : ''}`;
    }
  }

  function sort(first) {
    const rank = (id) => (first.includes(id) ? first.indexOf(id) : first.length + catalogue.findIndex((one) => one.id === id));
    list.append(...[...rows.values()].sort((a, b) => rank(a.effect.id) - rank(b.effect.id)).map((one) => one.item));
  }

  return {
    show,
    begin(effects, callbacks) {
      changed = callbacks;
      catalogue = effects;
      rows = new Map(effects.map((effect) => [effect.id, row(effect)]));
      list.replaceChildren(...[...rows.values()].map((one) => one.item));
    },
    add(effect) {
      if (rows.has(effect.id)) return;
      catalogue.push(effect);
      const made = row(effect);
      rows.set(effect.id, made);
      list.prepend(made.item);
    },
    // What explain says of each: its proposals stand first, with their reasons.
    explained(answer) {
      for (const [number, step] of answer.steps.entries()) {
        const one = rows.get(step.effect);
        if (!one) continue;
        const others = step.class.filter((id) => id !== step.effect).map((id) => rows.get(id)?.effect.name ?? id);
        const apart = others.length ? ` These runs cannot tell them apart: one switch stands for all.` : '';
        one.name.textContent = capital([one.effect.name, ...others].join(' or '));
        const unsure = step.used_to_predict ? '' : ' Less than is left unexplained: it may be something else.';
        const worth = step.matters ? unsure : ' Too small to matter.';
        one.why.textContent = `Explain ${number + 1}: ${step.why.replace(/\.$/, '')}.${apart}${worth}`;
        one.why.hidden = false;
      }
      for (const rejected of answer.rejected) {
        const one = rows.get(rejected.effect);
        if (!one || !one.why.hidden) continue;
        one.rejected.textContent = `Explain did not choose it: ${rejected.reason}.`;
        one.rejected.hidden = false;
      }
      sort(answer.steps.map((step) => step.effect));
    },
    // The error that each would lead to.
    preview(id, words) {
      const one = rows.get(id);
      one.proposal = words;
      if (!one.box.checked) one.note.textContent = words;
    },
    clearPreviews() {
      for (const one of rows.values()) this.preview(one.effect.id, '');
    },
    values: (id) => [...rows.get(id).values.querySelectorAll('input')].map((input) => Number(input.value)),
    ids: () => catalogue.map((one) => one.id),
    name: (id) => rows.get(id)?.effect.name ?? id,
  };
})();
