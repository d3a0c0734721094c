// SPDX-License-Identifier: LGPL-2.1-or-later
// The node picked last: a mark on it, its numbers, and a button that plots it.
import { h } from './dom.js';
import { number, quantity } from './formats.js';
import { pick } from './picking.js';
import { Balls } from './shapes.js';

const STILL = 4; // CSS pixels a click may move

/** @param {HTMLElement} parent @param {any} parts */
export function showPicked(parent, { store, stage, hands, panels }) {
  const mark = new Balls([0.15, 0.55, 0.75], 1);
  stage.world.add(mark.object);
  const text = h('span', { class: 'number' });
  const plot = h('button', { test: 'plot-node', class: 'small', type: 'button', onclick: () => {
    panels.tabs.get('plots').panel.watch(picked.body, picked.node);
    panels.open('plots');
  } }, 'Plot');
  const close = h('button', { test: 'unpick', class: 'small', type: 'button', 'aria-label': 'Forget the picked node', onclick: () => choose(null) }, '×');
  const card = h('div', { id: 'picked', 'data-test': 'picked', hidden: true }, text, plot, close);
  parent.append(card);
  /** @type {Map<string, number>} the last ones known [N] */
  const reactions = new Map();
  /** @type {any} */
  let picked = null;
  /** @type {any} */
  let pressed = null;

  const update = () => {
    const body = picked && store.bodies[picked.body];
    card.hidden = !body;
    if (!body) return mark.set([]);
    const x = [...body.x.subarray(3 * picked.node, 3 * picked.node + 3)];
    mark.set(body.visible ? [{ at: stage.views[picked.body].drawnAt(picked.node), radius: 0.008 * (body.size || 1) }] : []);
    const name = `node.${picked.body}.${body.sceneNode[picked.node]}.reaction`;
    // not every frame has it, as it takes a pass over all elements
    const reaction = ['x', 'y', 'z'].map((axis) => store.shown?.header.values?.[`${name}.${axis}`]);
    if (reaction.every(Number.isFinite)) reactions.set(name, Math.hypot(...reaction));
    const force = reactions.get(name) ?? 0;
    text.textContent = `${body.name}, node ${body.sceneNode[picked.node]}: ${x.map((c) => number(c, 4)).join(', ')} ${store.unit('m')}`.trim() + (force > 0 ? `, reaction ${quantity(force, store.unit('N'))}` : '');
  };
  const choose = (/** @type {any} */ now) => {
    picked = store.picked = now && { body: now.body, node: now.node };
    store.emit('watched');
    update();
    stage.requestDraw();
  };
  store.on('picked', choose);
  store.on('scene', () => store.sameScene || choose(store.changed ? store.nodeNow(picked) : null));
  store.on('frame', update);
  stage.canvas.addEventListener('pointerdown', (/** @type {PointerEvent} */ event) => (pressed = event.isPrimary && event.button === 0 ? { x: event.clientX, y: event.clientY } : null), { capture: true });
  stage.canvas.addEventListener('pointerup', (/** @type {PointerEvent} */ event) => {
    const still = pressed && Math.hypot(event.clientX - pressed.x, event.clientY - pressed.y) < STILL;
    pressed = null;
    if (still && hands.mode === 'look' && store.scene) choose(pick(stage, event.clientX, event.clientY));
  }, { capture: true });
}
