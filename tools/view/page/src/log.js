// SPDX-License-Identifier: LGPL-2.1-or-later
// The tab "Log": messages and doubts as they come, and the plan of the solver.
import { h } from './dom.js';

export class Log {
  /** @param {HTMLElement} body @param {any} parts */
  constructor(body, { store, commands }) {
    this.store = store;
    this.commands = commands;
    this.body = body;
    this.count = 0;
    this.doubts = h('div', { 'data-test': 'doubts' });
    this.list = h('div', { test: 'messages', role: 'log' });
    this.plan = h('pre', { class: 'plan', test: 'plan', hidden: true });
    const explain = h('button', { test: 'explain', type: 'button', onclick: () => {
      if (this.plan.hidden) commands.request({ do: 'explain' });
      this.plan.hidden = true;
    } }, 'Explain the plan');
    body.append(h('div', { class: 'buttons' }, explain), this.plan, h('h2', {}, 'Doubts'), this.doubts, h('h2', {}, 'Messages'), this.list);
    store.on('explain', (message) => {
      this.plan.hidden = false;
      this.plan.textContent = message.lines.join('\n');
    });
    store.on('messages', (message) => this.add(message.lines));
    store.on('status', () => this.showDoubts());
    this.showDoubts();
  }

  /** @param {{severity: string, text: string}[]} lines */
  add(lines) {
    const atEnd = this.body.scrollTop + this.body.clientHeight > this.body.scrollHeight - 30;
    for (const { severity, text } of lines) this.list.append(h('div', { class: `message ${severity}` }, text));
    while (this.list.children.length > 1000) this.list.firstChild.remove();
    if (atEnd) this.body.scrollTop = this.body.scrollHeight;
    const tab = document.getElementById('tab-log');
    if (tab && this.body.hidden && lines.some(({ severity }) => severity !== 'note')) tab.textContent = 'Log •';
  }

  /** @param {boolean} on */
  opened(on) {
    const tab = document.getElementById('tab-log');
    if (on && tab) tab.textContent = 'Log';
  }

  showDoubts() {
    const key = (this.store.status.doubts ?? []).join('\n');
    if (key === this.shown) return;
    this.shown = key;
    this.doubts.replaceChildren(...(key ? this.store.status.doubts.map((/** @type {string} */ text) => h('div', { class: 'message warning' }, text)) : [h('p', { class: 'quiet' }, 'None.')]));
  }
}
