// Where the answers come from: the server, or this file itself where it was written with its answers in it.
'use strict';

const Source = (() => {
  const element = document.getElementById('recorded');
  const recorded = element ? JSON.parse(element.textContent) : null;
  const key = new URLSearchParams(location.search).get('key');

  async function ask(path, question) {
    const headers = { 'Content-Type': 'application/json' };
    if (key) headers['X-Beeline-Key'] = key;
    const options = question === undefined ? { headers } : { method: 'POST', headers, body: JSON.stringify(question) };
    let response;
    try {
      response = await fetch(path, options);
    } catch {
      throw new Error('beeline serve does not answer: has it ended?');
    }
    const answer = await response.json();
    if (!response.ok) throw Object.assign(new Error(answer.error), { hint: answer.hint });
    return answer;
  }

  // A model of these effects: [{id}] to be fitted, [{id, values}] at values set by hand. A quick answer has values and what
  // they leave, unless the rest is known already.
  async function model(effects, quick = false) {
    if (!recorded) return ask('api/model', { effects, quick });
    const answer = effects.some((one) => one.values) ? undefined : recorded.models[effects.map((one) => one.id).join()];
    if (!answer) throw new Error(`this file holds single effects and those that explain found; ${serve()} fits any model`);
    if (answer.error) throw new Error(answer.error);
    return answer;
  }

  const serve = () => `beeline serve ${recorded.campaign.folder}`;

  return {
    recorded: Boolean(recorded),
    campaign: () => (recorded ? Promise.resolve(recorded.campaign) : ask('api/campaign')),
    explanation: () => (recorded ? Promise.resolve(recorded.explanation) : ask('api/explanation')),
    has: (ids) => !recorded || ids.join() in recorded.models,
    model,
    equation: (equation, add) => ask('api/equation', { equation, add }),
    save: (effects) => ask('api/save', { effects }),
  };
})();
