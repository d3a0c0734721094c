// SPDX-License-Identifier: LGPL-2.1-or-later
// The panel at the right: one tab for each kind of control.
import { Attributes } from './attributes.js';
import { ColourPanel } from './colour_panel.js';
import { ContactPanel } from './contact_panel.js';
import { CutPanel } from './cut_panel.js';
import { ExportPanel } from './exports.js';
import { HandsPanel } from './hands_panel.js';
import { Log } from './log.js';
import { Plots } from './plots.js';
import { h } from './dom.js';

const TABS = /** @type {const} */ ([['colour', 'Colour', ColourPanel], ['cut', 'Cut', CutPanel], ['contact', 'Contact', ContactPanel], ['hands', 'Hands', HandsPanel],
  ['attributes', 'Attributes', Attributes], ['plots', 'Plots', Plots], ['log', 'Log', Log], ['export', 'Export', ExportPanel]]);

export class Panels {
  /** @param {HTMLElement} element @param {any} parts */
  constructor(element, parts) {
    this.element = element;
    this.current = '';
    /** @type {Map<string, {tab: any, body: any, panel: any}>} */
    this.tabs = new Map();
    const bar = h('div', { class: 'tabs', role: 'tablist', 'aria-label': 'Controls', onkeydown: (/** @type {KeyboardEvent} */ event) => this.turn(event) });
    element.append(bar);
    for (const [name, title, Panel] of TABS) {
      const body = h('div', { class: 'body', role: 'tabpanel', id: `panel-${name}`, 'aria-labelledby': `tab-${name}`, hidden: true });
      const tab = h('button', { test: `tab-${name}`, type: 'button', role: 'tab', 'aria-selected': 'false', 'aria-controls': `panel-${name}`, onclick: () => this.open(name) }, title);
      bar.append(tab);
      element.append(body);
      this.tabs.set(name, { tab, body, panel: new Panel(body, { ...parts, panels: this }) });
    }
    this.open('colour');
    parts.store.on('selection', () => this.open('attributes'));
  }

  /** @param {string} name */
  open(name) {
    this.current = name;
    for (const [key, { tab, body, panel }] of this.tabs) {
      const on = key === name;
      tab.setAttribute('aria-selected', String(on));
      tab.tabIndex = on ? 0 : -1;
      body.hidden = !on;
      panel.opened?.(on);
    }
  }

  /** @param {KeyboardEvent} event */
  turn(event) {
    const by = { ArrowRight: 1, ArrowLeft: -1, ArrowDown: 4, ArrowUp: -4 }[event.key];
    if (!by) return;
    event.preventDefault();
    event.stopPropagation();
    const names = [...this.tabs.keys()];
    const next = names[(names.indexOf(this.current) + by + names.length) % names.length];
    this.open(next);
    this.tabs.get(next)?.tab.focus();
  }
}
