// SPDX-License-Identifier: LGPL-2.1-or-later
// The keyboard.
import { h } from './dom.js';

const HELP = [['Space', 'Run or pause; play in a recording'], ['→', 'One step; the next frame when looking back'], ['←', 'The frame before'],
  ['F', 'Frame the bodies'], ['R', 'The first view again'], ['Shift R', 'Back to the start of the run'], ['1 2 3 4', 'Look, pull, hold, push'],
  ['Page up, Page down', 'Move the ball along the view while pushing'], ['W', 'Wireframe'], ['C', 'Cut'], ['L', 'Legend'], ['Esc', 'End a drag'], ['?', 'These keys']];

/** @param {any} parts */
export function listenToKeys({ store, stage, hands, timeline, bar }) {
  const dialog = h('dialog', { 'aria-label': 'Keys', test: 'keys' }, h('h1', {}, 'Keys'),
    h('table', { class: 'keys' }, ...HELP.map(([keys, text]) => h('tr', {}, h('td', {}, h('kbd', {}, keys)), h('td', {}, text)))),
    h('p', { class: 'quiet' }, 'Drag turns the view, the right button moves it, the wheel comes nearer.'),
    h('form', { method: 'dialog' }, h('button', { class: 'main' }, 'Close')));
  document.body.append(dialog);
  const help = () => (dialog.open ? dialog.close() : dialog.showModal());
  store.on('help', help);
  const live = () => timeline.mode === 'live';
  /** @type {Record<string, () => void>} */
  const actions = {
    ' ': () => (live() ? bar.toggle() : timeline.toggle()),
    ArrowRight: () => (live() && store.following ? bar.tell({ do: 'step', count: 1 }) : timeline.move(1)),
    ArrowLeft: () => timeline.move(-1),
    r: () => stage.view(), R: () => live() && bar.tell({ do: 'reset' }), f: () => stage.fit(), F: () => stage.fit(),
    1: () => hands.setMode('look'), 2: () => hands.setMode('pull'), 3: () => hands.setMode('hold'), 4: () => hands.setMode('push'),
    w: () => store.setView({ wireframe: !store.view.wireframe }), c: () => store.setCut({ on: !store.view.cut.on }), l: () => store.setView({ legend: !store.view.legend }),
    PageUp: () => hands.deepen(0.15, performance.now()), PageDown: () => hands.deepen(-0.15, performance.now()),
    Escape: () => {
      if (hands.end(true)) return;
      for (const id of ['left', 'right']) document.getElementById(id)?.classList.remove('open');
    }, '?': help,
  };
  window.addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || dialog.open) return;
    const target = /** @type {HTMLElement} */ (event.target);
    const typing = target.matches('input[type="text"], textarea, select, [contenteditable]');
    if (typing && event.key !== 'Escape') return;
    // A button, a box or a slider that has the focus keeps the keys that work it.
    if (target.matches('button, summary, a, input[type="checkbox"]') && event.key === ' ') return;
    if (target.matches('input[type="range"], [role="tab"]') && /^(Arrow|Page)/.test(event.key)) return;
    const action = actions[event.key] ?? (event.shiftKey ? undefined : actions[event.key.toLowerCase()]);
    if (!action) return;
    event.preventDefault();
    action();
  });
}
