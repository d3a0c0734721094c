// SPDX-License-Identifier: LGPL-2.1-or-later
// The tab "Contact": what is drawn of it, and the forces on each body and between each two of them.
import { checkbox, choice, h, row } from './dom.js';
import { number, quantity, scaleFor } from './formats.js';
import { titleOf } from './legend.js';
import { fieldKey } from './store.js';

const FIELDS = ['pressures', 'gaps', 'contactStates', 'contactAreas', 'contactForces', 'frictionForces'];

export class ContactPanel {
  /** @param {HTMLElement} body @param {any} parts */
  constructor(body, { store, wants }) {
    this.body = body;
    this.store = store;
    this.wants = wants;
    this.isOpen = false;
    store.on('scene', () => this.build());
    store.on('view', () => this.update());
    store.on('frame', () => this.isOpen && this.show());
    this.build();
  }

  /** Numbers come while they are looked at. @param {boolean} on */
  opened(on) {
    if (on === this.isOpen) return;
    this.isOpen = on;
    if (on) this.wants.contacts.add('panel');
    else this.wants.contacts.delete('panel');
    this.wants.tell();
    if (on) this.show();
  }

  build() {
    const { store } = this;
    const { view } = store;
    const fields = new Map(store.fields.filter((field) => FIELDS.some((name) => field.name.split(' ')[0] === name)).map((field) => [fieldKey(field), titleOf(field.name)]));
    this.keys = new Set(fields.keys());
    this.field = choice('contact-field', 'Coloured by', [['', 'Nothing of contact'], ...fields], this.keys.has(view.colour) ? view.colour : '', (colour) => store.setView({ colour }));
    this.checks = { contacts: checkbox('show-contacts', 'Forces as arrows', view.contacts, (on) => store.setView({ contacts: on })),
      obstacles: checkbox('show-obstacles', 'Obstacles', view.obstacles, (on) => store.setView({ obstacles: on })) };
    this.checks.obstacles.hidden = store.obstacles.length === 0;
    this.tables = h('div', { 'data-test': 'contact-forces' });
    const none = store.contacts.length === 0;
    this.body.replaceChildren(...(none && store.obstacles.length === 0 ? [h('p', { class: 'quiet' }, 'Nothing in this scene finds contacts.')]
      : [fields.size ? row('By', this.field) : '', h('div', { class: 'checks' }, ...Object.values(this.checks)), this.tables]));
    this.update();
    this.show();
  }

  update() {
    const { view } = this.store;
    this.field.value = this.keys.has(view.colour) ? view.colour : '';
    for (const [key, label] of Object.entries(this.checks)) label.querySelector('input').checked = view[key];
  }

  show() {
    const sums = this.store.shown?.header.contacts ?? [];
    this.tables.replaceChildren(...this.store.contacts.flatMap((contact, k) => [h('h2', {}, contact.name), ...this.of(contact, sums[k])]));
  }

  /** @param {any} contact @param {any} sum */
  of(contact, sum) {
    if (!sum) return [h('p', { class: 'quiet' }, 'No numbers have come yet.')];
    const parts = [];
    const gap = sum.smallestGap;
    if (gap !== undefined) parts.push(h('p', { class: 'number' }, gap > 0 ? `Smallest gap ${quantity(gap, this.store.unit('m'))}` : 'Nothing is in reach.'));
    if (sum.wrenches?.length) parts.push(this.table('On', contact.bodies.map((/** @type {string} */ path) => [short(path)]), sum.wrenches));
    if (sum.pairWrenches?.length) parts.push(this.table('Between', contact.pairs.map((/** @type {string[]} */ pair) => pair.map(short)), sum.pairWrenches));
    return parts;
  }

  /**
   * Forces and moments about the origin.
   * @param {string} title @param {string[][]} names of a pair the first feels the force of the second @param {number[]} wrenches
   */
  table(title, names, wrenches) {
    const at = (/** @type {number} */ i) => wrenches.slice(3 * i, 3 * i + 3);
    const each = names.map((_, i) => ({ force: at(2 * i), moment: at(2 * i + 1) }));
    const force = scaleOf(each.flatMap((one) => one.force), this.store.unit('N'));
    const moment = scaleOf(each.flatMap((one) => one.moment), this.store.unit('N m'));
    const line = (/** @type {string} */ what, /** @type {{factor: number, unit: string, least: number}} */ { factor, unit, least }, /** @type {number[]} */ values) =>
      h('tr', { [`data-${what.toLowerCase()}`]: values.join(' ') }, h('td', {}, unit ? `${what} [${unit}]` : what),
        ...[...values, Math.hypot(...values)].map((value) => h('td', {}, Math.abs(value) < least ? '0' : number(value / factor))));
    return h('div', { class: 'scroll' }, h('table', { class: 'values wrenches' }, h('tr', {}, ...[title, 'x', 'y', 'z', 'size'].map((name) => h('th', {}, name))), ...names.flatMap((name, i) => [
      h('tr', { class: 'of' }, h('td', { colspan: 5 }, name.join(' from '))),
      line('Force', force, each[i].force), line('Moment', moment, each[i].moment),
    ])));
  }
}

/**
 * What suits all of the numbers; what is less than `least` is nothing beside them.
 * @param {number[]} values @param {string} unit "N m" gets the prefix of its first part
 */
export function scaleOf(values, unit) {
  const largest = Math.max(...values.map(Math.abs));
  const [first, ...rest] = unit.split(' ');
  const scale = scaleFor(largest, first);
  return { factor: scale.factor, unit: [scale.unit, ...rest].join(' '), least: 1e-4 * largest };
}

/** The node of a state: "tool" of "/tool/tip/dofs" says less than "tool/tip". @param {string} path */
const short = (path) => path.replace(/^\//, '').replace(/\/[^/]*$/, '') || path.replace(/^\//, '');
