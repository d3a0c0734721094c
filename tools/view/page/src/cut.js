// SPDX-License-Identifier: LGPL-2.1-or-later
// The cut: hides what is in front of a plane and fills the section of the cells, coloured as the surface is.
import { bodyColour, lineColour } from './colours.js';
import { shared } from './gpu.js';
import { HEXAHEDRON_EDGES, TETRAHEDRON_EDGES, cutCells, distances } from './section.js';
import { Growing } from './shapes.js';

export class Cut {
  /** @param {import('./store.js').Store} store */
  constructor(store) {
    this.store = store;
    this.fill = new Growing('triangles', { mode: 2 }, true);
    this.outlines = new Growing('lines', { mode: 0, lift: 0.00003 });
    this.outlines.material.transparent = true;
    this.objects = [this.fill.object, this.outlines.object];
    /** @type {Float32Array[]} */
    this.distances = [];
    /** @type {Float32Array[]} */
    this.drawn = [];
    this.milliseconds = 0;
  }

  /** Whether sections need all nodes. */
  get needsInside() {
    return this.store.view.cut.on && this.store.bodies.some((b) => b.visible && b.cells.tetrahedra + b.cells.hexahedra > 0);
  }

  /** The plane: normal of length 1 towards what is hidden, and offset. @param {any} box of what is drawn */
  plane(box) {
    const { normal, place, flip } = this.store.view.cut;
    const length = Math.hypot(...normal) || 1;
    const n = normal.map((c) => c / length);
    let low = Infinity, high = -Infinity;
    for (let corner = 0; corner < 8; corner++) {
      const p = [corner & 1 ? box.max.x : box.min.x, corner & 2 ? box.max.y : box.min.y, corner & 4 ? box.max.z : box.min.z];
      const d = p[0] * n[0] + p[1] * n[1] + p[2] * n[2];
      low = Math.min(low, d);
      high = Math.max(high, d);
    }
    const offset = low + place * (high - low);
    return flip ? { normal: n.map((c) => -c), offset: -offset } : { normal: n, offset };
  }

  /**
   * Computes the section anew.
   * @param {any} box of what is drawn at the start, so that the plane rests while bodies move
   * @param {(body: any) => {kind: string, nodes: Float32Array | null, cells: Float32Array | null}} colouring
   */
  update(box, colouring) {
    const begin = performance.now();
    const { cut } = this.store.view;
    shared.cut.value = cut.on;
    this.fill.clear();
    this.outlines.clear();
    if (cut.on && !box.isEmpty()) {
      const { normal, offset } = this.plane(box);
      shared.plane.value.set(normal[0], normal[1], normal[2], offset);
      for (const body of this.store.bodies)
        if (body.visible && body.inside && body.tetrahedra) this.cutBody(body, normal, offset, colouring(body));
    }
    // Outlines that would cover the colours fade.
    this.outlines.material.uniforms.colour.value.set(...lineColour(this.store.view.colour));
    this.outlines.material.uniforms.opacity.value = 0.65 * Math.min(1, Math.max(0.12, 24000 / this.outlines.count));
    this.fill.finish();
    this.outlines.finish();
    this.fill.object.visible &&= cut.fill;
    this.outlines.object.visible &&= cut.outlines;
    this.milliseconds = performance.now() - begin;
  }

  /** @param {any} body @param {number[]} normal @param {number} offset @param {any} colouring */
  cutBody(body, normal, offset, colouring) {
    const factor = shared.exaggeration.value;
    let x = body.x;
    if (factor !== 1) {
      x = this.drawn[body.index] ??= new Float32Array(body.x.length);
      for (let i = 0; i < x.length; i++) x[i] = body.rest[i] + factor * (body.x[i] - body.rest[i]);
    }
    let distance = this.distances[body.index];
    if (distance?.length !== body.count) distance = this.distances[body.index] = new Float32Array(body.count);
    distances(x, normal, offset, distance);

    const { kind, nodes, cells } = colouring;
    this.fill.material.uniforms.mode.value = kind === 'colour' ? 2 : 1;
    const tint = bodyColour(body.index).map((c) => 0.35 + 0.65 * c);
    const displacement = (/** @type {number} */ a) =>
      Math.hypot(body.x[3 * a] - body.rest[3 * a], body.x[3 * a + 1] - body.rest[3 * a + 1], body.x[3 * a + 2] - body.rest[3 * a + 2]);
    let first = 0; // number of the first cell of this kind among all
    const valueAt = (/** @type {number} */ a, /** @type {number} */ b, /** @type {number} */ t, /** @type {number} */ cell) => {
      if (kind === 'cells') return cells ? cells[first + cell] : 0;
      if (kind === 'nodes') return nodes ? nodes[a] + t * (nodes[b] - nodes[a]) : 0;
      if (kind === 'displacement') return displacement(a) + t * (displacement(b) - displacement(a));
      return 0;
    };
    const out = {
      corner: (/** @type {number} */ px, /** @type {number} */ py, /** @type {number} */ pz, /** @type {number} */ value) =>
        this.fill.add(px, py, pz, value, tint),
      end: (/** @type {number} */ px, /** @type {number} */ py, /** @type {number} */ pz) => this.outlines.add(px, py, pz),
    };
    cutCells(body.tetrahedra, TETRAHEDRON_EDGES, x, distance, normal, valueAt, out);
    first = body.tetrahedra.length / 4;
    cutCells(body.hexahedra, HEXAHEDRON_EDGES, x, distance, normal, valueAt, out);
  }
}
