// SPDX-License-Identifier: LGPL-2.1-or-later
// What is drawn of one body: surface, wireframe, points, springs, held and guided nodes, loads, rigid frames, beams and balls.
import * as THREE from 'three';
import { bodyColour, lineColour } from './colours.js';
import { Numbers, material, nodeGeometry, shared, sharedGeometry } from './gpu.js';
import { beamCurve } from './beams.js';
import { Arrows, Balls, Growing, Rods } from './shapes.js';

const MOST_ARROWS = 3000;
const MANY_NODES = 600; // held nodes beyond this are drawn smaller
const MANY_BEAMS = 300; // beyond this each is drawn of fewer pieces
const AXES = [[0.80, 0.25, 0.22], [0.25, 0.60, 0.28], [0.22, 0.40, 0.85]];

export class BodyView {
  /** @param {import('./store.js').Body} body @param {import('./store.js').Store} store */
  constructor(body, store) {
    this.body = body;
    this.store = store;
    this.group = new THREE.Group();
    /** Nodes whose positions are on the graphics card: all, or those of the surface. */
    this.used = body.surface;
    this.positions = new Numbers(this.used, 3);
    this.rest = new Numbers(body.count, 3);
    this.rest.set(body.rest);
    this.positions.set(body.x.subarray(0, 3 * this.used));
    this.nodeValues = new Numbers(1, 1);
    this.cellValues = new Numbers(1, 1);
    /** @type {Float32Array | null} */
    this.uploaded = null;
    const nodes = { positions: this.positions.texture, rest: this.rest.texture };

    const colour = new THREE.Vector3(...bodyColour(body.index));
    this.surface = this.add(THREE.Mesh, body.triangles, material('surface',
      { ...nodes, nodeValues: this.nodeValues.texture, cellValues: this.cellValues.texture, mode: 0, colour },
      { polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 }));
    this.single = this.surface.geometry;
    this.joint = sharedGeometry(body.triangles, body.surface);
    this.surface.geometry = this.joint;
    this.wireframe = this.add(THREE.LineSegments, body.edges, material('line',
      { ...nodes, colour: new THREE.Vector3(), lift: 0.00002 },
      { transparent: true }));
    this.springs = this.add(THREE.LineSegments, body.springs, material('line',
      { ...nodes, colour: new THREE.Vector3(0.45, 0.4, 0.7), lift: 0.00003 }));
    this.points = this.add(THREE.Points, body.points, material('point', { ...nodes, colour, size: 7, shape: 0, lift: 0.0001 }));
    this.held = this.add(THREE.Points, body.held, material('point',
      { ...nodes, colour: new THREE.Vector3(0.97, 0.97, 0.97), size: 7, shape: 1, lift: 0.0002 }));
    this.guided = this.add(THREE.Points, body.guided, material('point',
      { ...nodes, colour: new THREE.Vector3(0.98, 0.8, 0.25), size: 9, shape: 2, lift: 0.0002 }));
    this.loads = new Arrows([0.85, 0.35, 0.12]);
    this.frames = new Growing('lines', { mode: 2, lift: 0.0001 }, true);
    this.beams = new Rods(bodyColour(body.index));
    this.balls = new Balls(bodyColour(body.index), 1, body.balls.length);
    this.group.add(this.loads.object, this.frames.object, this.beams.object, this.balls.object);
    /** The longest load so far: arrows keep one scale. */
    this.longestLoad = 0;
  }

  /** @param {any} Kind @param {Int32Array} nodes @param {THREE.Material} made */
  add(Kind, nodes, made) {
    const object = new Kind(nodeGeometry(nodes), made);
    object.frustumCulled = false;
    this.group.add(object);
    return object;
  }

  setConstraints() {
    for (const [object, nodes] of /** @type {[any, Int32Array][]} */ ([[this.held, this.body.held], [this.guided, this.body.guided]])) {
      object.geometry.dispose();
      object.geometry = nodeGeometry(nodes.filter((n) => n < this.used));
      object.material.uniforms.size.value = (object === this.held ? 7 : 9) * (nodes.length > MANY_NODES ? 0.5 : 1);
    }
  }

  /** Takes over the frame that the store shows. */
  update() {
    const { body } = this;
    const used = body.inside ? body.count : body.surface;
    if (used !== this.used) this.useNodes(used);
    this.positions.set(body.x.subarray(0, 3 * used));
    this.updateLoads();
    this.updateFrames();
    this.updateBalls();
  }

  /** @param {number} used number of nodes whose positions come with each frame from now on */
  useNodes(used) {
    this.used = used;
    this.positions.dispose();
    this.positions = new Numbers(used, 3);
    for (const object of [this.surface, this.wireframe, this.springs, this.points, this.held, this.guided])
      object.material.uniforms.positions.value = this.positions.texture;
    this.setConstraints();
  }

  /**
   * Colours by a field.
   * @param {'colour' | 'displacement' | 'nodes' | 'cells'} kind
   * @param {Float32Array | null} values at the nodes, or one per triangle
   */
  colourBy(kind, values) {
    const { uniforms } = this.surface.material;
    if (values && values !== this.uploaded && (kind === 'nodes' || kind === 'cells')) {
      const nodes = kind === 'nodes';
      let numbers = nodes ? this.nodeValues : this.cellValues;
      if (numbers.data.length < values.length) {
        numbers.dispose();
        numbers = new Numbers(nodes ? this.body.count : values.length, 1);
        if (nodes) this.nodeValues = numbers;
        else this.cellValues = numbers;
        uniforms[nodes ? 'nodeValues' : 'cellValues'].value = numbers.texture;
      }
      numbers.set(values);
      this.uploaded = values;
    }
    uniforms.mode.value = kind === 'displacement' ? 3 : !values || kind === 'colour' ? 0 : kind === 'nodes' ? 1 : 2;
    this.surface.geometry = uniforms.mode.value === 2 ? this.single : this.joint;
  }

  /** Shows and hides by the choices of the store. */
  choose() {
    const { view } = this.store;
    this.group.visible = this.body.visible;
    const bare = this.body.triangles.length === 0;
    this.surface.visible = view.surface && !bare;
    this.wireframe.visible = (view.wireframe || bare || !view.surface) && this.body.edges.length > 0;
    // Alone, lines have the colour of the body: black ones are not seen on dark ground.
    const alone = bare || !view.surface;
    const { colour, opacity } = this.wireframe.material.uniforms;
    colour.value.set(...(alone ? bodyColour(this.body.index) : lineColour(view.colour)));
    opacity.value = alone ? 1 : 0.55;
    this.points.visible = view.points && this.body.points.length > 0;
    this.springs.visible = view.springs && this.body.springs.length > 0;
    this.held.visible = view.held && this.body.held.length > 0;
    this.guided.visible = view.held && this.body.guided.length > 0;
    this.loads.object.visible = view.loads && this.loads.geometry.instanceCount > 0;
    this.frames.object.visible = view.frames && this.frames.count > 0;
    this.beams.object.visible = view.surface && this.body.beams.length > 0;
    this.balls.object.visible = view.surface && this.body.balls.length > 0;
    const { material: made } = this.surface;
    made.uniforms.opacity.value = view.opacity;
    made.transparent = view.opacity < 1;
    made.depthWrite = view.opacity === 1;
  }

  /** @param {number} node @returns {number[]} where the node is drawn */
  drawnAt(node) {
    const { x, rest } = this.body;
    const factor = shared.exaggeration.value;
    return [0, 1, 2].map((c) => rest[3 * node + c] + factor * (x[3 * node + c] - rest[3 * node + c]));
  }

  updateLoads() {
    const { load, size } = this.body;
    const items = [];
    if (load && this.store.view.loads) {
      let longest = 0;
      for (let i = 0; i < load.length; i += 3) longest = Math.max(longest, load[i] ** 2 + load[i + 1] ** 2 + load[i + 2] ** 2);
      longest = Math.sqrt(longest);
      this.longestLoad = Math.max(longest, this.longestLoad);
      for (let n = 0; 3 * n < load.length && items.length < MOST_ARROWS; n++) {
        const force = [load[3 * n], load[3 * n + 1], load[3 * n + 2]];
        const length = Math.hypot(...force);
        if (length < 1e-3 * longest || length === 0) continue;
        const scale = (0.12 * (size || 1)) / this.longestLoad;
        items.push({ at: this.drawnAt(n), radius: 0.0035 * (size || 1), along: force.map((f) => f * scale) });
      }
    }
    this.loads.set(items);
  }

  /** The orientation of a frame; unturned before the first one has come. @param {number} frame */
  turnOf(frame) {
    const { turn } = this.body;
    return turn ? new THREE.Quaternion(...turn.subarray(4 * frame, 4 * frame + 4)) : new THREE.Quaternion();
  }

  /** Where the three axes of a frame end. @param {number} frame @returns {number[][]} */
  axesOf(frame) {
    const at = this.drawnAt(this.body.frames[frame][0]);
    const q = this.turnOf(frame);
    return [0, 1, 2].map((c) => {
      const axis = new THREE.Vector3(+(c === 0), +(c === 1), +(c === 2)).applyQuaternion(q).multiplyScalar(this.body.axis);
      return [at[0] + axis.x, at[1] + axis.y, at[2] + axis.z];
    });
  }

  /** Rigid frames: three axes at the place, turned as the frame says. */
  updateFrames() {
    const { frames, beams } = this.body;
    if (frames.length === 0) return;
    this.frames.clear();
    frames.forEach(([place], i) => {
      const at = this.drawnAt(place);
      this.axesOf(i).forEach((end, c) => {
        this.frames.add(at[0], at[1], at[2], 0, AXES[c]);
        this.frames.add(end[0], end[1], end[2], 0, AXES[c]);
      });
    });
    this.frames.finish();
    const pieces = beams.length > MANY_BEAMS ? 3 : 10;
    this.beams.set(beams.flatMap((beam) => {
      const curve = beamCurve(beam, this.drawnAt(beam[0]), this.drawnAt(beam[1]), this.turnOf(beam[2]).toArray(), this.turnOf(beam[3]).toArray(), pieces);
      return curve.slice(1).map((to, k) => ({ at: curve[k], radius: beam[4], along: to.map((c, i) => c - curve[k][i]) }));
    }));
    this.choose();
  }

  updateBalls() {
    if (this.body.balls.length === 0) return;
    this.balls.set(this.body.balls.map(([node, radius]) => ({ at: this.drawnAt(node), radius })));
    this.choose();
  }

  /** Grows `box` by the places of the nodes that are drawn. @param {THREE.Box3} box */
  extend(box) {
    const point = new THREE.Vector3();
    const used = this.body.surface || this.body.count;
    for (let n = 0; n < used; n++) {
      point.set(...this.drawnAt(n));
      if (Number.isFinite(point.x + point.y + point.z)) box.expandByPoint(point);
    }
    for (let frame = 0; frame < this.body.frames.length; frame++)
      for (const end of this.axesOf(frame)) if (end.every(Number.isFinite)) box.expandByPoint(point.set(end[0], end[1], end[2]));
    for (const [node, radius] of this.body.balls) {
      point.set(...this.drawnAt(node));
      if (Number.isFinite(point.x + point.y + point.z)) box.union(new THREE.Box3().setFromCenterAndSize(point, new THREE.Vector3(2 * radius, 2 * radius, 2 * radius)));
    }
  }

  dispose() {
    for (const numbers of [this.positions, this.rest, this.nodeValues, this.cellValues]) numbers.dispose();
    for (const object of [this.surface, this.wireframe, this.springs, this.points, this.held, this.guided]) {
      object.geometry.dispose();
      object.material.dispose();
    }
    this.single.dispose();
    this.joint.dispose();
    this.loads.dispose();
    this.frames.dispose();
    this.beams.dispose();
    this.balls.dispose();
    this.group.removeFromParent();
  }
}
