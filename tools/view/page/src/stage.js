// SPDX-License-Identifier: LGPL-2.1-or-later
// The picture: camera, bodies, section. Draws only when something changed, within an animation frame.
import * as THREE from 'three';
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';
import { BodyView } from './body.js';
import { Colouring } from './colouring.js';
import { Contacts } from './contacts.js';
import { Cut } from './cut.js';
import { setColourMap, shared } from './gpu.js';
import { Growing } from './shapes.js';

export class Stage {
  /** @param {HTMLCanvasElement} canvas @param {import('./store.js').Store} store */
  constructor(canvas, store) {
    this.canvas = canvas;
    this.store = store;
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, powerPreference: 'high-performance' });
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    shared.pixelRatio.value = this.renderer.getPixelRatio();
    this.camera = new THREE.PerspectiveCamera(32, 1, 0.01, 100);
    this.world = new THREE.Scene();
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.zoomToCursor = true;
    this.controls.addEventListener('change', () => this.requestDraw());
    /** @type {BodyView[]} */
    this.views = [];
    this.cut = new Cut(store);
    this.colouring = new Colouring(store);
    this.links = new Growing('lines', { mode: 2, lift: 0.00003 }, true);
    this.world.add(...this.cut.objects, this.links.object);
    this.contacts = new Contacts(store, this.world);
    this.restBox = new THREE.Box3();
    this.asked = false;
    this.frameChanged = this.choicesChanged = false;
    this.frameDrawn = -1;
    /** Time spent drawing so far [ms]. */
    this.drawMilliseconds = 0;
    /** @type {number[]} frames that arrived and were not yet answered */
    this.arrived = [];
    /** Called after drawing: for the frames to acknowledge, the delay of hands, and what follows the picture. */
    /** @type {((arrived: number[]) => void)[]} */
    this.afterDraw = [];
    this.fitPending = true;
    /** The plane before which nothing is drawn, where the eye is no nearer to what it looks at [m]. */
    this.near = 0.01;
    /** Of the bodies that are seen, the one that was framed alone. */
    this.framed = -1;
    this.follows = false;
    /** @type {THREE.Vector3 | null} where the bodies were when the camera went with them last */
    this.followed = null;
    setColourMap(store.view.map);
    this.listen();
    new ResizeObserver(() => this.resize()).observe(/** @type {HTMLElement} */ (canvas.parentElement));
    this.resize();
  }

  listen() {
    const { store } = this;
    store.on('scene', () => this.build());
    store.on('held', () => {
      for (const view of this.views) view.setConstraints();
      this.choose();
    });
    store.on('cells', () => this.choose());
    store.on('arrived', (packet) => {
      this.arrived.push(packet.header.frame);
      this.requestDraw();
    });
    // Frames of an earlier connection are nothing to the new one.
    store.on('connection', () => store.connection.state === 'open' && (this.arrived = []));
    store.on('frame', () => {
      this.frameChanged = true;
      this.requestDraw();
    });
    store.on('view', (change) => {
      if (change.map) setColourMap(change.map);
      if (change.exaggeration !== undefined) shared.exaggeration.value = change.exaggeration;
      this.choose();
    });
  }

  build() {
    for (const view of this.views) view.dispose();
    this.views = this.store.bodies.map((body) => new BodyView(body, this.store));
    for (const view of this.views) this.world.add(view.group);
    for (const view of this.views) view.setConstraints();
    this.contacts.build();
    if (!this.store.continued && !this.store.changed) this.colouring.reset();
    this.measure();
    // The same scene sent again, after a lost connection or a change of topology, keeps the camera.
    if (this.fitPending || this.name !== this.store.scene.name) this.view();
    this.name = this.store.scene.name;
    this.fitPending = false;
    this.choose();
  }

  /** The box of what is drawn now; the plane of the cut is placed in it. */
  measure() {
    this.restBox.makeEmpty();
    for (const view of this.views) if (view.body.visible) view.extend(this.restBox);
  }

  choose() {
    this.choicesChanged = this.frameChanged = true;
    this.requestDraw();
  }

  /** The box of what is drawn now. @param {(body: import('./store.js').Body) => boolean} [isMeant] some of the bodies that are seen */
  box(isMeant = () => true) {
    const box = new THREE.Box3();
    for (const view of this.views) if (view.body.visible && isMeant(view.body)) view.extend(box);
    if (this.store.view.obstacles && this.views.every(({ body }) => isMeant(body))) this.extendByObstacles(box);
    if (box.isEmpty()) box.set(new THREE.Vector3(-0.5, -0.5, -0.5), new THREE.Vector3(0.5, 0.5, 0.5));
    return box;
  }

  /** By those that are not much larger than the bodies. @param {THREE.Box3} box */
  extendByObstacles(box) {
    const size = box.getSize(new THREE.Vector3()).length();
    for (const view of this.contacts.obstacles) {
      const own = new THREE.Box3();
      view.extend(own);
      if (!own.isEmpty() && own.getSize(new THREE.Vector3()).length() < 2 * size && own.distanceToPoint(box.getCenter(new THREE.Vector3())) < 2 * size) box.union(own);
    }
  }

  /** Whether the camera goes where the bodies go. @param {boolean} on */
  follow(on) {
    this.follows = on;
    this.followed = on ? this.roughBox().getCenter(new THREE.Vector3()) : null;
    this.store.emit('view', {});
  }

  /** The box of some hundred nodes of each body: for every frame. */
  roughBox() {
    const some = 500;
    const box = new THREE.Box3();
    const point = new THREE.Vector3();
    for (const view of this.views) {
      const used = view.body.visible ? view.body.surface || view.body.count : 0;
      for (let n = 0; n < used; n += Math.ceil(used / some)) {
        point.set(...view.drawnAt(n));
        if (Number.isFinite(point.x + point.y + point.z)) box.expandByPoint(point);
      }
    }
    return box;
  }

  /** What has gone far stays drawn, and in the middle when the camera follows. */
  keepInSight() {
    if (!this.views.length) return;
    const box = this.roughBox();
    if (box.isEmpty()) return;
    const centre = box.getCenter(new THREE.Vector3());
    if (this.follows && this.followed) {
      const step = centre.clone().sub(this.followed);
      this.camera.position.add(step);
      this.controls.target.add(step);
      this.followed = centre;
    }
    const reach = this.reachOf(box);
    if (!(reach > this.camera.far / 2)) return;
    this.camera.far = 4 * reach;
    this.controls.maxDistance = Math.max(this.controls.maxDistance, 2 * reach);
    this.camera.updateProjectionMatrix();
  }

  /** How far from the eye a box may end. @param {THREE.Box3} box [m] */
  reachOf(box) {
    return this.camera.position.distanceTo(box.getCenter(new THREE.Vector3())) + box.getSize(new THREE.Vector3()).length();
  }

  /** Frames one body after the other. */
  fitNext() {
    const seen = this.views.filter((view) => view.body.visible);
    if (seen.length === 0) return;
    const next = (this.framed + 1) % seen.length;
    this.fit((body) => body === seen[next].body);
    this.framed = next;
  }

  /** Frames the bodies, or some of them, without turning the camera. @param {(body: import('./store.js').Body) => boolean} [isMeant] */
  fit(isMeant) {
    this.framed = -1;
    const box = this.box(isMeant);
    const centre = box.getCenter(new THREE.Vector3());
    const back = this.camera.position.clone().sub(this.controls.target).normalize();
    const right = new THREE.Vector3().crossVectors(this.camera.up, back).normalize();
    const up = new THREE.Vector3().crossVectors(back, right);
    const height = 0.84 * Math.tan((this.camera.fov * Math.PI) / 360); // a margin around
    const width = height * this.camera.aspect;
    let distance = 1e-6;
    for (let corner = 0; corner < 8; corner++) {
      const p = new THREE.Vector3(corner & 1 ? box.max.x : box.min.x, corner & 2 ? box.max.y : box.min.y, corner & 4 ? box.max.z : box.min.z).sub(centre);
      distance = Math.max(distance, p.dot(back) + Math.abs(p.dot(up)) / height, p.dot(back) + Math.abs(p.dot(right)) / width);
    }
    this.controls.target.copy(centre);
    this.camera.position.copy(centre).addScaledVector(back, distance);
    // Bodies may be far apart: from each of them all others are in reach.
    const all = this.roughBox();
    const reach = all.isEmpty() ? 0 : this.reachOf(all);
    const seen = this.views.filter((view) => view.body.visible);
    this.near = this.camera.near = distance / 200;
    this.camera.far = Math.max(distance * 20, 2 * reach);
    this.controls.minDistance = Math.min(distance, ...seen.map((view) => 2 * (view.body.size || distance))) / 100;
    this.controls.maxDistance = Math.max(distance * 8, 2 * reach);
    this.camera.updateProjectionMatrix();
    this.controls.update();
    this.requestDraw();
  }

  /** The first view: from the front, a little from above. */
  view() {
    this.controls.target.set(0, 0, 0);
    this.camera.up.set(0, 1, 0);
    const gravity = this.store.scene?.gravity ?? [0, -1, 0];
    const direction = new THREE.Vector3(0.35, 0.3, 1);
    if (Math.abs(gravity[2]) > Math.abs(gravity[1])) { // the third axis is up
      this.camera.up.set(0, 0, 1);
      direction.set(0.35, -1, 0.35);
    }
    // OrbitControls keeps the up of its beginning.
    const quaternion = new THREE.Quaternion().setFromUnitVectors(this.camera.up, new THREE.Vector3(0, 1, 0));
    Object.assign(this.controls, { _quat: quaternion, _quatInverse: quaternion.clone().invert() });
    this.camera.position.copy(direction);
    this.fit();
  }

  /** A movement as it is seen: to the right, up and away from the eye. @param {number} right @param {number} up @param {number} away [m] */
  inPicture(right, up, away) {
    this.camera.updateMatrixWorld();
    const [x, y, z] = [0, 1, 2].map((axis) => new THREE.Vector3().setFromMatrixColumn(this.camera.matrixWorld, axis));
    return x.multiplyScalar(right).addScaledVector(y, up).addScaledVector(z, -away);
  }

  /** Turns the view about its middle. @param {number} sideways @param {number} upward angles */
  turn(sideways, upward) {
    const back = this.camera.position.clone().sub(this.controls.target);
    const right = new THREE.Vector3().crossVectors(this.camera.up, back).normalize();
    const fromUp = back.angleTo(this.camera.up); // never over the pole
    const tilt = Math.min(Math.max(fromUp - upward, 0.01), Math.PI - 0.01) - fromUp;
    back.applyAxisAngle(right, tilt).applyAxisAngle(this.camera.up, sideways);
    this.camera.position.copy(this.controls.target).add(back);
    this.controls.update();
    this.requestDraw();
  }

  /** Moves the view. @param {number} right @param {number} up parts of the picture's height */
  move(right, up) {
    const height = 2 * this.camera.position.distanceTo(this.controls.target) * Math.tan((this.camera.fov * Math.PI) / 360);
    const step = this.inPicture(right * height, up * height, 0);
    this.camera.position.add(step);
    this.controls.target.add(step);
    this.controls.update();
    this.requestDraw();
  }

  /** Comes nearer or goes away. @param {number} factor of the distance */
  zoom(factor) {
    const back = this.camera.position.clone().sub(this.controls.target);
    const { minDistance, maxDistance } = this.controls;
    back.setLength(Math.min(Math.max(back.length() * factor, minDistance), maxDistance));
    this.camera.position.copy(this.controls.target).add(back);
    this.controls.update();
    this.requestDraw();
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = /** @type {HTMLElement} */ (this.canvas.parentElement);
    if (width === 0 || height === 0) return;
    this.renderer.setSize(width, height, false);
    // What fitted into a narrow picture fits into a wide one, and fills it.
    const nearer = Math.min(1, this.camera.aspect) / Math.min(1, width / height);
    this.camera.position.sub(this.controls.target).multiplyScalar(nearer).add(this.controls.target);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.controls.update();
    this.draw(); // at once: setting the size has emptied the canvas
  }

  requestDraw() {
    if (this.asked) return;
    this.asked = true;
    requestAnimationFrame(() => {
      this.asked = false;
      this.draw();
    });
  }

  draw() {
    const begin = performance.now();
    if (this.frameChanged) this.update();
    const near = Math.min(this.near, this.camera.position.distanceTo(this.controls.target) / 4);
    if (near > 0 && near !== this.camera.near) {
      this.camera.near = near;
      this.camera.updateProjectionMatrix();
    }
    const dark = document.documentElement.dataset.theme === 'dark';
    this.renderer.setClearColor(dark ? 0x23282e : 0xf7f7f4, 1);
    this.renderer.render(this.world, this.camera);
    this.frameDrawn = this.store.shown?.header.frame ?? -1;
    this.drawMilliseconds += performance.now() - begin;
    const { arrived } = this;
    this.arrived = [];
    for (const follower of this.afterDraw) follower(arrived);
  }

  update() {
    const { store } = this;
    for (const view of this.views) {
      if (!view.body.visible) continue;
      view.update();
    }
    this.keepInSight();
    this.colouring.update();
    for (const view of this.views) {
      const { kind, surface } = this.colouring.of(view.body);
      view.colourBy(/** @type {any} */ (kind), surface);
      view.choose();
    }
    if (store.view.cut.on || shared.cut.value) this.cut.update(this.restBox, (body) => this.colouring.of(body));
    this.updateLinks();
    this.contacts.update(this.views);
    this.frameChanged = this.choicesChanged = false;
  }

  updateLinks() {
    const links = this.store.links ?? [];
    this.links.clear();
    if (this.store.view.springs)
      for (let k = 0; k < links.length; k += 4) {
        const tint = this.store.linkKinds[k / 4] === 1 ? [0.75, 0.55, 0.15] : [0.45, 0.4, 0.7];
        for (const end of [k, k + 2]) {
          const [x, y, z] = this.views[links[end]].drawnAt(links[end + 1]);
          this.links.add(x, y, z, 0, tint);
        }
      }
    this.links.finish();
  }

  /** @param {number[]} point of the world @returns {{x: number, y: number, depth: number}} CSS pixels in the window */
  toScreen(point) {
    const rectangle = this.canvas.getBoundingClientRect();
    const p = new THREE.Vector3(...point).project(this.camera);
    return {
      x: rectangle.left + ((p.x + 1) / 2) * rectangle.width, y: rectangle.top + ((1 - p.y) / 2) * rectangle.height, depth: p.z,
    };
  }

  /** @param {number} x @param {number} y CSS pixels in the window @returns {THREE.Ray} */
  ray(x, y) {
    const rectangle = this.canvas.getBoundingClientRect();
    this.camera.updateMatrixWorld();
    const caster = new THREE.Raycaster();
    caster.setFromCamera(new THREE.Vector2(((x - rectangle.left) / rectangle.width) * 2 - 1,
      1 - ((y - rectangle.top) / rectangle.height) * 2), this.camera);
    return caster.ray;
  }
}
