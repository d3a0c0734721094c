// SPDX-License-Identifier: LGPL-2.1-or-later
// The tab "Attributes": those of the chosen node or component, edited in place where that is possible while the scene runs.
import { h } from './dom.js';
import { watchedByMonitor } from './monitors.js';

export class Attributes {
  /** @param {HTMLElement} body @param {any} parts */
  constructor(body, { store, commands, panels }) {
    this.panels = panels;
    this.body = body;
    this.store = store;
    this.commands = commands;
    /** What was typed and refused, by path and attribute: kept when the panel is built anew. @type {Map<string, {text: string, error: string}>} */
    this.refused = new Map();
    /** What is typed and not yet sent. @type {Map<string, string>} */
    this.drafts = new Map();
    /** How new values get into the rows that are shown, by name of the attribute. @type {Map<string, (attribute: any) => void>} */
    this.rows = new Map();
    this.shape = '';
    store.on('selection', () => this.build());
    store.on('components', () => this.refresh());
    this.build();
  }

  /** @param {boolean} on */
  opened(on) {
    if (on) this.commands.request({ do: 'components' }); // outputs change while the scene runs
  }

  /** @param {any} [node] @returns {any} the node or component with the chosen path */
  find(node = this.store.components) {
    const { selected } = this.store;
    if (!node) return null;
    if (node.path === selected) return node;
    for (const component of node.components ?? []) if (component.path === selected) return component;
    for (const child of node.children ?? []) {
      const found = this.find(child);
      if (found) return found;
    }
    return null;
  }

  /** New values in the rows that are shown: nothing that has the focus, or is being clicked or typed into, is made anew. */
  refresh() {
    const item = this.find();
    if (!item || shapeOf(item) !== this.shape) return this.build();
    for (const attribute of item.attributes ?? []) this.rows.get(attribute.name)?.(attribute);
    this.showMonitor(item);
  }

  build() {
    const item = this.find();
    this.rows.clear();
    this.shape = item ? shapeOf(item) : '';
    if (!item) {
      this.body.replaceChildren(h('p', { class: 'quiet' }, this.store.components || this.commands.connection
        ? 'Choose a node or a component in the tree of the scene.' : 'A recording holds no attributes.'));
      return;
    }
    const scroll = this.body.scrollTop;
    const attributes = (item.attributes ?? []);
    const order = (/** @type {any} */ a) => (a.output ? 3 : a.change === 'at_once' || a.change === 'recompile' ? 0 : a.given ? 1 : 2);
    this.body.replaceChildren(h('h2', {}, item.path), h('p', {}, h('strong', {}, item.type ? `${item.type} ` : 'Node '), item.name),
      item.help ? h('p', { class: 'quiet' }, sentence(item.help)) : null, this.monitor = h('div', { class: 'buttons', hidden: true }),
      ...[...attributes].sort((a, b) => order(a) - order(b)).map((attribute) => this.attribute(item, attribute)));
    this.showMonitor(item);
    this.body.scrollTop = scroll;
  }

  /** The button that plots what a monitor watches. @param {any} item */
  showMonitor(item) {
    const watched = watchedByMonitor(item, this.store.bodies);
    const key = JSON.stringify(watched);
    if (!watched || this.monitor.dataset.key === key) return;
    this.monitor.dataset.key = key;
    this.monitor.hidden = false;
    const most = this.panels.tabs.get('plots')?.panel.mostNodes ?? 0;
    const nodes = watched.nodes.slice(0, most);
    const text = watched.problem || (nodes.length < watched.nodes.length ? `Plot the first ${nodes.length} of its ${watched.nodes.length} nodes` : nodes.length > 1 ? `Plot its ${nodes.length} nodes` : 'Plot its node');
    this.monitor.replaceChildren(watched.problem ? h('p', { class: 'quiet' }, text) : h('button', { test: 'plot-monitor', type: 'button', onclick: () => {
      for (const node of nodes) this.panels.tabs.get('plots').panel.watch(watched.body, node);
      this.panels.open('plots');
    } }, text));
  }

  /** @param {any} item @param {any} attribute as it was told last */
  attribute(item, attribute) {
    const key = `${item.path} ${attribute.name}`;
    const live = !attribute.output && !attribute.long && (attribute.change === 'at_once' || attribute.change === 'recompile') && this.commands.connection;
    const kept = this.refused.get(key);
    const error = h('div', { class: 'error', 'data-error': `${item.path}.${attribute.name}`, role: 'alert', hidden: !kept }, kept?.error ?? '');
    const names = { 'data-path': item.path, 'data-attribute': attribute.name, id: `attribute-${key}`, 'aria-label': `${attribute.name} of ${item.path}` };
    let control;
    let show = (/** @type {string} */ value) => {
      const busy = this.drafts.has(key) || this.refused.has(key) || control.dataset.state === 'asked';
      if (!busy && control.value !== value) control.value = value;
    };
    if (live && attribute.choices?.length) {
      control = h('select', { ...names, onchange: () => this.set(item, attribute, control, error) },
        ...attribute.choices.map((/** @type {string} */ value) => h('option', { value }, value)));
      control.value = attribute.value;
    } else if (live && attribute.type === 'bool') {
      control = h('select', { ...names, onchange: () => this.set(item, attribute, control, error) }, h('option', { value: 'true' }, 'true'), h('option', { value: 'false' }, 'false'));
      const showWord = show;
      show = (value) => showWord(/^(1|true)$/i.test(value) ? 'true' : 'false');
      show(attribute.value);
    } else if (live) {
      control = h('input', { ...names, type: 'text', spellcheck: 'false', autocomplete: 'off', value: this.drafts.get(key) ?? kept?.text ?? attribute.value, class: kept ? 'wrong' : this.drafts.has(key) ? 'draft' : '', title: 'Enter sets it, Escape takes the old value back',
        oninput: () => this.draft(key, control, attribute.value), onchange: () => this.draft(key, control, attribute.value),
        onkeydown: (/** @type {KeyboardEvent} */ event) => {
          if (event.key === 'Enter') this.set(item, attribute, control, error);
          else if (event.key === 'Escape') {
            this.refused.delete(key);
            this.drafts.delete(key);
            control.value = attribute.value;
            control.classList.remove('wrong', 'draft');
            error.hidden = true;
            event.stopPropagation();
          }
        } });
    } else {
      control = h('span', { class: 'value mono', ...names }, shortened(attribute.value, attribute.long) || '–');
      show = () => {
        const text = shortened(attribute.value, attribute.long) || '–';
        if (control.textContent !== text) control.textContent = text;
      };
    }
    const facts = [attribute.range ? `Range: ${attribute.range}.` : '', attribute.default !== undefined && attribute.default !== '' ? `Default: ${shortened(attribute.default, false)}.` : '',
      attribute.change === 'restart' && !attribute.output ? 'A change needs a restart.' : ''].filter(Boolean).join(' ');
    const row = h('div', { class: `attribute${attribute.given ? ' given' : ''}` },
      h('div', { class: 'line' }, h('label', { for: live ? `attribute-${key}` : null }, attribute.name), control, attribute.unit && attribute.unit !== '-' ? h('span', { class: 'unit' }, attribute.unit) : null,
        attribute.output ? h('span', { class: 'tag' }, 'output') : null), error,
      h('div', { class: 'help' }, [sentence(attribute.help), facts].filter(Boolean).join(' ')));
    this.rows.set(attribute.name, (now) => {
      attribute = now;
      row.classList.toggle('given', !!now.given);
      show(now.value);
    });
    return row;
  }

  /** Keeps what is typed while new values come. @param {string} key @param {any} control @param {string} value */
  draft(key, control, value) {
    const changed = control.value !== value && control.value !== this.refused.get(key)?.text;
    if (changed) this.drafts.set(key, control.value);
    else this.drafts.delete(key);
    control.classList.toggle('draft', changed);
  }

  /** @param {any} item @param {any} attribute @param {any} control @param {HTMLElement} error */
  async set(item, attribute, control, error) {
    const key = `${item.path} ${attribute.name}`;
    const text = control.value;
    control.dataset.state = 'asked';
    const reply = await this.commands.ask({ do: 'set', path: item.path, attribute: attribute.name, value: text });
    if (control.value === text) this.drafts.delete(key);
    control.classList.remove('draft');
    control.dataset.state = reply.ok ? 'set' : 'refused';
    control.classList.toggle('wrong', !reply.ok);
    error.hidden = reply.ok;
    error.textContent = reply.ok ? '' : reply.message;
    if (reply.ok) {
      this.refused.delete(key);
      this.commands.request({ do: 'components' });
    } else this.refused.set(key, { text, error: reply.message });
    if (!control.isConnected) this.build(); // the panel was built anew while the answer was awaited
  }
}

/** What has to be alike for rows to stay: all but the values. @param {any} item */
function shapeOf({ path, type, attributes = [] }) {
  return JSON.stringify([path, type, attributes.map((/** @type {any} */ a) => [a.name, a.type, a.unit, a.change, a.output, a.long, a.choices, a.range, a.default])]);
}

/** @param {string} [text] of a help */
function sentence(text) {
  if (!text) return '';
  return text.charAt(0).toUpperCase() + text.slice(1) + (/[.!?]$/.test(text) ? '' : '.');
}

/** @param {string} text @param {boolean} cut whether the server cut it already */
function shortened(text, cut) {
  const value = String(text ?? '');
  return value.length > 160 ? `${value.slice(0, 160)}…` : cut ? `${value}…` : value;
}
