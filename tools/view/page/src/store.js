// SPDX-License-Identifier: LGPL-2.1-or-later
// What the page knows: the scene, the frame shown, the state of the run, and the choices of the person who looks.
// Everything else listens to its events: connection, scene, held, cells, arrived, frame, status, messages, components,
// explain, xml, actions, hash, view, selection; dropped, with the number of a frame that belongs to no scene known here.
import { dequantise } from './messages.js';

const MOST_MESSAGES = 2000;

/**
 * @typedef {object} Body
 * @property {number} index
 * @property {string} path
 * @property {string} node path of the scene's node
 * @property {string} name
 * @property {number} count number of nodes
 * @property {number} surface number of nodes that the surface uses; they come first
 * @property {{tetrahedra: number, hexahedra: number}} cells
 * @property {boolean} interactive
 * @property {string} why
 * @property {number} [carrier] the body that carries this one, which a hand can take; -1: none
 * @property {number[][]} frames rigid frames: the first number is the node of the place
 * @property {number[][]} beams round beams: nodes and frames of both ends, radius, chord at rest in the axes of both ends
 * @property {number[][]} balls nodes at their centres, radius
 * @property {number} axis length of the axes of frames [m]
 * @property {number} size diagonal of the rest box [m]
 * @property {Int32Array} sceneNode number in the scene of each node
 * @property {Float32Array} rest
 * @property {Int32Array} triangles
 * @property {Int32Array} owner
 * @property {Int32Array} edges
 * @property {Int32Array} points
 * @property {Int32Array} springs
 * @property {Int32Array} held
 * @property {Int32Array} guided
 * @property {Int32Array | null} tetrahedra known once all nodes were wanted
 * @property {Int32Array | null} hexahedra
 * @property {Float32Array} x positions shown, 3 count
 * @property {boolean} inside whether the positions of inner nodes belong to the frame shown
 * @property {Float32Array | null} load
 * @property {Float32Array | null} turn unit quaternions (x, y, z, w) of the rigid frames
 * @property {boolean} visible
 */

export class Store {
  constructor() {
    /** @type {Map<string, ((data?: any) => void)[]>} */
    this.listeners = new Map();
    this.connection = { state: 'connecting', sentence: '' };
    this.build = '';
    /** @type {any} */
    this.scene = null;
    /** @type {Body[]} */
    this.bodies = [];
    /** @type {any[]} */
    this.fields = [];
    /** Obstacles of components, with their triangles. @type {any[]} */
    this.obstacles = [];
    /** Components that compute forces of contact. @type {any[]} */
    this.contacts = [];
    /** @type {Map<number, Float32Array>} newest values of each field as they came */
    this.values = new Map();
    /** Fields whose newest values came with all nodes: one value per cell, not per triangle. */
    this.valuesOfAll = new Set();
    /** @type {any} the packet shown */
    this.shown = null;
    /** @type {any} the newest packet */
    this.newest = null;
    /** The newest packet with each array that does not come with every frame: fields and loads. @type {Map<string, any>} */
    this.newestWith = new Map();
    /** Arrays of the nodes held: as the server told them last, and as they are shown. @type {any} */
    this.heldNow = this.heldShown = null;
    this.following = true;
    /** Whether this page holds its recording itself. */
    this.exported = false;
    this.ready = false;
    /** @type {string[]} */
    this.pathsBefore = [];
    /** @type {Map<number, number>[]} */
    this.nodesNow = [];
    /** @type {any} */
    this.status = { running: false, pace: 'real', factor: 1, time: 0, step: 0, doubts: [], ended: '', control: null };
    /** @type {{severity: string, text: string}[]} */
    this.messages = [];
    /** @type {any} */
    this.components = null;
    /** @type {{body: number, node: number}[]} nodes whose values are plotted; numbers of the page */
    this.watched = [];
    /** The node picked last. @type {{body: number, node: number} | null} */
    this.picked = null;
    this.selected = '';
    this.view = {
      colour: '', map: 'viridis', range: 'most', low: 0, high: 1, exaggeration: 1, legend: true,
      surface: true, wireframe: false, points: true, springs: true, held: true, loads: false, contacts: false, obstacles: true, frames: true, opacity: 1,
      cut: { on: false, normal: [1, 0, 0], place: 0.5, flip: false, outlines: true, fill: true },
      theme: 'auto', remote: false,
    };
  }

  /** @param {string} event @param {(data?: any) => void} listener */
  on(event, listener) {
    const list = this.listeners.get(event) ?? [];
    list.push(listener);
    this.listeners.set(event, list);
  }

  /** @param {string} event @param {any} [data] */
  emit(event, data) {
    for (const listener of this.listeners.get(event) ?? []) listener(data);
  }

  /** @param {string} state @param {string} sentence */
  setConnection(state, sentence) {
    this.connection = { state, sentence };
    this.emit('connection');
  }

  /** A new connection: the server sends everything again. */
  restart() {
    this.ready = false;
    this.isNewConnection = true;
    this.values.clear();
    this.newestWith.clear();
  }

  /** @param {Partial<Store['view']>} change */
  setView(change) {
    Object.assign(this.view, change);
    this.emit('view', change);
  }

  /** @param {Partial<Store['view']['cut']>} change */
  setCut(change) {
    this.setView({ cut: { ...this.view.cut, ...change } });
  }

  /** @param {string} path of a node or component of the scene */
  select(path) {
    this.selected = path;
    this.emit('selection', path);
  }

  /** @param {string} severity @param {string} text */
  say(severity, text) {
    this.receiveText({ is: 'messages', lines: [{ severity, text }] });
  }

  /** Says something at once where the person looks, and in the log. @param {string} text @param {string} [severity] */
  notify(text, severity = 'error') {
    this.say(severity, text);
    this.emit('notice', text);
  }

  /** @param {any} message */
  receiveText(message) {
    switch (message.is) {
      case 'ready':
        this.ready = true;
        break;
      case 'status':
        // The instants of a recording come only once.
        if (message.recording && !message.recording.times) message.recording.times = this.status.recording?.times;
        this.status = { ...message, doubts: message.doubts ?? this.status.doubts };
        break;
      case 'messages':
        this.messages.push(...message.lines);
        if (this.messages.length > MOST_MESSAGES) this.messages.splice(0, this.messages.length - MOST_MESSAGES);
        break;
      case 'components':
        this.components = message.tree;
        break;
    }
    this.emit(message.is, message);
  }

  /** @param {import('./messages.js').Packet} packet */
  receivePacket(packet) {
    const { is, generation } = packet.header;
    if (is === 'scene') {
      // A mesh has changed, and this page was told of it already with its own scene.
      if (packet.header.follows !== undefined && generation === this.scene?.generation && !this.isNewConnection) return;
      this.sceneComing = { packet, cells: null, first: this.firstNumbers(packet) };
      this.takeScene(packet);
      this.sceneShown = this.sceneComing;
      return;
    }
    if (!this.scene || (generation !== undefined && generation !== this.scene.generation)) {
      if (is === 'frame') this.emit('dropped', packet.header.frame);
      return;
    }
    if (is === 'held') return this.takeHeld(packet);
    if (is === 'cells') {
      this.sceneComing.cells = packet;
      return this.takeCells(packet);
    }
    if (is !== 'frame') return;
    this.newest = packet;
    if (this.exported) packet.scene = this.sceneComing;
    packet.held = this.heldNow;
    for (const name of Object.keys(packet.arrays)) if (/^f\d+$|\.load$/.test(name)) this.newestWith.set(name, packet);
    this.emit('arrived', packet);
    if (this.following) this.show(packet);
  }

  /** @param {import('./messages.js').Packet} packet */
  takeScene({ header, arrays }) {
    const hidden = new Set(this.bodies.filter((body) => !body.visible).map((body) => body.path));
    const kind = JSON.stringify([header.name, header.mode, header.bodies.map((/** @type {any} */ b) => [b.path, b.nodes, b.surface]),
      (header.fields ?? []).map((/** @type {any} */ f) => [f.id, f.body, f.name, f.on, f.unit])]);
    const before = this.bodies;
    /** Whether it is the scene from before, as after a lost connection: what was kept stays good. */
    this.sameScene = kind === this.kindOfScene && before.every((body, b) => sameNumbers(body.sceneNode, arrays[`${b}.node`]));
    /** Whether it is sent again within a connection, as after a change of springs: even hands go on. */
    this.continued = this.sameScene && !this.isNewConnection;
    /** Whether meshes of it have changed: nodes have other numbers, which nodeNow() knows, and everything else goes on. */
    this.changed = !this.continued && !this.isNewConnection && (this.isReturning || (header.follows !== undefined && header.follows === this.scene?.generation));
    const known = this.changed ? new Map(before.map((body) => [body.path, body])) : new Map();
    this.pathsBefore = before.map((body) => body.path);
    this.isNewConnection = false;
    this.kindOfScene = kind;
    // What is sent to all pages at once names none of them.
    this.scene = (this.continued || this.changed) && header.client === undefined ? { ...header, client: this.scene.client } : header;
    this.build ||= header.build;
    this.bodies = header.bodies.map((/** @type {any} */ info, /** @type {number} */ b) => {
      const count = info.nodes ?? arrays[`${b}.rest`].length / 3;
      const ints = (/** @type {string} */ name) => arrays[`${b}.${name}`] ?? new Int32Array(0);
      return {
        ...info, index: b, count, frames: info.frames ?? [], beams: info.beams ?? [], balls: info.balls ?? [], axis: info.axis ?? 0.12 * (info.size || 1), cells: info.cells ?? { tetrahedra: 0, hexahedra: 0 },
        sceneNode: ints('node'), rest: arrays[`${b}.rest`], triangles: ints('triangles'), owner: ints('owner'),
        edges: ints('edges'), points: ints('points'), springs: ints('springs'), held: new Int32Array(0),
        guided: new Int32Array(0), tetrahedra: null, hexahedra: null, x: arrays[`${b}.rest`].slice(), inside: false,
        load: null, turn: null, visible: !hidden.has(info.path), ...(this.continued ? stateOf(before[b]) : {}),
      };
    });
    if (this.changed) this.takePlaces(known, arrays);
    this.links = arrays.links ?? new Int32Array(0);
    this.linkKinds = arrays.link_kind ?? new Uint8Array(0);
    this.fields = header.fields ?? [];
    this.obstacles = (header.obstacles ?? []).map((/** @type {any} */ info, /** @type {number} */ k) => ({ ...info, points: arrays[`o${k}.points`], triangles: arrays[`o${k}.triangles`] }));
    this.contacts = header.contacts ?? [];
    if (!this.continued) {
      this.values.clear();
      this.newestWith.clear();
      this.shown = this.newest = this.heldNow = this.heldShown = null;
      this.following = true;
    }
    this.emit('scene');
  }

  /** Nodes stay where they are until the next frame. @param {Map<string, Body>} known by path @param {any} arrays */
  takePlaces(known, arrays) {
    /** @type {Map<number, number>[]} of each body now, its nodes by their numbers before */
    this.nodesNow = this.bodies.map((body, b) => {
      const from = this.isReturning ? this.numbersIn(this.sceneShown, this.sceneGoal, b) : arrays[`${b}.before`] ?? new Int32Array(0);
      const old = known.get(body.path);
      for (let n = 0; old && n < from.length; n++)
        if (from[n] >= 0) body.x.set(old.x.subarray(3 * from[n], 3 * from[n] + 3), 3 * n);
      if (old) body.inside = old.inside;
      return new Map([...from].map((node, n) => [node, n]));
    });
  }

  /** A page that holds its recording goes back to the meshes of a frame, or on to them. @param {any} scene of the frame */
  returnTo(scene) {
    const { following, newest } = this;
    this.isReturning = true;
    this.sceneGoal = scene;
    this.takeScene(scene.packet);
    this.isReturning = false;
    this.following = following;
    this.newest = newest;
    this.sceneShown = scene;
    if (scene.cells) this.takeCells(scene.cells);
  }

  /** Of each body, a number of each node that it has in all scenes: the one that it came with. @param {import('./messages.js').Packet} packet @returns {number[][]} */
  firstNumbers({ header, arrays }) {
    const known = header.follows !== undefined && header.follows === this.sceneComing?.packet.header.generation ? this.sceneComing.first : [];
    return (header.bodies ?? []).map((/** @type {any} */ _, /** @type {number} */ b) => {
      const from = arrays[`${b}.before`] ?? arrays[`${b}.node`] ?? new Int32Array(0);
      return Array.from(from, (node) => (known[b] && arrays[`${b}.before`] && node >= 0 && node < known[b].length ? known[b][node] : (this.nextNumber = (this.nextNumber ?? 0) + 1)));
    });
  }

  /** Of each node of a body in a scene, its number in another, or -1. @param {any} before @param {any} now @param {number} b */
  numbersIn(before, now, b) {
    const known = new Map((before?.first[b] ?? []).map((/** @type {number} */ first, /** @type {number} */ node) => [first, node]));
    return Int32Array.from(now.first[b] ?? [], (first) => known.get(first) ?? -1);
  }

  /** Where a node of the scene shown is in a frame; -1: it is not there. @param {any} packet @param {number} body @param {number} node */
  nodeIn(packet, body, node) {
    if (!packet.scene || packet.scene === this.sceneShown) return node;
    return packet.scene.first[body]?.indexOf(this.sceneShown?.first[body]?.[node]) ?? -1;
  }

  /** Where a node of the scene before is now, when meshes have changed; null: it is gone. @param {{body: number, node: number} | null} place */
  nodeNow(place) {
    const body = place ? this.bodies.findIndex(({ path }) => path === this.pathsBefore[place.body]) : -1;
    const node = body < 0 || !place ? undefined : this.nodesNow[body].get(place.node);
    return node === undefined ? null : { body, node };
  }

  /** @param {import('./messages.js').Packet} packet */
  takeHeld({ arrays }) {
    this.heldNow = arrays;
    if (this.following) this.showHeld(arrays);
  }

  /** @param {any} arrays of a packet "held" */
  showHeld(arrays) {
    this.heldShown = arrays;
    for (const body of this.bodies) {
      body.held = arrays[`${body.index}.held`] ?? new Int32Array(0);
      body.guided = arrays[`${body.index}.guided`] ?? new Int32Array(0);
    }
    this.emit('held');
  }

  /** @param {import('./messages.js').Packet} packet */
  takeCells({ arrays }) {
    for (const body of this.bodies) {
      body.tetrahedra = arrays[`${body.index}.tetrahedra`] ?? new Int32Array(0);
      body.hexahedra = arrays[`${body.index}.hexahedra`] ?? new Int32Array(0);
    }
    this.emit('cells');
  }

  /**
   * Shows a frame: the newest one, or one of the past. Not every frame has all fields and the loads.
   * @param {any} packet
   * @param {(name: string) => any} [lastWith] the last packet until then that has an array; null when there is none
   */
  show(packet, lastWith = (name) => this.newestWith.get(name)) {
    const { header, arrays } = packet;
    if (packet.scene && this.sceneShown && packet.scene !== this.sceneShown) this.returnTo(packet.scene);
    this.shown = packet;
    if (packet.held && packet.held !== this.heldShown) this.showHeld(packet.held);
    for (const body of this.bodies) {
      const x = arrays[`${body.index}.x`];
      if (x instanceof Uint16Array) dequantise(x, header.boxes[body.index], body.x);
      else if (x) body.x.set(x);
      body.inside = header.nodes === 'all' || body.surface === body.count;
      const load = `${body.index}.load`;
      body.load = (arrays[load] ? packet : lastWith(load))?.arrays[load] ?? null;
      body.turn = arrays[`${body.index}.turn`] ?? body.turn;
    }
    for (const field of this.fields) {
      const name = `f${field.id}`;
      const source = arrays[name] ? packet : lastWith(name);
      if (!source) {
        this.values.delete(field.id);
        continue;
      }
      this.values.set(field.id, source.arrays[name]);
      if (source.header.nodes === 'all') this.valuesOfAll.add(field.id);
      else this.valuesOfAll.delete(field.id);
    }
    this.emit('frame', packet);
  }

  /** The fields with the name chosen, one per body at most. @returns {Map<number, any>} */
  chosenFields() {
    const chosen = new Map();
    for (const field of this.fields)
      if (fieldKey(field) === this.view.colour && !chosen.has(field.body)) chosen.set(field.body, field);
    return chosen;
  }

  /** What a unit of SI is called in the scene: "mm" for m; empty where the scene's units are unknown. @param {string} si */
  unit(si) { return this.scene?.units?.[si] ?? ''; }

  /** The unit of what colours the bodies. */
  get colourUnit() {
    if (this.view.colour === 'displacement') return this.unit('m');
    const unit = this.fields.find((field) => fieldKey(field) === this.view.colour)?.unit ?? '';
    return unit === '-' || unit === '1' ? '' : unit;
  }
}

/** What a body keeps when its scene is sent again with the same nodes. @param {Body} body */
function stateOf({ x, inside, load, turn, held, guided, tetrahedra, hexahedra }) {
  return { x, inside, load, turn, held, guided, tetrahedra, hexahedra };
}

/** @param {Int32Array} a @param {Int32Array} [b] */
const sameNumbers = (a, b = new Int32Array(0)) => a.length === b.length && a.every((value, i) => value === b[i]);

/** What is shown as one choice: fields of several bodies with the same name, place and unit. @param {any} field */
export const fieldKey = (field) => `${field.name}|${field.on}|${field.unit}`;
