// The question of a procedure: its picture, what may be typed, and its choices.
'use strict';

const QuestionView = (() => {
  const byId = (id) => document.getElementById(id);
  const POSE = [['x', '1.795m'], ['y, left positive', '-12mm'], ['Heading, left positive', '3deg']];
  const FIELDS = {
    offset: [['Offset with its unit, left positive', '-36mm']],
    ahead_left: [['Ahead', '-12mm'], ['To the left', '5mm']],
    mark: POSE,
    pose: POSE,
    heading: [POSE[2]],
  };
  let answered = () => {};
  let asked = null;

  const inputs = () => [...byId('fields').querySelectorAll('input')];

  function send(text) {
    byId('answer-trouble').textContent = '';
    // Not on a button: Enter, pressed twice, must do nothing.
    byId('run-title').focus({ preventScroll: true });
    enable(false);
    answered(asked.number, text);
  }

  function enable(on) {
    for (const control of byId('question').querySelectorAll('button,input')) control.disabled = !on;
  }

  function button(words, name, text) {
    const made = document.createElement('button');
    made.type = 'button';
    made.className = name;
    made.textContent = words;
    made.addEventListener('click', () => send(text));
    return made;
  }

  function field([words, example], at, all) {
    const label = document.createElement('label');
    const input = document.createElement('input');
    Object.assign(input, { id: `answer-${at}`, type: 'text', placeholder: example, spellcheck: false, autocomplete: 'off', enterKeyHint: at + 1 < all.length ? 'next' : 'send' });
    input.setAttribute('aria-describedby', 'answer-trouble');
    label.append(words, input);
    return label;
  }

  // What was typed, or null after saying what is wrong with it.
  function typed() {
    const parts = inputs().map((input) => input.value.trim().replaceAll('\u2212', '-'));
    const wrong = (words, at) => {
      byId('answer-trouble').textContent = words;
      inputs()[at].focus();
      return null;
    };
    const empty = parts.findIndex((part) => !part);
    if (parts.every((part) => !part)) return wrong(asked.choices.length ? 'Type what you measured, or press a button.' : 'Type what you measured.', 0);
    // A track file, by its name.
    if (asked.picture === 'pose' && /^[^-+.\d]/.test(parts[0]) && !parts[1] && !parts[2]) return parts[0];
    const bare = asked.picture ? parts.findIndex((part) => /^[-+]?[\d.]+$/.test(part)) : -1;
    if (bare >= 0) return wrong(`Give the unit too, as in ${inputs()[bare].placeholder}.`, bare);
    // A heading may be left out.
    if (empty >= 0 && (empty < 2 || parts.length < 3)) return wrong('This is needed as well.', empty);
    return parts.filter(Boolean).join(' ');
  }

  byId('answer').addEventListener('submit', (event) => {
    event.preventDefault();
    const text = typed();
    if (text !== null) send(text);
  });

  // What is asked, and what else is said: how it is answered at a terminal, the buttons say themselves.
  function sentences(words) {
    const text = words.trim().replace(/[:\s]+$/, '').replace(/,? and press Enter$/, '');
    const end = /[.;] (?=[A-Z])/.exec(text);
    return end ? [text.slice(0, end.index).replace(/\.$/, ''), text.slice(end.index + 2)] : [text, ''];
  }

  function build(question) {
    const { picture, types, choices, suggested } = question;
    const drawn = Picture.of(picture, question.text);
    byId('question-picture').replaceChildren(...(drawn ? [drawn] : []));
    byId('question-picture').hidden = !drawn;
    // A run's name stands first: "out_and_back_east: put ...".
    const named = question.text.replace(/^\s*([\w-]+):/, (name) => name.trim().replaceAll('_', ' ').replace(/^./, (letter) => letter.toUpperCase()));
    const [asks, more] = sentences(named);
    byId('question-text').textContent = asks;
    byId('question-more').textContent = more;
    byId('question-more').hidden = !more;
    byId('choices').replaceChildren(...choices.map(({ label, answer }, at) => button(label, at || (types && picture !== 'mark' && picture !== 'line') ? '' : 'main', answer)));
    byId('choices').hidden = !choices.length;
    byId('typed').hidden = !types;
    // Where the robot stands at its mark, a button says so.
    const elsewhere = picture === 'mark' && choices.length > 0;
    byId('typed').open = !elsewhere;
    byId('typed').querySelector('summary').hidden = !elsewhere;
    byId('fields').replaceChildren(...(FIELDS[picture] ?? [['Answer', '']]).map(field));
    byId('suggestion').hidden = !suggested;
    byId('suggestion').replaceChildren(...(suggested ? [button(`Take the simulator\u2019s ${['pose', 'heading'].includes(picture) ? 'tape measure' : 'ruler'}: ${suggested}`, '', suggested)] : []));
    // What is asked for comes first.
    const order = types && !elsewhere ? ['typed', 'suggestion', 'choices'] : ['choices', 'typed', 'suggestion'];
    byId('answering').prepend(...order.map(byId));
    enable(true);
    // It is asked again: what is wrong stands beside it, and what was typed is kept.
    const { refused } = question;
    byId('answer-trouble').textContent = refused ? refused.why.replace(/^./, (letter) => letter.toUpperCase()) : '';
    if (refused && types) {
      const parts = refused.answer.split(/\s+/);
      inputs().forEach((input, at, all) => (input.value = at + 1 < all.length ? parts[at] ?? '' : parts.slice(at).join(' ')));
    }
  }

  function focus() {
    const first = byId('typed').hidden || !byId('typed').open ? null : inputs()[0];
    (first ?? byId('choices').querySelector('button') ?? byId('question-text')).focus({ preventScroll: true });
    byId('question').scrollIntoView({ block: 'nearest' });
  }

  return {
    onAnswer: (told) => (answered = told),
    // Shows a question, or none; true if it is a new one. Only who holds the procedure answers.
    show(question, mine) {
      byId('question').hidden = !question;
      const isNew = Boolean(question) && question.number !== asked?.number;
      if (isNew) build(question);
      asked = question;
      byId('answering').hidden = !mine;
      return isNew;
    },
    focus,
    // An answer was refused.
    refuse(words) {
      enable(true);
      byId('answer-trouble').textContent = words;
    },
  };
})();
