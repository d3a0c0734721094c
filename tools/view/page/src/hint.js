// SPDX-License-Identifier: LGPL-2.1-or-later
// What one must know of the picture while looking at it: what the pointer does, where the cut is and how it is moved, and
// that displacements are not drawn as they are. It stands at the canvas, and is drawn into pictures and videos where it
// changes what they show.
import { h } from './dom.js';
import { number, quantity } from './formats.js';

const HANDS = { pull: 'Pull: drag a body', hold: 'Hold: drag a body and let go', push: 'Push: press on a body; the wheel moves the ball' };

/** What pictures must say: displacements that are not drawn as they are. @param {import('./store.js').Store} store */
export function exaggerationText(store) {
  const { exaggeration } = store.view;
  return exaggeration === 1 ? '' : `Displacements drawn × ${number(exaggeration)}`;
}

/** "x = 12 mm", or the normal's own axis. @param {any} store @param {any} stage */
export function cutText(store, stage) {
  const { normal, offset } = stage.cut.plane(stage.restBox);
  const { flip } = store.view.cut;
  const axis = normal.findIndex((/** @type {number} */ c) => Math.abs(Math.abs(c) - 1) < 1e-9);
  const place = (flip ? -1 : 1) * offset;
  return `${axis < 0 ? 'along the normal' : 'xyz'[axis]} = ${quantity(place, store.unit('m'), 3)}`;
}

export class Hint {
  /** @param {HTMLElement} parent @param {any} parts */
  constructor(parent, { store, stage, hands }) {
    Object.assign(this, { store, stage, hands });
    this.store = store;
    this.stage = stage;
    this.hands = hands;
    this.element = h('div', { id: 'hint', 'data-test': 'hint', role: 'status', hidden: true });
    parent.append(this.element);
    for (const event of ['hand-mode', 'view', 'scene']) store.on(event, () => this.update());
    this.update();
  }

  lines() {
    const { store } = this;
    const lines = [];
    const hand = /** @type {any} */ (HANDS)[this.hands.mode];
    if (hand) lines.push(`${hand} (1: look again)`);
    if (store.view.cut.on && store.scene && !this.stage.restBox.isEmpty()) lines.push(`Cut at ${cutText(store, this.stage)} ([ and ] move it, C ends it)`);
    if (exaggerationText(store)) lines.push(exaggerationText(store));
    if (this.stage.follows) lines.push('The camera follows the bodies (G ends it)');
    return lines;
  }

  update() {
    const lines = this.lines();
    this.element.hidden = lines.length === 0;
    this.element.replaceChildren(...lines.map((line) => h('div', {}, line)));
  }

  /** Draws into a picture what it must say. @param {CanvasRenderingContext2D} context @param {number} scale pixels per CSS pixel */
  draw(context, scale) {
    const text = exaggerationText(this.store);
    if (!text) return;
    context.save();
    context.scale(scale, scale);
    context.font = '600 13px system-ui, sans-serif';
    context.textBaseline = 'middle';
    context.fillStyle = getComputedStyle(document.documentElement).getPropertyValue('--text');
    context.fillText(text, 14, 22);
    context.restore();
  }
}
