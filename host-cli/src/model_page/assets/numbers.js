// Numbers as people read them, elements, and drawings.
'use strict';

const text = {
  // Metres in millimetres; radians in milliradians.
  milli: (value, unit) => {
    if (value === null || value === undefined) return '';
    const size = value * 1e3;
    return `${size.toFixed(Math.abs(size) < 1 ? 2 : 1)} ${unit}`;
  },
  // A value to the second digit of its standard error.
  value: (value, sigma, unit) => {
    const digits = Math.min(8, Math.max(0, 1 - Math.floor(Math.log10(sigma > 0 ? sigma : Math.abs(value) / 1e3 || 1))));
    const one = unit === '1' ? '' : ` ${unit}`;
    return sigma > 0 ? `${value.toFixed(digits)} \u00b1 ${sigma.toFixed(digits)}${one}` : `${value.toFixed(digits)}${one}`;
  },
  change: (before, after) => (before > 0 ? `${after < before ? '\u2212' : '+'}${Math.abs(100 * (after / before - 1)).toFixed(0)} %` : ''),
  // Two digits of the half-width, as the commands print it.
  interval: (low, high) => {
    const half = Math.abs(high - low) / 2;
    if (!(half > 0) || !Number.isFinite(half)) return `${text.short(low)} to ${text.short(high)}`;
    const digits = Math.min(12, Math.max(0, 1 - Math.floor(Math.log10(half))));
    return [low, high].map((value) => value.toFixed(digits).replace('-', '\u2212')).join(' to ');
  },
  short: (value) => Number(value.toPrecision(3)).toString().replace('-', '\u2212'),
};

function element(name, properties = {}, ...children) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(properties)) {
    if (key in made && key !== 'list') made[key] = value;
    else made.setAttribute(key, value);
  }
  made.append(...children);
  return made;
}

function drawn(name, attributes = {}, ...children) {
  const made = document.createElementNS('http://www.w3.org/2000/svg', name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.append(...children);
  return made;
}

const line = (points) => points.map(([x, y], k) => `${k ? 'L' : 'M'}${x.toFixed(1)} ${y.toFixed(1)}`).join('');

// 1, 2 or 5 times a power of ten, so that about `count` steps fill the span.
function niceStep(span, count) {
  const rough = span / count;
  const power = 10 ** Math.floor(Math.log10(rough));
  return power * ([1, 2, 5].find((step) => step * power >= rough) ?? 10);
}

// Moves a drawing from what it shows to what it should; at once for people who want no motion.
const still = matchMedia('(prefers-reduced-motion: reduce)');
function glide(from, to, show) {
  if (still.matches || !from || from.length !== to.length) return show(to), () => {};
  const begun = performance.now();
  let frame;
  const step = (now) => {
    const share = Math.min(1, (now - begun) / 350);
    const eased = 1 - (1 - share) ** 3;
    show(to.map((value, k) => from[k] + (value - from[k]) * eased));
    if (share < 1) frame = requestAnimationFrame(step);
  };
  frame = requestAnimationFrame(step);
  return () => cancelAnimationFrame(frame);
}

const tip = document.getElementById('tip');
function showTip(event, words) {
  tip.textContent = words;
  tip.hidden = false;
  const left = Math.min(event.clientX + 14, innerWidth - tip.offsetWidth - 8);
  tip.style.left = `${Math.max(8, left)}px`;
  tip.style.top = `${Math.max(8, event.clientY - tip.offsetHeight - 12)}px`;
}
const hideTip = () => (tip.hidden = true);
