// SPDX-License-Identifier: LGPL-2.1-or-later
// The tab "Plots": energies, the solver, watched nodes and hands over time, as curves, as a table and as a file.
import uPlot from 'uplot';
import { checkbox, download, h } from './dom.js';
import { alike, number } from './formats.js';
import { Series } from './series.js';

const INK = ['#3f8fb5', '#d0803a', '#5b9a5b', '#9a6bb5'];
const MOST_NODES = 6; // watched at once
const PAUSE = 100; // [ms] between two drawings

/** @typedef {{key: string, title: string, unit: string, lines: [string, string][], group: string, log?: boolean}} Kind */

/** @type {Kind[]} */
const KINDS = [
  { key: 'energy', title: 'Energy', unit: 'J', group: 'energy', lines: [['energy.kinetic', 'kinetic'], ['energy.elastic', 'force fields'], ['energy.gravity', 'gravity']] },
  { key: 'step', title: 'Time of a step', unit: 'ms', group: 'solver', lines: [['step_ms', 'step']] },
  { key: 'iterations', title: 'Iterations', unit: '', group: 'solver', lines: [['iterations', 'linear'], ['newton', 'Newton']] },
  { key: 'residual', title: 'Residual', unit: '', group: 'solver', log: true, lines: [['residual', 'residual']] },
  { key: 'hands', title: 'Force of hands', unit: 'N', group: '', lines: [] },
];

/** What the values of a node are called. @param {import('./store.js').Store} store @param {{body: number, node: number}} place */
const nameOf = (store, { body, node }) => `node.${body}.${store.bodies[body].sceneNode[node]}`;

export class Plots {
  /** @param {HTMLElement} body @param {any} parts */
  constructor(body, { store, wants, history, commands }) {
    Object.assign(this, { body, store, wants, history, commands });
    this.store = store;
    this.wants = wants;
    this.history = history;
    this.commands = commands;
    this.series = new Series();
    this.chosen = new Set(['hands']);
    this.asTable = false;
    this.begun = false;
    /** @type {Map<string, {plot: any, kind: Kind, element: HTMLElement}>} */
    this.plots = new Map();
    this.choices = h('div', { class: 'checks' });
    this.nodes = h('ul', { class: 'list', 'data-test': 'watched' });
    this.hint = h('p', { class: 'quiet' }, 'Click a body to pick a node; its plot shows position, velocity and reaction.');
    this.charts = h('div', { test: 'charts' });
    this.table = h('div', { class: 'scroll', test: 'table', hidden: true });
    const tableButton = h('button', { test: 'plots-table', type: 'button', 'aria-pressed': 'false', onclick: () => {
      this.asTable = !this.asTable;
      tableButton.setAttribute('aria-pressed', String(this.asTable));
      this.draw();
    } }, 'Table');
    body.append(this.choices, this.nodes, this.hint, h('div', { class: 'buttons' }, tableButton,
      h('button', { test: 'plots-csv', type: 'button', onclick: () => this.save() }, 'Save as CSV'),
      h('button', { test: 'plots-clear', type: 'button', onclick: () => this.clear() }, 'Clear')), this.charts, this.table);
    for (const kind of KINDS) this.choices.append(checkbox(`plot-${kind.key}`, kind.title, this.chosen.has(kind.key), (on) => this.choose(kind.key, on)));
    store.on('arrived', (/** @type {any} */ packet) => this.take(packet));
    store.on('scene', () => {
      if (store.sameScene) return;
      if (store.changed) return this.follow();
      store.watched = [];
      this.clear();
      this.listNodes();
    });
    store.on('theme', () => this.rebuild());
    new ResizeObserver(() => this.resize()).observe(body);
  }

  get mostNodes() {
    return MOST_NODES;
  }

  /** @param {boolean} on */
  opened(on) {
    this.isOpen = on;
    if (on && !this.begun) { // nothing is asked of the server before somebody looks
      this.begun = true;
      if (this.commands.connection) for (const key of ['energy', 'step']) this.choose(key, true);
      for (const kind of KINDS) this.choices.querySelector(`#plot-${kind.key}`).checked = this.chosen.has(kind.key);
    }
    if (on) this.rebuild();
  }

  /** @param {string} key @param {boolean} on */
  choose(key, on) {
    if (on) this.chosen.add(key);
    else this.chosen.delete(key);
    this.wants.groups = new Set(KINDS.filter((kind) => kind.group && this.chosen.has(kind.key)).map((kind) => kind.group));
    this.wants.tell();
    this.rebuild();
  }

  /** Plots a node. @param {number} body @param {number} node number of the page */
  watch(body, node) {
    const { watched } = this.store;
    if (!watched.some((/** @type {any} */ w) => w.body === body && w.node === node)) watched.push({ body, node, name: nameOf(this.store, { body, node }) });
    if (watched.length > MOST_NODES) watched.shift();
    if (!this.commands.connection) this.fromHistory();
    this.store.emit('watched');
    this.listNodes();
    this.rebuild();
  }

  /** A mesh has changed: curves of nodes go on under their numbers now, and those of nodes that are gone end. */
  follow() {
    /** @type {Map<string, string>} */
    const names = new Map();
    const { store } = this;
    store.watched = store.watched.flatMap((/** @type {any} */ old) => {
      const now = store.nodeNow(old);
      if (now) names.set(old.name, (now.name = nameOf(store, now)));
      return now ? [now] : [];
    });
    this.series.rename(names);
    store.emit('watched');
    this.listNodes();
    if (this.isOpen) this.rebuild();
  }

  listNodes() {
    const { watched, bodies } = this.store;
    this.hint.hidden = watched.length > 0;
    this.nodes.replaceChildren(...watched.map((/** @type {any} */ w, /** @type {number} */ i) => h('li', {}, h('span', {}, `${bodies[w.body].name}, node ${bodies[w.body].sceneNode[w.node]}`),
      h('button', { class: 'small', type: 'button', onclick: () => {
        watched.splice(i, 1);
        this.store.emit('watched');
        this.listNodes();
        this.rebuild();
      } }, 'Remove'))));
  }

  /** @param {any} packet */
  take({ header }) {
    const values = { ...header.values };
    for (const hand of header.hands ?? []) values[`hand.${hand.hand}`] = Math.hypot(...hand.force);
    // A frame without hands ends their curves.
    if (!header.hands?.length) for (const name of this.series.columns.keys()) if (name.startsWith('hand.')) values[name] = 0;
    this.series.add(header.time, values, header.run);
    this.later();
  }

  /** An exported page computes the places of watched nodes from its frames. */
  fromHistory() {
    this.series.clear();
    for (const packet of this.history.frames) {
      const values = { ...packet.header.values };
      for (const { body, node } of this.store.watched) {
        const b = this.store.bodies[body];
        const place = placeIn(packet, body, this.store.nodeIn(packet, body, node));
        'xyz'.split('').forEach((axis, c) => (values[`node.${body}.${b.sceneNode[node]}.position.${axis}`] = place[c]));
      }
      for (const hand of packet.header.hands ?? []) values[`hand.${hand.hand}`] = Math.hypot(...hand.force);
      this.series.add(packet.header.time, values, packet.header.run);
    }
  }

  later() {
    if (this.timer || !this.isOpen) return;
    this.timer = setTimeout(() => {
      this.timer = 0;
      this.draw();
    }, PAUSE);
  }

  /** What is plotted now. @returns {Kind[]} */
  kinds() {
    const list = KINDS.filter((kind) => this.chosen.has(kind.key)).map((kind) => ({ ...kind, unit: this.inScene(kind.unit) })).map((kind) => (kind.key !== 'hands' ? kind
      : { ...kind, lines: [...this.series.columns.keys()].filter((name) => name.startsWith('hand.')).slice(-4).map((name) => /** @type {[string, string]} */ ([name, name.slice(5)])) }));
    for (const { body, node } of this.store.watched) {
      const name = `node.${body}.${this.store.bodies[body].sceneNode[node]}`;
      const title = `${this.store.bodies[body].name}, node ${this.store.bodies[body].sceneNode[node]}`;
      for (const [what, unit] of [['position', 'm'], ['velocity', 'm/s'], ['reaction', 'N']])
        if (this.series.columns.has(`${name}.${what}.x`))
          list.push({ key: `${name}.${what}`, title: `${title}: ${what}`, unit: this.store.unit(unit), group: '', lines: 'xyz'.split('').map((axis) => /** @type {[string, string]} */ ([`${name}.${what}.${axis}`, axis])) });
    }
    return list.filter((kind) => kind.lines.length);
  }

  /** Times of the computer stay what they are. @param {string} unit */
  inScene(unit) { return unit === 'ms' ? unit : this.store.unit(unit); }

  rebuild() {
    for (const { plot } of this.plots.values()) plot.destroy();
    this.plots.clear();
    this.charts.replaceChildren();
    this.draw();
  }

  resize() {
    const width = this.body.clientWidth - 26;
    if (width > 50) for (const { plot } of this.plots.values()) plot.setSize({ width, height: 150 });
  }

  draw() {
    if (!this.isOpen) return;
    this.charts.hidden = this.asTable;
    this.table.hidden = !this.asTable;
    if (this.asTable) return this.drawTable();
    const kinds = this.kinds();
    const key = JSON.stringify(kinds);
    if (key !== this.drawnKinds || this.plots.size !== kinds.length) {
      for (const { plot } of this.plots.values()) plot.destroy();
      this.plots.clear();
      this.charts.replaceChildren(...kinds.map((kind) => this.make(kind)));
      this.drawnKinds = key;
    }
    for (const { plot, kind } of this.plots.values()) {
      plot.setData(this.data(kind));
      if (plot.cursor.left < 0) plot.setLegend({ idx: this.series.times.length - 1 }); // the newest, while nobody points
    }
  }

  /** @param {Kind} kind */
  data(kind) {
    return [this.series.times, ...kind.lines.map(([name]) => (kind.log ? this.series.column(name).map((v) => (v !== null && v > 0 ? v : null)) : this.series.column(name)))];
  }

  /** @param {Kind} kind */
  make(kind) {
    const style = getComputedStyle(document.documentElement);
    const axis = { stroke: style.getPropertyValue('--quiet'), grid: { stroke: style.getPropertyValue('--line'), width: 1 }, ticks: { stroke: style.getPropertyValue('--line'), width: 1 }, font: '11px system-ui, sans-serif' };
    const element = h('div', { class: 'plot', 'data-plot': kind.key }, h('div', { class: 'plot-title' }, `${kind.title}${kind.unit ? ` [${kind.unit}]` : ''}`));
    const plot = new uPlot({
      width: Math.max(120, this.body.clientWidth - 26), height: 150, cursor: { drag: { x: true, y: false } }, legend: { show: true },
      scales: { x: { time: false }, y: { distr: kind.log ? 3 : 1 } },
      axes: [{ ...axis, size: 26, values: (_, ticks) => alike(ticks) }, { ...axis, size: 56, values: (_, ticks) => (kind.log ? ticks.map((t) => (t === null ? '' : t.toExponential(0))) : alike(ticks)) }],
      series: [{ label: 't', value: (_, v) => (v === null ? '–' : `${number(v, 4)} ${this.store.unit('s')}`.trim()) },
        ...kind.lines.map(([, label], i) => ({ label, stroke: INK[i % INK.length], width: 1.5, points: { show: false }, spanGaps: true, value: (/** @type {any} */ _, /** @type {number} */ v) => (v === null || v === undefined ? '–' : number(v, 4)) }))],
    }, /** @type {any} */ (this.data(kind)), element);
    this.plots.set(kind.key, { plot, kind, element });
    return element;
  }

  drawTable() {
    const names = this.kinds().flatMap((kind) => kind.lines.map(([name]) => name));
    const from = Math.max(0, this.series.times.length - 200);
    const rows = [];
    for (let i = this.series.times.length - 1; i >= from; i--)
      rows.push(h('tr', {}, h('td', {}, number(this.series.times[i], 5)), ...names.map((name) => {
        const value = this.series.column(name)[i];
        return h('td', {}, value === null ? '' : number(value, 5));
      })));
    const unit = this.store.unit('s');
    this.table.replaceChildren(h('table', { class: 'values' }, h('thead', {}, h('tr', {}, h('th', {}, unit ? `t [${unit}]` : 't'), ...names.map((name) => h('th', {}, name)))), h('tbody', {}, ...rows)));
  }

  clear() {
    this.series.clear();
    this.draw();
  }

  save() {
    download(new Blob([this.series.csv()], { type: 'text/csv' }), `${(this.store.scene?.name ?? 'scene').replace(/\.[^.]*$/, '')}.csv`);
  }
}

/** The place of a node in a frame that is not shown. @param {any} packet @param {number} body @param {number} node */
function placeIn({ header, arrays }, body, node) {
  const x = arrays[`${body}.x`];
  const place = node < 0 ? [] : [...(x?.subarray(3 * node, 3 * node + 3) ?? [])];
  if (place.length < 3) return [NaN, NaN, NaN]; // a node inside that the frame does not have
  const box = x instanceof Uint16Array ? header.boxes[body] : null;
  return box ? place.map((value, c) => box[c] + (value * (box[3 + c] - box[c])) / 65535) : place;
}
