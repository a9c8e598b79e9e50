// The tabs of the page; which one is in front stands behind # in the address.
'use strict';

const Tabs = (() => {
  const tabs = [...document.querySelectorAll('[role=tab]')];
  const nameOf = (tab) => tab.id.replace('tab-', '');
  const panelOf = (tab) => document.getElementById(tab.getAttribute('aria-controls'));
  const shown = [];
  let front = 'drive';

  function select(name) {
    if (!tabs.some((tab) => nameOf(tab) === name)) return;
    // What is held on the tab that goes away cannot be let go there any more.
    if (front === 'drive' && name !== front) Drive.release();
    front = name;
    for (const tab of tabs) {
      const own = nameOf(tab) === name;
      tab.setAttribute('aria-selected', String(own));
      tab.tabIndex = own ? 0 : -1;
      panelOf(tab).hidden = !own;
    }
    const hash = name === 'drive' ? '' : `#${name}`;
    if (location.hash !== hash) history.replaceState(null, '', `${location.pathname}${location.search}${hash}`);
    shown.forEach((told) => told(name));
  }

  const named = () => location.hash.slice(1) || 'drive';
  addEventListener('hashchange', () => select(named()));
  tabs.forEach((tab) => tab.addEventListener('click', () => select(nameOf(tab))));

  // From one tab to the next: the arrow keys, Home and End.
  const STEPS = { ArrowLeft: -1, ArrowUp: -1, ArrowRight: 1, ArrowDown: 1 };
  function moved(code, at) {
    if (code in STEPS) return (at + STEPS[code] + tabs.length) % tabs.length;
    return { Home: 0, End: tabs.length - 1 }[code];
  }

  // The robot stands, as far as its last frame says.
  const stands = () => !Robot.condition().problem && ['idle', 'armed', 'faulted'].includes(Robot.latest()?.state);
  const writes = (target) => target.matches?.('input:not([type]),input[type=text]') ?? false;
  const DRIVES = ['ArrowUp', 'ArrowDown', 'ArrowLeft', 'ArrowRight', 'KeyW', 'KeyA', 'KeyS', 'KeyD'];

  // Before robot.js, which drives by arrow keys and stops by the space bar wherever the focus is: among the tabs an arrow key
  // chooses one, arrow keys drive on the tab Drive only, and in a text a space is a space as long as the robot stands.
  addEventListener('keydown', (event) => {
    const at = tabs.indexOf(event.target);
    const next = at >= 0 && !event.ctrlKey && !event.altKey && !event.metaKey ? moved(event.code, at) : undefined;
    if (next !== undefined) {
      event.preventDefault();
      event.stopImmediatePropagation();
      select(nameOf(tabs[next]));
      tabs[next].focus();
    } else if (front !== 'drive' && (DRIVES.includes(event.code) || (event.code === 'Space' && writes(event.target) && stands()))) {
      event.stopImmediatePropagation();
    }
  }, true);

  return {
    select,
    front: () => front,
    // Whether the address names a tab.
    isNamed: () => location.hash.length > 1,
    onShow: (told) => void shown.push(told),
    begin: () => select(named()),
    // A procedure runs there: its tab shows it.
    mark: (kind, words) => {
      for (const tab of tabs) {
        const own = nameOf(tab) === kind && Boolean(words);
        tab.classList.toggle('busy', own);
        own ? tab.setAttribute('aria-description', words) : tab.removeAttribute('aria-description');
      }
    },
  };
})();
