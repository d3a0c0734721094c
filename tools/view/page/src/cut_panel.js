// SPDX-License-Identifier: LGPL-2.1-or-later
// The tab "Cut": the plane that lets one see inside.
import { checkbox, h, numberField, row } from './dom.js';
import { cutText } from './hint.js';

const AXES = { x: [1, 0, 0], y: [0, 1, 0], z: [0, 0, 1] };

export class CutPanel {
  /** @param {HTMLElement} body @param {any} parts */
  constructor(body, { store, stage }) {
    this.store = store;
    this.stage = stage;
    const { cut } = store.view;
    this.on = checkbox('cut', 'Cut by a plane (C)', cut.on, (on) => store.setCut({ on }));
    this.axes = Object.entries(AXES).map(([name, normal]) =>
      h('button', { test: `cut-${name}`, type: 'button', onclick: () => store.setCut({ normal, on: true }) }, name));
    const view = h('button', { test: 'cut-view', type: 'button', title: 'The plane of the screen', onclick: () => {
      const direction = stage.camera.position.clone().sub(stage.controls.target).normalize();
      store.setCut({ normal: direction.toArray(), on: true });
    } }, 'Screen');
    this.place = h('input', { test: 'cut-place', type: 'range', min: 0, max: 1, step: 0.002, value: cut.place, 'aria-label': 'Place of the plane',
      oninput: () => store.setCut({ place: Number(this.place.value), on: true }) });
    this.normal = [0, 1, 2].map((c) => numberField(`cut-normal-${'xyz'[c]}`, `Normal, ${'xyz'[c]}`, '0', (value) => {
      const normal = this.normal.map((field) => Number(field.value.replace(',', '.')));
      if (Number.isFinite(value) && Math.hypot(...normal) > 0) store.setCut({ normal });
      this.update();
    }, { size: 5 }));
    this.flip = checkbox('cut-flip', 'Other side', cut.flip, (flip) => store.setCut({ flip }));
    this.outlines = checkbox('cut-outlines', 'Outlines of cells', cut.outlines, (outlines) => store.setCut({ outlines }));
    this.fill = checkbox('cut-fill', 'Filled', cut.fill, (fill) => store.setCut({ fill }));
    this.note = h('p', { class: 'quiet' });
    body.append(this.on, row('Across', h('span', { class: 'segments wide' }, ...this.axes, view)), row('Place', this.place, this.at = h('span', { class: 'unit number', 'data-test': 'cut-at' })), row('Normal', ...this.normal),
      h('div', { class: 'checks' }, this.flip, this.outlines, this.fill), this.note);
    store.on('view', () => this.update());
    store.on('scene', () => this.update());
    this.update();
  }

  update() {
    const { cut } = this.store.view;
    const set = (/** @type {any} */ label, /** @type {boolean} */ on) => (label.querySelector('input').checked = on);
    set(this.on, cut.on);
    set(this.flip, cut.flip);
    set(this.outlines, cut.outlines);
    set(this.fill, cut.fill);
    Object.values(AXES).forEach((axis, i) => this.axes[i].setAttribute('aria-pressed', String(cut.on && axis.every((c, k) => Math.abs(c - cut.normal[k]) < 1e-9))));
    this.place.value = String(cut.place);
    this.at.textContent = this.store.scene && !this.stage.restBox.isEmpty() ? cutText(this.store, this.stage) : '';
    this.normal.forEach((field, c) => (field.value = String(Math.round(1000 * cut.normal[c]) / 1000)));
    const cells = this.store.bodies.reduce((sum, b) => sum + b.cells.tetrahedra + b.cells.hexahedra, 0);
    this.note.textContent = this.store.scene && cells === 0 ? 'No body of this scene has tetrahedra or hexahedra: surfaces are cut, without a section.' : '';
  }
}
