// SPDX-License-Identifier: LGPL-2.1-or-later
// The tab "Hands": what the pointer does, how stiff it pulls, what is held and with which force.
import { choice, h, numberField, row } from './dom.js';
import { quantity } from './formats.js';

const MODES = [['look', 'Look'], ['pull', 'Pull'], ['hold', 'Hold'], ['push', 'Push']];
const HELP = {
  look: 'Drag turns the view, the right button moves it, the wheel comes nearer.',
  pull: 'Drag a body: a spring pulls it towards the pointer until you let go.',
  hold: 'Drag a body and let go: the place stays held. Drag its end to move it.',
  push: 'Press on a body: a ball pushes it. The wheel, Page up and Page down move the ball along the view.',
};

export class HandsPanel {
  /** @param {HTMLElement} body @param {any} parts */
  constructor(body, { store, hands, commands }) {
    Object.assign(this, { store, hands });
    this.store = store;
    this.hands = hands;
    this.modes = MODES.map(([mode, label], i) => h('button', { test: `hand-${mode}`, type: 'button', title: `${label} (${i + 1})`, onclick: () => hands.setMode(mode) }, label));
    this.help = h('p', { class: 'quiet' });
    this.stiffness = numberField('stiffness', 'Stiffness of the spring', '', (value, text) => {
      const good = text === '' || value > 0;
      hands.stiffness = text === '' || !good ? null : value;
      this.problem.textContent = good ? '' : `"${text}" is no stiffness; a number above zero was expected, or nothing to let the server choose.`;
    }, { placeholder: 'automatic' });
    this.problem = h('div', { class: 'error', 'data-error': 'stiffness' });
    this.grip = choice('grip', 'What is taken', [['patch', 'A patch as wide as the ball'], ['face', 'Face under the pointer'], ['node', 'Nearest node']], hands.grip, (grip) => (hands.grip = grip));
    this.radius = h('input', { test: 'ball', type: 'range', min: 0.02, max: 0.3, step: 0.01, value: hands.radius, 'aria-label': 'Radius of the ball', oninput: () => {
      hands.radius = Number(this.radius.value);
      this.update();
    } });
    this.radiusText = h('span', { class: 'unit number' });
    this.list = h('ul', { class: 'list', 'data-test': 'hands-list' });
    this.total = h('p', { class: 'number', 'data-test': 'force' });
    body.append(h('div', { class: 'segments wide', role: 'group', 'aria-label': 'Hand' }, ...this.modes), this.help, row('Stiffness', this.stiffness, this.stiffnessUnit = h('span', { class: 'unit' })), this.problem,
      row('Takes', this.grip), row('Width', this.radius, this.radiusText), h('h2', {}, 'In action'), this.list, this.total,
      h('div', { class: 'buttons' }, h('button', { test: 'release-all', type: 'button', onclick: () => hands.releaseAll() }, 'Let all go')),
      this.control = h('div', {}, h('p', { class: 'quiet' }), h('button', { test: 'control', type: 'button', onclick: () => commands.takeControl() }, 'Take control')));
    store.on('hand-mode', () => this.update());
    store.on('scene', () => this.update());
    store.on('frame', () => this.forces());
    store.on('status', () => this.controls());
    this.update();
    this.controls();
  }

  update() {
    const { mode } = this.hands;
    MODES.forEach(([name], i) => this.modes[i].setAttribute('aria-pressed', String(name === mode)));
    this.help.textContent = /** @type {any} */ (HELP)[mode];
    this.stiffnessUnit.textContent = this.store.unit('N/m');
    this.radiusText.textContent = quantity(this.hands.radius * (this.store.bodies[0]?.size ?? 1), this.store.unit('m'), 2);
  }

  controls() {
    const { status, scene } = this.store;
    const mine = scene && status.control === scene.client;
    this.control.querySelector('p').textContent = !scene || scene.mode !== 'live' ? '' : mine ? 'This page has control of the run.'
      : status.control === null || status.control === undefined ? 'No page has control; the first command takes it.' : 'Another page has control of the run.';
    this.control.querySelector('button').hidden = !scene || mine || status.control === null || scene.mode !== 'live';
  }

  forces() {
    const all = this.store.shown?.header.hands ?? [];
    if (all.length !== this.list.children.length) {
      this.list.replaceChildren(...all.map((/** @type {any} */ hand) => h('li', {}, h('span', { class: 'number' }),
        hand.client === this.store.scene.client ? h('button', { class: 'small', type: 'button', onclick: () => this.hands.release(this.store.shown.header.hands[all.indexOf(hand)]?.hand ?? hand.hand) }, 'Let go') : null)));
    }
    all.forEach((/** @type {any} */ hand, /** @type {number} */ i) => {
      const body = this.store.bodies[hand.body];
      const what = hand.kind === 'push' ? `pushes ${hand.touched ?? 0} nodes` : `${hand.kind}s node ${body?.sceneNode[hand.node]}`;
      this.list.children[i].firstChild.textContent = `${body?.name}: ${what}, ${quantity(Math.hypot(...hand.force), this.store.unit('N'), 4)}`;
    });
    this.total.textContent = all.length ? '' : 'Nothing is pulled, held or pushed.';
  }
}
