// SPDX-License-Identifier: LGPL-2.1-or-later
// The bar at the top: name of the scene, run, pause, step, reset, time and speed.
import { choice, h, numberField, signButton } from './dom.js';
import { number } from './formats.js';

const SIGNS = {
  run: 'M4 2.5v11l9.5-5.5z', pause: 'M4 3h3v10H4zM9 3h3v10H9z', step: 'M3 2.5v11l7-5.5zM11 3h2.5v10H11z',
  reset: 'M8 2.5a5.5 5.5 0 1 0 5.5 5.5h-2A3.5 3.5 0 1 1 8 4.5V7l4-3.5L8 0z',
  theme: 'M8 1.5a6.5 6.5 0 1 0 0 13zM8 1.5v1.2a5.3 5.3 0 0 1 0 10.6v1.2a6.5 6.5 0 0 0 0-13z',
  tree: 'M2 2.5h5v3H2zM6 7h8v2.5H6zM6 11h8v2.5H6zM3.5 6h1.2v7H3.5z', panel: 'M2 3h12v2H2zM2 7h12v2H2zM2 11h12v2H2z',
};

export class Bar {
  /** @param {HTMLElement} element @param {any} parts @param {{left: HTMLElement, right: HTMLElement}} sheets */
  constructor(element, { store, commands, stage }, sheets) {
    this.store = store;
    this.commands = commands;
    this.title = h('span', { class: 'title', 'data-test': 'scene-name' }, 'Stroma');
    this.time = h('span', { class: 'time number', 'data-test': 'time' });
    this.speed = h('span', { class: 'speed number quiet', 'data-test': 'speed' });
    this.run = signButton('run', 'Run (space)', SIGNS.run, () => this.tell({ do: 'run' }));
    this.pause = signButton('pause', 'Pause (space)', SIGNS.pause, () => this.tell({ do: 'pause' }));
    this.step = signButton('step', 'One step (arrow right)', SIGNS.step, () => this.tell({ do: 'step', count: 1 }));
    this.reset = signButton('reset', 'Back to the start (Shift+R)', SIGNS.reset, () => this.tell({ do: 'reset' }));
    this.pace = choice('pace', 'Pace of the run', [['real', 'Real time'], ['fast', 'As fast as possible']], 'real', () => this.setPace());
    this.factor = numberField('factor', 'Simulated seconds per second', '1', (value) => value > 0 && this.setPace(), { size: 3 });
    this.runGroup = h('div', { class: 'group', role: 'group', 'aria-label': 'Run' }, this.run, this.pause, this.step, this.reset);
    this.paceGroup = h('div', { class: 'group pace' }, this.pace, this.times = h('span', { class: 'quiet' }, '×'), this.factor);
    const theme = signButton('theme', 'Light or dark', SIGNS.theme, () =>
      store.setView({ theme: document.documentElement.dataset.theme === 'dark' ? 'light' : 'dark' }));
    const help = h('button', { test: 'help', type: 'button', class: 'sign', title: 'Keys (?)', 'aria-label': 'Keys', onclick: () => store.emit('help') }, '?');
    const sheet = (/** @type {string} */ test, /** @type {string} */ label, /** @type {string} */ sign, /** @type {HTMLElement} */ panel, /** @type {HTMLElement} */ other) => {
      const button = signButton(test, label, sign, () => {
        other.classList.remove('open');
        panel.classList.toggle('open');
      });
      button.classList.add('only-small');
      return button;
    };
    element.append(this.title, this.runGroup, this.time, this.paceGroup, this.speed, h('span', { class: 'space' }),
      sheet('sheet-tree', 'Scene', SIGNS.tree, sheets.left, sheets.right), sheet('sheet-panel', 'Controls', SIGNS.panel, sheets.right, sheets.left),
      theme, help);
    stage.canvas.addEventListener('pointerdown', () => {
      sheets.left.classList.remove('open');
      sheets.right.classList.remove('open');
    });
    store.on('status', () => this.update());
    store.on('frame', () => this.showTime());
    store.on('scene', () => {
      this.title.textContent = this.title.title = store.scene.name;
      document.title = `${store.scene.name} – Stroma`;
      const live = store.scene.mode === 'live' && commands.connection;
      this.runGroup.hidden = this.paceGroup.hidden = this.speed.hidden = !live;
      this.showTime();
    });
    this.update();
  }

  /** @param {any} message */
  tell(message) {
    return this.commands.tell(message);
  }

  setPace() {
    const factor = Number(this.factor.value.replace(',', '.'));
    this.tell({ do: 'pace', pace: this.pace.value, factor: factor > 0 ? factor : 1 });
  }

  toggle() {
    this.tell({ do: this.store.status.running ? 'pause' : 'run' });
  }

  showTime() {
    const header = this.store.shown?.header;
    const instant = header && (header.step > 0 || this.store.scene?.mode !== 'recording') ? ` · step ${header.step}` : '';
    this.time.textContent = header ? `t = ${number(header.time, 4)} s${instant}` : '';
  }

  update() {
    const { status } = this.store;
    this.run.setAttribute('aria-pressed', String(!!status.running));
    this.pause.setAttribute('aria-pressed', String(!status.running));
    if (document.activeElement !== this.pace) this.pace.value = status.pace ?? 'real';
    if (document.activeElement !== this.factor) this.factor.value = String(status.factor ?? 1);
    this.factor.hidden = this.times.hidden = this.pace.value === 'fast';
    this.speed.textContent = status.running && status.ratio > 0
      ? `${number(status.ratio, 2)} × real time · ${number(status.steps_per_second ?? 0, 3)} steps/s` : status.running ? 'starting' : 'paused';
    this.showTime();
  }
}
