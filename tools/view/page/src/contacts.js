// SPDX-License-Identifier: LGPL-2.1-or-later
// What of contact is drawn: obstacles that no body has, and the forces as arrows.
import * as THREE from 'three';
import { material, Numbers, shared, sharedGeometry } from './gpu.js';
import { hitTriangle } from './picking.js';
import { Arrows } from './shapes.js';

const COLOUR = new THREE.Vector3(0.62, 0.64, 0.67);
const PLANE_OPACITY = 0.16;
const MOST_ARROWS = 3000;

/** The obstacles of one component, which move together. */
class ObstacleView {
  /** @param {any} obstacle */
  constructor(obstacle) {
    this.obstacle = obstacle;
    this.group = new THREE.Group();
    this.positions = new Numbers(obstacle.points.length / 3, 3);
    this.values = new Numbers(1, 1);
    const { solid, triangles } = obstacle;
    this.parts = [[triangles.subarray(0, 3 * solid), 1], [triangles.subarray(3 * solid), PLANE_OPACITY]].filter(([part]) => part.length > 0)
      .map(([part, opacity]) => {
        const look = material('surface', { positions: this.positions.texture, rest: this.positions.texture, nodeValues: this.values.texture, cellValues: this.values.texture,
          mode: 0, colour: COLOUR, opacity }, { transparent: opacity < 1, depthWrite: opacity === 1 });
        const mesh = new THREE.Mesh(sharedGeometry(part, obstacle.points.length / 3), look);
        mesh.frustumCulled = false;
        this.group.add(mesh);
        return mesh;
      });
    this.place([0, 0, 0]);
  }

  /** @param {number[]} moved */
  place(moved) {
    this.moved = moved;
    this.positions.set(this.obstacle.points.map((/** @type {number} */ c, /** @type {number} */ i) => c + moved[i % 3]));
  }

  /** Grows `box` by what is no plane. @param {THREE.Box3} box */
  extend(box) {
    const { points, triangles, solid } = this.obstacle;
    for (const n of triangles.subarray(0, 3 * solid))
      box.expandByPoint(new THREE.Vector3(points[3 * n] + this.moved[0], points[3 * n + 1] + this.moved[1], points[3 * n + 2] + this.moved[2]));
  }

  /** Distance along a ray to what is no plane, or infinity. @param {number[]} o @param {number[]} d */
  hit(o, d) {
    const { points, triangles, solid } = this.obstacle;
    const from = o.map((c, i) => c - this.moved[i]);
    const p = new Float64Array(9);
    let distance = Infinity;
    for (let t = 0; t < 3 * solid; t += 3) {
      for (let corner = 0; corner < 3; corner++) for (let c = 0; c < 3; c++) p[3 * corner + c] = points[3 * triangles[t + corner] + c];
      const at = hitTriangle(p, from, d);
      if (at > 0 && at < distance) distance = at;
    }
    return distance;
  }

  dispose() {
    this.positions.dispose();
    this.values.dispose();
    for (const { geometry, material: look } of this.parts) {
      geometry.dispose();
      /** @type {any} */ (look).dispose();
    }
    this.group.removeFromParent();
  }
}

export class Contacts {
  /** @param {import('./store.js').Store} store @param {THREE.Scene} world */
  constructor(store, world) {
    this.store = store;
    this.world = world;
    /** @type {ObstacleView[]} */
    this.obstacles = [];
    this.arrows = new Arrows([0.78, 0.16, 0.35]);
    world.add(this.arrows.object);
    this.longest = 0;
  }

  build() {
    for (const view of this.obstacles) view.dispose();
    this.obstacles = this.store.obstacles.map((obstacle) => new ObstacleView(obstacle));
    for (const { group } of this.obstacles) this.world.add(group);
    if (!this.store.continued) this.longest = 0;
  }

  /** Takes over the frame shown. @param {import('./body.js').BodyView[]} views */
  update(views) {
    const { shown, view } = this.store;
    this.obstacles.forEach((obstacle, k) => {
      const moved = shown?.header.moved?.[k];
      if (moved && moved.some((/** @type {number} */ c, /** @type {number} */ i) => c !== obstacle.moved[i])) obstacle.place(moved);
      obstacle.group.visible = view.obstacles;
    });
    this.arrows.set(view.contacts ? this.items(views) : []);
  }

  /** @param {import('./body.js').BodyView[]} views */
  items(views) {
    const arrays = this.store.shown?.arrays ?? {};
    const forces = this.store.contacts.map((_, k) => arrays[`c${k}.forces`] ?? new Float32Array(0));
    for (const list of forces)
      for (let i = 0; i < list.length; i += 3) this.longest = Math.max(this.longest, Math.hypot(list[i], list[i + 1], list[i + 2]));
    const size = Math.max(...views.map(({ body }) => body.size || 0), 0) || 1;
    /** @type {{at: number[], radius: number, along: number[]}[]} */
    const items = [];
    this.store.contacts.forEach((contact, k) => {
      const pages = arrays[`c${k}.pages`] ?? [];
      for (let i = 0; 3 * i < forces[k].length && items.length < MOST_ARROWS; i++) {
        const along = [...forces[k].subarray(3 * i, 3 * i + 3)].map((f) => (0.2 * size * f) / this.longest);
        if (!(Math.hypot(...along) > 1e-3 * size)) continue;
        const tip = pages.length > 0 && shared.exaggeration.value !== 1 ? views[contact.body].drawnAt(pages[i]) : [...arrays[`c${k}.places`].subarray(3 * i, 3 * i + 3)];
        // a push ends where it acts, and is seen outside of the body
        items.push({ at: tip.map((c, j) => c - along[j]), radius: 0.0022 * size, along });
      }
    });
    return items;
  }

  /** The obstacle that a ray meets first. @param {THREE.Ray} ray @returns {{obstacle: number, distance: number} | null} */
  hit(ray) {
    let best = null;
    this.obstacles.forEach((view, k) => {
      const distance = view.group.visible ? view.hit(ray.origin.toArray(), ray.direction.toArray()) : Infinity;
      if (distance < (best?.distance ?? Infinity)) best = { obstacle: k, distance };
    });
    return best;
  }
}
