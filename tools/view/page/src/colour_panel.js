// SPDX-License-Identifier: LGPL-2.1-or-later
// The tab "Colour": the field and its range, and what is drawn.
import { MAPS } from './colours.js';
import { checkbox, choice, h, numberField, row } from './dom.js';
import { fieldKey } from './store.js';
import { number } from './formats.js';
import { shared } from './gpu.js';
import { titleOf } from './legend.js';

export class ColourPanel {
  /** @param {HTMLElement} body @param {any} parts */
  constructor(body, { store, stage }) {
    this.body = body;
    this.store = store;
    this.stage = stage;
    store.on('scene', () => this.build());
    store.on('view', () => this.update());
    this.build();
  }

  build() {
    const { store } = this;
    const { view } = store;
    const keys = new Map([['', 'Body'], ['displacement', 'Displacement']]);
    for (const field of store.fields) keys.set(fieldKey(field), titleOf(field.name) + (field.on === 'cells' ? ' (cells)' : ''));
    if (!keys.has(view.colour)) view.colour = '';
    this.field = choice('field', 'Coloured by', /** @type {any} */ ([...keys]), view.colour, (colour) => store.setView({ colour }));
    this.map = choice('map', 'Colour map', Object.entries(MAPS).map(([name, { title }]) => [name, title]), view.map, (map) => store.setView({ map }));
    this.range = choice('range', 'Range', [['most', '98 % of the values'], ['running', 'All values of the run'], ['automatic', 'All values of the frame'], ['fixed', 'Fixed']], view.range, (range) => {
      const { x: low, y: high } = shared.range.value; // a fixed range starts with what is seen
      store.setView(range === 'fixed' ? { range, low, high } : { range });
    });
    this.low = numberField('range-low', 'Lowest value', '', (value) => Number.isFinite(value) && store.setView({ low: value }));
    this.high = numberField('range-high', 'Highest value', '', (value) => Number.isFinite(value) && store.setView({ high: value }));
    this.limits = row('From, to', this.low, this.high, this.unit = h('span', { class: 'unit' }));
    this.factor = h('input', { test: 'exaggeration', type: 'range', min: 0, max: 4, step: 0.05, value: 0, 'aria-label': 'Exaggeration of the deformation',
      oninput: () => store.setView({ exaggeration: Math.round(100 * (2 ** (Number(this.factor.value) * 1.6610)) ) / 100 }) });
    this.factorText = numberField('exaggeration-factor', 'Factor of exaggeration', '1', (value) => value >= 0 && store.setView({ exaggeration: value }), { size: 4 });
    this.opacity = h('input', { test: 'opacity', type: 'range', min: 0.1, max: 1, step: 0.05, value: view.opacity, 'aria-label': 'Opacity of surfaces',
      oninput: () => store.setView({ opacity: Number(this.opacity.value) }) });
    const check = (/** @type {string} */ key, /** @type {string} */ label) => checkbox(`show-${key}`, label, view[key], (on) => store.setView({ [key]: on }));
    this.checks = { surface: check('surface', 'Surfaces'), wireframe: check('wireframe', 'Wireframe'), points: check('points', 'Points'), springs: check('springs', 'Springs'),
      held: check('held', 'Held nodes'), loads: check('loads', 'Loads'), frames: check('frames', 'Rigid frames'), legend: check('legend', 'Legend') };
    this.body.replaceChildren(h('h2', {}, 'Colour'), row('By', this.field), this.mapRow = row('Colours', this.map), this.rangeRow = row('Range', this.range), this.limits,
      h('h2', {}, 'Shape'), row('Exaggerated', this.factor, this.factorText, h('span', { class: 'unit' }, '×')), row('Opacity', this.opacity),
      h('h2', {}, 'Drawn'), h('div', { class: 'checks' }, ...Object.values(this.checks)),
      h('h2', {}, 'Transfer'), checkbox('remote', '16-bit positions, for slow links', view.remote, (remote) => store.setView({ remote })));
    this.update();
  }

  update() {
    const { view } = this.store;
    this.field.value = view.colour;
    this.map.value = view.map;
    this.range.value = view.range;
    this.mapRow.hidden = this.rangeRow.hidden = !view.colour;
    this.limits.hidden = !view.colour || view.range !== 'fixed';
    this.low.value = number(view.low, 4).replace('−', '-');
    this.high.value = number(view.high, 4).replace('−', '-');
    this.unit.textContent = this.store.colourUnit;
    this.factorText.value = String(view.exaggeration);
    this.factor.value = String(view.exaggeration > 0 ? Math.log2(view.exaggeration) / 1.6610 : 0);
    this.opacity.value = String(view.opacity);
    for (const [key, label] of Object.entries(this.checks)) label.querySelector('input').checked = view[key];
  }
}
