// SPDX-License-Identifier: LGPL-2.1-or-later
// The banner over the picture: loss of the connection, another page's control, the end of a run.
import { h } from './dom.js';

const NOTICE = 7000; // [ms] a notice stays

export class Banner {
  /** @param {HTMLElement} element @param {import('./store.js').Store} store @param {import('./commands.js').Commands} commands */
  constructor(element, store, commands) {
    this.element = element;
    this.store = store;
    this.commands = commands;
    this.controlAsked = false;
    this.notice = '';
    store.on('notice', (text) => {
      this.notice = text;
      clearTimeout(this.timer);
      this.timer = setTimeout(() => {
        this.notice = '';
        this.update();
      }, NOTICE);
      this.update();
    });
    for (const event of ['connection', 'status', 'scene']) store.on(event, () => this.update());
    store.on('control-needed', () => {
      this.controlAsked = true;
      this.update();
    });
  }

  /** @param {string} sentence @param {string} kind @param {any[]} more */
  show(sentence, kind = '', ...more) {
    if (sentence === this.shown) return;
    this.shown = sentence;
    this.element.hidden = !sentence;
    this.element.className = kind;
    this.element.replaceChildren(h('span', {}, sentence), ...more);
  }

  update() {
    const { connection, status } = this.store;
    if (connection.state === 'reload')
      return this.show(connection.sentence, '', h('button', { test: 'reload', type: 'button', onclick: () => location.reload() }, 'Reload'));
    if (connection.state === 'lost') return this.show(connection.sentence, 'bad');
    if (status.ended) return this.show(`The run has stopped: ${status.ended}`, 'bad');
    if (this.controlAsked && status.control !== null && status.control !== this.store.scene?.client)
      return this.show('Another page has control of this run.', '', h('button', { test: 'take-control', type: 'button',
        onclick: () => this.commands.takeControl()?.then((reply) => !reply.ok && this.store.say('error', reply.message)) }, 'Take control'));
    this.controlAsked = false;
    if (this.noteShown) return;
    if (this.notice) return this.show(this.notice);
    this.show('');
  }
}
