// What keeps the robot moving: a message every 60 ms, as long as somebody wants it and sees this page.
'use strict';

const Drive = (() => {
  const key = new URLSearchParams(location.search).get('key');
  const [high, low] = crypto.getRandomValues(new Uint32Array(2));
  const page = (high % 2 ** 20) * 2 ** 32 + low;
  // Numbers rise, also from one page to the next.
  let number = 0;
  let ended = 0;
  let motion = null;
  let heard = 0;
  let waiting = 0;
  let failed = () => {};
  const onLetGo = [];

  // The answer, or null after the failure was told.
  async function post(path, question = {}) {
    const headers = { 'Content-Type': 'application/json' };
    if (key) headers['X-Beeline-Key'] = key;
    try {
      const response = await fetch(path, { method: 'POST', headers, body: JSON.stringify(question) });
      const answer = await response.json();
      if (response.ok) return answer;
      failed(answer.error);
    } catch {
      failed('beeline serve does not answer');
    }
    return null;
  }

  async function beat() {
    // A line that is held up must not get a queue.
    if (!motion || document.hidden || waiting > 2) return;
    waiting += 1;
    await post('api/hold', { page, number, motion, heard_ms: heard });
    waiting -= 1;
  }
  setInterval(beat, 60);

  function begin(wanted) {
    number = Math.max(number, ended) + 1;
    motion = wanted;
    beat();
  }

  // Nobody holds anything any more: whatever is still pressed counts only when it is pressed anew.
  function drop() {
    motion = null;
    onLetGo.forEach((letGo) => letGo());
  }

  function release() {
    const moved = Boolean(motion);
    drop();
    if (moved) post('api/stop');
  }

  addEventListener('visibilitychange', () => document.hidden && release());
  addEventListener('pagehide', release);
  addEventListener('blur', release);

  return {
    post,
    begin,
    release,
    drop,
    // A velocity that changes while it is held is the same motion.
    change: (wanted) => (motion ? (motion = wanted) : begin(wanted)),
    isMoving: () => Boolean(motion),
    page,
    hear(now, over) {
      [heard, ended] = [now, over];
      if (motion && ended >= number) drop();
    },
    stop() {
      drop();
      return post('api/stop');
    },
    cut() {
      drop();
      return post('api/cut');
    },
    clear: () => post('api/clear'),
    telemetry: () => new EventSource(`api/telemetry${location.search}`),
    onFailure: (told) => (failed = told),
    onLetGo: (letGo) => void onLetGo.push(letGo),
  };
})();
