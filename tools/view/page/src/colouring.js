// SPDX-License-Identifier: LGPL-2.1-or-later
// What colours the bodies: the field chosen, its values on the surface and inside, and the range of the legend.
import { shared } from './gpu.js';

/** @typedef {{kind: string, surface: Float32Array | null, nodes: Float32Array | null, cells: Float32Array | null}} Coloured */

/** @type {Coloured} */
const PLAIN = { kind: 'colour', surface: null, nodes: null, cells: null };

export class Colouring {
  /** @param {import('./store.js').Store} store */
  constructor(store) {
    this.store = store;
    this.reset();
  }

  reset() {
    /** @type {Map<number, Coloured>} by body */
    this.coloured = new Map();
    /** @type {Map<number, {from: Float32Array, values: Float32Array}>} cells spread over triangles, by field */
    this.spread = new Map();
    this.running = [Infinity, -Infinity];
    /** The largest value of the frame, whatever the range. */
    this.largest = NaN;
    this.last = '';
    this.isOfContact = false;
    this.lastStep = this.lastRun = 0;
  }

  /** @param {any} body @returns {Coloured} */
  of(body) {
    return this.coloured.get(body.index) ?? PLAIN;
  }

  /** Takes over the values of the frame shown. */
  update() {
    const { view } = this.store;
    this.coloured.clear();
    const step = this.store.shown?.header.step ?? 0;
    const run = this.store.shown?.header.run ?? 0;
    const reset = this.store.following && (step < this.lastStep || run !== this.lastRun); // the run began anew
    if (this.last !== view.colour || reset) this.running = [Infinity, -Infinity];
    this.last = view.colour;
    if (this.store.following) {
      this.lastStep = step;
      this.lastRun = run;
    }
    this.largest = NaN;
    this.isOfContact = false;
    if (!view.colour) return;
    const all = [Infinity, -Infinity];
    const range = [Infinity, -Infinity];
    const fields = this.store.chosenFields();
    // Few nodes touch: most values would be zeros.
    this.isOfContact = [...fields.values()].some((field) => field.on === 'nodes' && field.name !== 'velocity');
    for (const body of this.store.bodies) {
      if (!body.visible) continue;
      const coloured = view.colour === 'displacement' ? { ...PLAIN, kind: 'displacement' } : this.fromField(body, fields.get(body.index));
      this.coloured.set(body.index, coloured);
      if (coloured.kind === 'displacement') displacementRange(body, all);
      else if (coloured.surface) extremes(coloured.cells ?? coloured.nodes ?? coloured.surface, all);
      if (view.range === 'fixed') continue;
      if (coloured.kind === 'displacement') displacementRange(body, range);
      else if (coloured.surface) (view.range === 'most' && !this.isOfContact ? bulk : extremes)(view.cut.on && coloured.cells ? coloured.cells : coloured.surface, range);
    }
    this.largest = all[1];
    this.setRange(range);
  }

  /** @param {any} body @param {any} field @returns {Coloured} */
  fromField(body, field) {
    const values = field && this.store.values.get(field.id);
    if (!values) return PLAIN;
    if (field.on === 'nodes') return { kind: 'nodes', surface: values, nodes: values.length === body.count ? values : null, cells: null };
    const triangles = body.triangles.length / 3;
    if (!this.store.valuesOfAll.has(field.id) || body.cells.tetrahedra + body.cells.hexahedra === 0)
      return { kind: 'cells', surface: values, nodes: null, cells: null };
    let spread = this.spread.get(field.id);
    if (spread?.from !== values) {
      const surface = spread?.values.length === triangles ? spread.values.slice() : new Float32Array(triangles);
      for (let t = 0; t < triangles; t++) surface[t] = values[body.owner[t]];
      spread = { from: values, values: surface };
      this.spread.set(field.id, spread);
    }
    return { kind: 'cells', surface: spread.values, nodes: null, cells: values };
  }

  /** @param {number[]} range of the values now */
  setRange(range) {
    const { view } = this.store;
    if (view.range === 'fixed') {
      shared.range.value.set(view.low, view.high);
      return;
    }
    let [low, high] = range;
    if (view.range !== 'automatic') {
      this.running = [Math.min(low, this.running[0]), Math.max(high, this.running[1])];
      [low, high] = this.running;
    }
    if (!(low <= high)) [low, high] = [0, 1];
    if (view.map === 'diverging') {
      high = Math.max(Math.abs(low), Math.abs(high));
      low = -high;
    }
    shared.range.value.set(low, high);
  }
}

/**
 * From the lowest to the highest value but for one in a hundred at either end: a few cells at a corner would leave all others in
 * one colour. Large lists are sampled.
 * @param {Float32Array} values @param {number[]} range
 */
export function bulk(values, range) {
  const stride = Math.max(1, Math.floor(values.length / 4096));
  const sample = new Float32Array(Math.ceil(values.length / stride));
  let count = 0;
  for (let i = 0; i < values.length; i += stride) if (Number.isFinite(values[i])) sample[count++] = values[i];
  if (count === 0) return;
  const sorted = sample.subarray(0, count).sort();
  range[0] = Math.min(range[0], sorted[Math.floor(0.01 * (count - 1))]);
  range[1] = Math.max(range[1], sorted[Math.ceil(0.99 * (count - 1))]);
}

/** @param {Float32Array} values @param {number[]} range */
export function extremes(values, range) {
  let [low, high] = range;
  for (let i = 0; i < values.length; i++) {
    const value = values[i];
    if (value < low) low = value;
    if (value > high) high = value;
  }
  range[0] = low;
  range[1] = high;
}

/** @param {any} body @param {number[]} range */
function displacementRange(body, range) {
  const { x, rest } = body;
  const end = 3 * (body.inside ? body.count : body.surface);
  let most = 0;
  for (let i = 0; i < end; i += 3) {
    const square = (x[i] - rest[i]) ** 2 + (x[i + 1] - rest[i + 1]) ** 2 + (x[i + 2] - rest[i + 2]) ** 2;
    if (square > most) most = square;
  }
  range[0] = Math.min(range[0], 0);
  range[1] = Math.max(range[1], Math.sqrt(most));
}
