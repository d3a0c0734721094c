// SPDX-License-Identifier: LGPL-2.1-or-later
// Hands: what the pointer does to a body. It pulls a node or a face with a spring, leaves it held, or pushes with a ball. A rigid
// frame is pulled by its centre, also by a surface that it carries, and turned by the end of one of its axes. An obstacle is moved.
import * as THREE from 'three';
import { quantity } from './formats.js';
import { h } from './dom.js';
import { turnTowards } from './beams.js';
import { pick, pickAxis } from './picking.js';
import { exaggerated, shiftOfBall, truePlace } from './places.js';
import { shared } from './gpu.js';
import { Arrows, Balls } from './shapes.js';

const MOST_NODES = 500; // of a patch: a message of one has to stay below 64 kB

/** @typedef {'look' | 'pull' | 'hold' | 'push'} Mode */

const MOST_WAITING = 2000;
// Of a mouse, as SOFA counts them; buttons are left, middle, right.
const MOVED = 0, WHEEL = 5, PRESSED = [1, 6, 3], RELEASED = [2, 7, 4];

export class Hands {
  /** @param {import('./stage.js').Stage} stage @param {import('./store.js').Store} store @param {import('./commands.js').Commands} commands */
  constructor(stage, store, commands) {
    this.stage = stage;
    this.store = store;
    this.commands = commands;
    /** @type {Mode} */
    this.mode = 'look';
    this.grip = 'patch';
    /** @type {number | null} [N/m]; null: the server chooses */
    this.stiffness = null;
    /** Radius of the ball as a part of the body's size. */
    this.radius = 0.06;
    this.sequence = 0;
    /** @type {any} the drag under way */
    this.drag = null;
    /** @type {Map<number, number>} when the event of a sequence number happened */
    this.sent = new Map();
    this.given = false; // a button was pressed for the scene
    this.lastDelay = NaN;
    /** @type {number[]} */
    this.delays = [];
    this.arrows = new Arrows([0.93, 0.45, 0.1]);
    this.balls = new Balls([0.3, 0.45, 0.75], 0.55);
    this.ends = new Balls([0.93, 0.45, 0.1], 1);
    stage.world.add(this.arrows.object, this.balls.object, this.ends.object);
    /** @type {Map<string, HTMLElement>} */
    this.labels = new Map();
    this.overlay = /** @type {HTMLElement} */ (document.getElementById('overlay'));
    stage.afterDraw.push(() => this.afterDraw());
    store.on('frame', () => this.show());
    store.on('scene', () => (store.continued ? this.show() : store.changed ? this.follow() : this.forget()));
    store.on('connection', () => this.store.connection.state !== 'open' && this.forget());
    this.listen(stage.canvas);
  }

  /** @param {HTMLCanvasElement} canvas */
  listen(canvas) {
    canvas.addEventListener('pointerdown', (event) => this.down(event), { capture: true });
    canvas.addEventListener('pointermove', (event) => this.move(event), { capture: true });
    for (const name of /** @type {const} */ (['pointerup', 'pointercancel']))
      canvas.addEventListener(name, (event) => this.up(event), { capture: true });
    canvas.addEventListener('wheel', (event) => this.wheel(event), { capture: true, passive: false });
  }

  /**
   * Ctrl and the pointer go to the controllers of a scene in Python; so does the way until a button is let go.
   * @param {PointerEvent | WheelEvent} event @param {number | undefined} state
   */
  toScene(event, state) {
    if (!(event.ctrlKey || this.given) || this.drag || !this.store.scene?.keys || !this.store.following || state === undefined) return false;
    event.stopImmediatePropagation();
    event.preventDefault();
    const { left, top } = this.stage.canvas.getBoundingClientRect();
    const wheel = event instanceof WheelEvent ? -120 * Math.sign(event.deltaY) : 0;
    this.commands.send({ do: 'mouse', state, x: Math.round(event.clientX - left), y: Math.round(event.clientY - top), wheel });
    return true;
  }

  /** @param {Mode} mode */
  setMode(mode) {
    this.mode = mode;
    this.stage.canvas.dataset.mode = mode;
    this.store.emit('hand-mode', mode);
  }

  /** The hands of the frame shown that are this page's own. */
  get own() {
    return (this.store.shown?.header.hands ?? []).filter((/** @type {any} */ hand) => hand.client === this.store.scene.client);
  }

  /** @param {PointerEvent} event */
  down(event) {
    if (this.toScene(event, PRESSED[event.button])) {
      this.stage.canvas.setPointerCapture(event.pointerId);
      this.given = true;
      return;
    }
    if (this.mode === 'look' || this.drag || event.button !== 0 || !this.store.following || !this.commands.connection) return;
    const tool = this.obstacleAt(event.clientX, event.clientY);
    const axis = this.mode === 'push' ? null : pickAxis(this.stage, event.clientX, event.clientY);
    const seen = axis ?? pick(this.stage, event.clientX, event.clientY);
    const picked = tool && !axis && !(seen?.distance < tool.distance) ? tool : seen;
    const again = axis || this.mode === 'push' ? null : this.heldAt(event.clientX, event.clientY);
    if (!picked && !again) return; // beside the bodies the pointer turns the view
    event.stopImmediatePropagation();
    event.preventDefault();
    if (!this.begin(picked, again)) return;
    this.stage.canvas.setPointerCapture(event.pointerId);
    this.stage.controls.enabled = false;
    this.drag.pointer = event.pointerId;
    const centre = new THREE.Vector3(...this.drag.anchor);
    const normal = this.stage.camera.getWorldDirection(new THREE.Vector3());
    this.drag.plane = new THREE.Plane().setFromNormalAndCoplanarPoint(normal, centre);
    this.drag.grabbed = this.onPlane(event.clientX, event.clientY) ?? centre;
    this.send(event.timeStamp, true);
  }

  /** Takes what was picked, or a hold again. @param {any} picked @param {any} again @returns {boolean} whether it may be moved now */
  begin(picked, again) {
    picked = this.onCarrier(picked);
    const body = this.store.bodies[(again ?? picked).body];
    if (picked?.obstacle !== undefined && !again) return this.beginMove(picked);
    if (!body.interactive) this.store.notify(body.why || `${body.name} cannot be pulled.`, 'warning');
    else if (!this.commands.mayCommand()) this.store.emit('control-needed');
    else {
      this.drag = again ? this.takeAgain(again) : this.mode === 'push' ? this.beginPush(picked, body) : picked.end ? this.beginTurn(picked, body) : this.beginPull(picked, body);
      // As the pointer moves on the picture; in truth all is smaller by the factor of exaggeration.
      this.drag.keys = false;
      this.drag.byPointer = new THREE.Vector3();
      this.drag.byKeys = new THREE.Vector3();
      return true;
    }
    return false;
  }

  /** The obstacle under the pointer. @param {number} x @param {number} y */
  obstacleAt(x, y) {
    const ray = this.stage.ray(x, y);
    const hit = this.stage.contacts.hit(ray);
    return hit && { ...hit, point: ray.at(hit.distance, new THREE.Vector3()).toArray() };
  }

  /** An obstacle is led by the pointer; contact lets it go as far as nothing is in its way. @param {any} picked */
  beginMove({ obstacle, point }) {
    const { movable, name } = this.store.obstacles[obstacle];
    if (!movable) this.store.notify(`${name} does not let its obstacles be moved.`, 'warning');
    else if (!this.commands.mayCommand()) this.store.emit('control-needed');
    else {
      const start = this.store.shown?.header.offsets?.[obstacle] ?? [0, 0, 0];
      this.drag = { hand: `o${obstacle}`, kind: 'move', obstacle, start, anchor: point, moved: new THREE.Vector3(), keys: false, byPointer: new THREE.Vector3(), byKeys: new THREE.Vector3() };
      return true;
    }
    return false;
  }

  /** Of a surface that another body carries, the nearest frame or node of that body. @param {any} picked */
  onCarrier(picked) {
    const body = picked && this.store.bodies[picked.body];
    const carrier = body && !body.interactive ? this.store.bodies[body.carrier ?? -1] : undefined;
    if (!carrier || this.mode === 'push') return picked;
    const nodes = carrier.frames.length ? carrier.frames.map(([place]) => place) : Array.from({ length: carrier.surface || carrier.count }, (_, n) => n);
    const view = this.stage.views[carrier.index];
    const away = (/** @type {number} */ n) => Math.hypot(...view.drawnAt(n).map((c, i) => c - picked.point[i]));
    const node = nodes.reduce((best, n) => (away(n) < away(best) ? n : best), nodes[0]);
    return { ...picked, body: carrier.index, node, nodes: [node], sceneNode: carrier.sceneNode[node] };
  }

  /** Takes a picked node without a pointer; keys move it. A hand that only looks pulls. @param {{body: number, node: number} | null} picked */
  beginByKeys(picked) {
    if (this.drag || !picked || !this.store.following || !this.commands.connection) return false;
    if (this.mode === 'look') this.setMode('pull');
    const { body, node } = picked;
    const held = this.mode === 'push' ? undefined : this.own.find((/** @type {any} */ hand) => hand.kind === 'hold' && hand.body === body && this.kept?.get(hand.hand)?.nodes?.includes(node));
    if (!this.begin({ body, node, nodes: [node], point: this.stage.views[body].drawnAt(node) }, held)) return false;
    this.drag.keys = true;
    this.send(performance.now(), true);
    return true;
  }

  /** Moves what keys have taken. @param {number} right @param {number} up @param {number} away parts of the body's size */
  moveByKeys(right, up, away) {
    const size = this.store.bodies[this.drag.body].size || 1;
    const step = this.stage.inPicture(right * size, up * size, away * size);
    this.drag.byKeys.add(step);
    this.update(performance.now());
  }

  /** Sends where the drag has led. A ball and its body move alike, so the factor holds for both: following the pointer with the drawn
   * ball instead would add the body's answer to the order that caused it, which grows without end. @param {number} time of the event */
  update(time) {
    const { drag } = this;
    drag.moved.addVectors(drag.byPointer, drag.byKeys).divideScalar(drag.kind === 'move' || (drag.kind !== 'push' && drag.arm) ? 1 : shared.exaggeration.value || 1);
    if (drag.before) drag.moved.add(drag.before);
    this.send(time, false);
  }

  /** A name that none of this page's hands has: names come again, so that plots have few curves. */
  freeName() {
    const used = new Set([...(this.kept?.keys() ?? []), ...this.own.map((/** @type {any} */ hand) => hand.hand)]);
    let number = 1;
    while (used.has(`h${number}`)) number++;
    return `h${number}`;
  }

  /** @param {any} picked @param {any} body */
  beginPull(picked, body) {
    const nodes = this.grip === 'node' ? [picked.node] : this.grip === 'patch' ? this.patch(picked, body) : picked.nodes;
    const starts = nodes.map((/** @type {number} */ n) => [...body.x.subarray(3 * n, 3 * n + 3)]);
    return {
      hand: this.freeName(), kind: this.mode, body: body.index, nodes, starts, anchor: picked.point, moved: new THREE.Vector3(),
    };
  }

  /** @param {{frame: number, end: number[]}} picked @param {any} body */
  beginTurn({ frame, end }, body) {
    const view = this.stage.views[body.index];
    const centre = view.drawnAt(body.frames[frame][0]);
    return {
      hand: this.freeName(), kind: this.mode, body: body.index, frame, start: view.turnOf(frame).toArray(), arm: end.map((c, i) => c - centre[i]),
      anchor: end, moved: new THREE.Vector3(),
    };
  }

  /** Nodes of the surface within the ball's radius of the place; the face there when there are none. @param {any} picked @param {any} body */
  patch(picked, body) {
    const reach = (this.radius * body.size) ** 2;
    const at = picked.node; // the drawn place may be exaggerated, that of the node is not
    const nodes = [];
    for (let n = 0; n < body.surface; n++) {
      const square = (body.x[3 * n] - body.x[3 * at]) ** 2 + (body.x[3 * n + 1] - body.x[3 * at + 1]) ** 2 + (body.x[3 * n + 2] - body.x[3 * at + 2]) ** 2;
      if (square <= reach) nodes.push(n);
    }
    return nodes.length > 0 && nodes.length <= MOST_NODES ? nodes : picked.nodes;
  }

  /** The ball touches the body where the pointer is. @param {any} picked @param {any} body */
  beginPush(picked, body) {
    const radius = this.radius * body.size;
    const towards = this.stage.ray(...this.centreOf(picked.point)).direction;
    const before = (/** @type {number[]} */ place) => place.map((p, c) => p - radius * towards.getComponent(c));
    const k = shared.exaggeration.value;
    const centre = before(truePlace(body, picked, k));
    const anchor = before(picked.point);
    // It begins under the pointer, although another node may be nearer to it than what was picked.
    const nearest = shiftOfBall(body, centre, k);
    const offset = anchor.map((c, i) => c - centre[i] - nearest[i]);
    return { hand: this.freeName(), kind: 'push', body: body.index, radius, centre, anchor, offset, moved: new THREE.Vector3() };
  }

  /** @param {number[]} point @returns {[number, number]} */
  centreOf(point) {
    const { x, y } = this.stage.toScreen(point);
    return [x, y];
  }

  /** A hold whose end is under the pointer. @param {number} x @param {number} y */
  heldAt(x, y) {
    return this.own.find((/** @type {any} */ hand) => {
      if (hand.kind !== 'hold' || hand.turns || !this.kept?.has(hand.hand)) return false;
      const place = this.stage.toScreen(this.places(hand).to);
      return Math.hypot(place.x - x, place.y - y) < 14;
    });
  }

  /** @param {any} hand */
  takeAgain(hand) {
    const kept = this.kept?.get(hand.hand);
    return { ...kept, anchor: this.places(hand).to, before: kept.moved.clone(), moved: kept.moved.clone() };
  }

  /** @param {number} x @param {number} y */
  onPlane(x, y) {
    return this.stage.ray(x, y).intersectPlane(this.drag.plane, new THREE.Vector3());
  }

  /** @param {PointerEvent} event */
  move(event) {
    if (this.toScene(event, MOVED)) return;
    if (!this.drag || event.pointerId !== this.drag.pointer) return;
    event.stopImmediatePropagation();
    const place = this.onPlane(event.clientX, event.clientY);
    if (!place) return;
    this.drag.byPointer.subVectors(place, this.drag.grabbed);
    this.update(event.timeStamp);
  }

  /** While a ball is dragged, the wheel moves it along the view. @param {WheelEvent} event */
  wheel(event) {
    if (this.toScene(event, WHEEL)) return;
    if (this.drag?.kind !== 'push') return;
    event.preventDefault();
    event.stopImmediatePropagation();
    this.deepen(-Math.sign(event.deltaY) * 0.15, event.timeStamp);
  }

  /** Moves the ball along the view. @param {number} part of its radius @param {number} time of the event */
  deepen(part, time) {
    if (this.drag?.kind !== 'push') return;
    this.drag.byKeys.add(this.stage.inPicture(0, 0, part * this.drag.radius));
    this.update(time);
  }

  /** @param {PointerEvent} event */
  up(event) {
    const given = this.given && this.toScene(event, RELEASED[event.button]);
    this.given = false;
    if (given) return;
    if (!this.drag || event.pointerId !== this.drag.pointer) return;
    event.stopImmediatePropagation();
    this.end(event.type === 'pointercancel');
  }

  /** Ends the drag; what is held stays held unless `letGo`. @param {boolean} letGo */
  end(letGo) {
    if (!this.drag) return false;
    const { drag } = this;
    this.drag = null;
    this.stage.controls.enabled = true;
    if (drag.kind === 'hold' && !letGo) {
      this.kept ??= new Map();
      this.kept.set(drag.hand, drag);
    } else if (drag.kind !== 'move') this.release(drag.hand);
    this.stage.requestDraw();
    return true;
  }

  /** @param {string} hand */
  release(hand) {
    this.kept?.delete(hand);
    this.commands.send({ do: 'release', hand });
  }

  releaseAll() {
    this.end(true);
    for (const hand of this.own) this.release(hand.hand);
  }

  forget() {
    this.drag = null;
    this.kept = new Map();
    this.sent.clear();
    this.stage.controls.enabled = true;
    this.show();
  }

  /** A mesh has changed: hands have what is left of their nodes, as they have in the run. */
  follow() {
    const moved = (/** @type {any} */ hand) => {
      const at = hand.body === undefined ? -1 : this.store.bodies.findIndex(({ path }) => path === this.store.pathsBefore[hand.body]);
      if (hand.kind === 'move') return hand;
      const now = (hand.nodes ?? []).map((/** @type {number} */ node) => this.store.nodeNow({ body: hand.body, node }));
      if (at < 0 || (hand.nodes && !now.some(Boolean))) return null;
      const left = (/** @type {any[]} */ list) => list?.filter((_, i) => now[i]);
      return Object.assign(hand, { body: at }, hand.nodes ? { nodes: left(now).map(({ node }) => node), starts: left(hand.starts) } : {});
    };
    if (this.drag && !moved(this.drag)) this.end(true);
    for (const [name, hand] of this.kept ?? []) if (!moved(hand)) this.kept.delete(name);
    this.show();
  }

  /** @param {number} time of the event @param {boolean} first */
  send(time, first) {
    const { drag } = this;
    const sequence = ++this.sequence;
    this.sent.set(sequence, time);
    if (this.sent.size > MOST_WAITING) this.sent.delete(this.sent.keys().next().value); // refused ones are never applied
    const moved = drag.moved.toArray();
    const { generation } = this.store.scene;
    const stiffness = this.stiffness === null ? {} : { stiffness: this.stiffness };
    const move = (/** @type {number[]} */ p) => p.map((c, i) => c + moved[i]);
    const message = drag.kind === 'move' ? { do: 'move', hand: drag.hand, obstacle: drag.obstacle, offset: drag.start.map((c, i) => c + moved[i]), sequence }
      : drag.kind === 'push' ? { do: 'push', hand: drag.hand, body: drag.body, centre: move(drag.centre), radius: drag.radius, ...stiffness, generation, sequence }
      : drag.arm ? { do: 'pull', kind: drag.kind, hand: drag.hand, body: drag.body, frames: [drag.frame], targets: [turnTowards(drag.start, drag.arm, move(drag.arm))], ...stiffness, generation, sequence }
      : { do: 'pull', kind: drag.kind, hand: drag.hand, body: drag.body, nodes: drag.nodes, targets: drag.starts.map(move), ...stiffness, generation, sequence };
    if (first) this.commands.tell(message).then((reply) => !reply.ok && this.drag === drag && this.end(true));
    else this.commands.send(message);
  }

  /** Where the arrow of a hand begins and ends: means over its nodes, which the frame tells. @param {any} hand */
  places(hand) {
    const { rest, x, size } = this.store.bodies[hand.body];
    // Frames that were written without these places have the first node.
    const of = (/** @type {Float32Array} */ values) => [...values.subarray(3 * hand.node, 3 * hand.node + 3)];
    const restAt = hand.rest_at ?? of(rest);
    const k = shared.exaggeration.value;
    const from = exaggerated(restAt, hand.at ?? of(x), k);
    const length = Math.hypot(...hand.force) || 1;
    const to = hand.to ? exaggerated(restAt, hand.to, k) : from.map((c, i) => c + (0.1 * (size || 1) * hand.force[i]) / length);
    return { from, to };
  }

  /** Arrows, balls and forces of the frame shown. */
  show() {
    const hands = this.store.shown?.header.hands ?? [];
    const arrows = [], ends = [], balls = [];
    const seen = new Set();
    for (const hand of hands) {
      const body = this.store.bodies[hand.body];
      if (!body) continue;
      const key = `${hand.client}.${hand.hand}`;
      const size = body.size || 1;
      let at;
      if (hand.kind === 'push') {
        const shift = shiftOfBall(body, hand.centre, shared.exaggeration.value);
        const offset = hand.client === this.store.scene.client && this.drag?.hand === hand.hand ? this.drag.offset : [0, 0, 0];
        at = hand.centre.map((/** @type {number} */ c, /** @type {number} */ i) => c + shift[i] + offset[i]);
        balls.push({ at, radius: hand.radius });
      } else {
        const { from, to } = this.places(hand);
        at = to;
        const along = to.map((c, i) => c - from[i]);
        if (Math.hypot(...along) > 1e-4 * size) arrows.push({ at: from, radius: 0.003 * size, along });
        ends.push({ at: hand.kind === 'hold' ? at : from, radius: 0.0075 * size });
      }
      seen.add(key);
      this.label(key, at, Math.hypot(...hand.force), hand);
    }
    for (const [key, label] of this.labels) if (!seen.has(key)) this.labels.delete(key) && label.remove();
    this.arrows.set(arrows);
    this.ends.set(ends);
    this.balls.set(balls);
  }

  /** @param {string} key @param {number[]} at @param {number} force [N] @param {any} hand */
  label(key, at, force, hand) {
    let label = this.labels.get(key);
    if (!label) {
      label = h('div', { class: 'force', 'data-hand': hand.hand });
      this.overlay.append(label);
      this.labels.set(key, label);
    }
    label.dataset.force = String(force);
    label.textContent = quantity(force, this.store.unit(hand.turns ? 'N m' : 'N')) + (hand.kind === 'push' && hand.touched === 0 ? ', touches nothing' : '');
    /** @type {any} */ (label).at = at;
  }

  afterDraw() {
    const bounds = this.overlay.getBoundingClientRect();
    for (const label of this.labels.values()) {
      const { x, y, depth } = this.stage.toScreen(/** @type {any} */ (label).at);
      label.hidden = depth > 1;
      const left = Math.min(Math.max(4, x - bounds.left + 12), bounds.width - label.offsetWidth - 4);
      const top = Math.min(Math.max(4, y - bounds.top - 26), bounds.height - label.offsetHeight - 4);
      label.style.transform = `translate(${Math.round(left)}px, ${Math.round(top)}px)`;
    }
    const applied = this.store.shown?.header.applied?.[this.store.scene?.client] ?? -1;
    const now = performance.now();
    for (const [sequence, time] of this.sent) {
      if (sequence > applied) break;
      this.lastDelay = now - time;
      this.delays.push(this.lastDelay);
      this.sent.delete(sequence);
    }
    if (this.delays.length > 10000) this.delays.splice(0, 5000);
  }
}
