// SPDX-License-Identifier: LGPL-2.1-or-later
// Shapes that the page computes: lists of triangles and lines that grow, and arrows and balls.
import * as THREE from 'three';
import { material } from './gpu.js';

const MANY_BALLS = 300;

/** Triangles or lines with a value or a tint at each corner, rewritten as a whole when they change. */
export class Growing {
  /** @param {'triangles' | 'lines'} kind @param {Record<string, any>} uniforms @param {boolean} tinted */
  constructor(kind, uniforms, tinted = false) {
    this.geometry = new THREE.BufferGeometry();
    this.material = material('plain', { colour: new THREE.Vector3(0, 0, 0), mode: 0, ...uniforms });
    const Kind = kind === 'lines' ? THREE.LineSegments : THREE.Mesh;
    this.object = new Kind(this.geometry, this.material);
    this.object.frustumCulled = false;
    this.tinted = tinted;
    this.reserve(256);
    this.clear();
  }

  /** @param {number} count */
  reserve(count) {
    const old = this.position;
    const oldValue = this.value;
    const oldTint = this.tint;
    this.position = new Float32Array(3 * count);
    this.value = new Float32Array(count);
    this.tint = this.tinted ? new Float32Array(3 * count) : new Float32Array(0);
    if (old) this.position.set(old);
    if (oldValue) this.value.set(oldValue);
    if (oldTint) this.tint.set(oldTint);
    this.capacity = count;
    this.geometry.dispose();
    const attributes = { position: [this.position, 3], value: [this.value, 1], ...(this.tinted ? { tint: [this.tint, 3] } : {}) };
    for (const [name, [array, size]] of Object.entries(attributes))
      this.geometry.setAttribute(name,
        new THREE.BufferAttribute(/** @type {any} */ (array), /** @type {number} */ (size)).setUsage(THREE.DynamicDrawUsage));
  }

  clear() {
    this.count = 0;
  }

  /** @param {number} x @param {number} y @param {number} z @param {number} [value] @param {number[]} [tint] */
  add(x, y, z, value = 0, tint) {
    if (this.count === this.capacity) this.reserve(2 * this.capacity);
    const i = this.count++;
    this.position[3 * i] = x;
    this.position[3 * i + 1] = y;
    this.position[3 * i + 2] = z;
    this.value[i] = value;
    if (tint) this.tint.set(tint, 3 * i);
  }

  finish() {
    this.geometry.setDrawRange(0, this.count);
    this.object.visible = this.count > 0;
    for (const [name, attribute] of Object.entries(this.geometry.attributes)) {
      const buffer = /** @type {THREE.BufferAttribute} */ (attribute);
      buffer.clearUpdateRanges();
      buffer.addUpdateRange(0, this.count * (name === 'value' ? 1 : 3));
      buffer.needsUpdate = true;
    }
  }

  dispose() {
    this.geometry.dispose();
    this.material.dispose();
  }
}

/** The unit arrow: shaft from 0 to 1, head from 1 to 2; the shader stretches both. */
function arrowShape() {
  const shape = [new THREE.Vector2(0, 0), new THREE.Vector2(1, 0), new THREE.Vector2(1, 1), new THREE.Vector2(2.6, 1),
    new THREE.Vector2(0, 2)];
  return new THREE.LatheGeometry(shape, 10);
}

/** The unit rod: from 0 to 1. */
function rodShape() {
  return new THREE.LatheGeometry([new THREE.Vector2(0, 0), new THREE.Vector2(1, 0), new THREE.Vector2(1, 1), new THREE.Vector2(0, 1)], 12);
}

/** Arrows, rods or balls: many drawings of one shape. */
class Solids {
  /** @param {THREE.BufferGeometry} shape @param {number[]} colour @param {number} opacity @param {number} arrow 1; 2 for rods, 0 for balls */
  constructor(shape, colour, opacity, arrow) {
    this.arrow = arrow;
    this.geometry = new THREE.InstancedBufferGeometry();
    this.geometry.index = shape.index;
    this.geometry.setAttribute('position', shape.attributes.position);
    this.geometry.setAttribute('normal', shape.attributes.normal);
    this.material = material('solid', { colour: new THREE.Vector3(...colour), opacity },
      { transparent: opacity < 1, depthWrite: opacity === 1, side: arrow ? THREE.DoubleSide : THREE.FrontSide });
    this.object = new THREE.Mesh(this.geometry, this.material);
    this.object.frustumCulled = false;
    this.capacity = 0;
    this.set([]);
  }

  /** @param {{at: number[], radius: number, along?: number[]}[]} items */
  set(items) {
    if (items.length > this.capacity || this.capacity === 0) {
      this.capacity = Math.max(8, 2 * items.length);
      this.geometry.dispose();
      this.origin = new THREE.InstancedBufferAttribute(new Float32Array(4 * this.capacity), 4);
      this.along = new THREE.InstancedBufferAttribute(new Float32Array(4 * this.capacity), 4);
      this.geometry.setAttribute('origin', this.origin);
      this.geometry.setAttribute('along', this.along);
    }
    items.forEach((item, i) => {
      this.origin.array.set([...item.at, item.radius], 4 * i);
      this.along.array.set([...(item.along ?? [0, 0, 0]), this.arrow], 4 * i);
    });
    this.origin.needsUpdate = this.along.needsUpdate = true;
    this.geometry.instanceCount = items.length;
    this.object.visible = items.length > 0;
  }

  dispose() {
    this.geometry.dispose();
    this.material.dispose();
  }
}

export class Arrows extends Solids {
  /** @param {number[]} colour */
  constructor(colour) {
    super(arrowShape(), colour, 1, 1);
  }
}

export class Balls extends Solids {
  /** @param {number[]} colour @param {number} opacity @param {number} [count] many are drawn of fewer faces */
  constructor(colour, opacity, count = 1) {
    super(count > MANY_BALLS ? new THREE.SphereGeometry(1, 12, 8) : new THREE.SphereGeometry(1, 32, 20), colour, opacity, 0);
  }
}

export class Rods extends Solids {
  /** @param {number[]} colour */
  constructor(colour) {
    super(rodShape(), colour, 1, 2);
  }
}
