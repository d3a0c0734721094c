// SPDX-License-Identifier: LGPL-2.1-or-later
// The keyboard.
import { h } from './dom.js';
import { pickMiddle } from './picking.js';

const HELP = [['Space', 'Run or pause; play in a recording'], ['→', 'One step; the next frame when looking back'], ['←', 'The frame before'],
  ['Shift R', 'Back to the start of the run'], ['Shift + arrows', 'Turn the view'], ['Alt + arrows', 'Move the view'], ['+ −', 'Come nearer, go away'],
  ['F', 'Frame the bodies'], ['Shift F', 'Frame one body after the other'], ['G', 'The camera follows the bodies, or not'], ['R', 'The first view again'], ['1 2 3 4', 'Look, pull, hold, push'], ['N', 'Pick the node in the middle of the picture'],
  ['Enter', 'Take the picked node; let it go, or leave it held'], ['Arrows, PgUp, PgDn', 'Move what Enter took: in the picture, and along the view'],
  ['PgUp PgDn', 'Move the ball along the view while pushing'], ['W', 'Wireframe'], ['C', 'Cut'], ['[ ]', 'Move the cut'], ['L', 'Legend'],
  ['Esc', 'Let go'], ['Ctrl + key', 'To the controllers of a scene in Python; so does a key that has no use here'], ['?', 'These keys']];

const TURN = Math.PI / 24; // a press
const MOVE = 0.05; // of the picture's height
const NEARER = 0.9; // of the distance
const CUT = 0.02; // of the way through the bodies
const PULL = 0.02; // of the body's size
/** @type {Record<string, number[]>} to the right, up, away */
const DIRECTIONS = { ArrowRight: [1, 0, 0], ArrowLeft: [-1, 0, 0], ArrowUp: [0, 1, 0], ArrowDown: [0, -1, 0], PageUp: [0, 0, 1], PageDown: [0, 0, -1] };

/**
 * The name of a key with its modifier. Letters are told by Shift alone: Caps Lock changes nothing.
 * @param {{key: string, shiftKey: boolean, altKey: boolean}} event
 */
export function nameOfKey({ key, shiftKey, altKey }) {
  const letter = /^\p{L}$/u.test(key);
  const modifier = altKey ? 'Alt ' : shiftKey && (letter || key.length > 1) ? 'Shift ' : ''; // a sign has its Shift in it
  return modifier + (letter ? key.toLowerCase() : key);
}

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
    r: () => stage.view(), 'Shift r': () => live() && bar.tell({ do: 'reset' }), f: () => stage.fit(), 'Shift f': () => stage.fitNext(), g: () => stage.follow(!stage.follows),
    1: () => hands.setMode('look'), 2: () => hands.setMode('pull'), 3: () => hands.setMode('hold'), 4: () => hands.setMode('push'),
    w: () => store.setView({ wireframe: !store.view.wireframe }), c: () => store.setCut({ on: !store.view.cut.on }), '[': () => store.setCut({ on: true, place: Math.max(0, store.view.cut.place - CUT) }), ']': () => store.setCut({ on: true, place: Math.min(1, store.view.cut.place + CUT) }),
    l: () => store.setView({ legend: !store.view.legend }),
    n: () => {
      if (!store.scene) return;
      store.emit('picked', pickMiddle(stage));
      stage.canvas.focus({ preventScroll: true }); // so that Enter is not that of a button
    },
    Enter: () => {
      if (hands.drag?.keys) return hands.end(false);
      if (!store.picked && live() && store.scene) store.emit('picked', pickMiddle(stage));
      if (hands.beginByKeys(store.picked)) stage.canvas.focus({ preventScroll: true });
    },
    '+': () => stage.zoom(NEARER), '=': () => stage.zoom(NEARER), '-': () => stage.zoom(1 / NEARER),
    PageUp: () => hands.deepen(0.15, performance.now()), PageDown: () => hands.deepen(-0.15, performance.now()),
    Escape: () => {
      if (hands.end(true)) return;
      for (const id of ['left', 'right']) document.getElementById(id)?.classList.remove('open');
    }, '?': help,
  };
  for (const [key, [right, up]] of Object.entries(DIRECTIONS).slice(0, 4)) {
    actions[`Shift ${key}`] = () => stage.turn(right * TURN, up * TURN);
    actions[`Alt ${key}`] = () => stage.move(right * MOVE, up * MOVE);
  }
  /** Keys that a scene in Python has been told. @type {Set<string>} */
  const down = new Set();
  /** @param {KeyboardEvent} event */
  const toScene = (event) => {
    if (!store.scene?.keys || !live() || ['Control', 'Shift', 'Alt', 'Meta'].includes(event.key)) return;
    event.preventDefault();
    down.add(event.code);
    hands.commands.send({ do: 'key', key: event.key, pressed: true });
  };
  window.addEventListener('keyup', (event) => {
    if (down.delete(event.code)) hands.commands.send({ do: 'key', key: event.key, pressed: false });
  });
  window.addEventListener('keydown', (event) => {
    if (event.metaKey || dialog.open) return;
    if (event.ctrlKey) return toScene(event);
    const target = /** @type {HTMLElement} */ (event.target);
    const typing = target.matches('input[type="text"], textarea, select, [contenteditable]');
    if (typing && event.key !== 'Escape') return;
    // A button, a box or a slider that has the focus keeps the keys that work it.
    if (target.matches('button, summary, a, input[type="checkbox"]') && (event.key === ' ' || event.key === 'Enter')) return;
    if (target.matches('input[type="range"], [role="tab"]') && /^(Arrow|Page)/.test(event.key)) return;
    const name = nameOfKey(event);
    const taken = hands.drag?.keys && DIRECTIONS[name];
    const action = taken ? () => hands.moveByKeys(PULL * taken[0], PULL * taken[1], PULL * taken[2]) : actions[name];
    if (!action) return toScene(event);
    if (event.repeat && event.key === 'Enter') return;
    event.preventDefault();
    action();
  });
}
