// SPDX-License-Identifier: LGPL-2.1-or-later
// What is under the pointer: the first face hit by a ray at the positions drawn now, or the nearest single node.
import { shared } from './gpu.js';

const NEAR = 12; // CSS pixels
const BESIDE = 6; // CSS pixels beside the outline of a body that still count

/** @typedef {{body: number, node: number, sceneNode: number, nodes: number[], point: number[], distance: number}} Picked */

/**
 * @param {import('./stage.js').Stage} stage
 * @param {number} x CSS pixels in the window @param {number} y
 * @returns {Picked | null}
 */
export function pick(stage, x, y) {
  const ray = stage.ray(x, y);
  const origin = ray.origin.toArray();
  const direction = ray.direction.toArray();
  /** @type {any} */
  let best = null;
  for (const view of stage.views) {
    if (!view.body.visible || !stage.store.view.surface) continue;
    const hit = hitFaces(view.body, origin, direction, best?.distance ?? Infinity);
    if (hit) best = { body: view.body.index, ...hit };
  }
  best = hitSection(stage, origin, direction, best);
  best = nearestLoose(stage, x, y, best) ?? best ?? nearestBeside(stage, x, y);
  if (!best) return null;
  const body = stage.store.bodies[best.body];
  const point = origin.map((o, c) => o + best.distance * direction[c]);
  const node = best.node ?? nearest(stage.views[best.body], best.nodes, point);
  return { body: best.body, node, sceneNode: body.sceneNode[node], nodes: best.nodes ?? [node], point, distance: best.distance };
}

/** What is in the middle of the picture; when nothing is there, the node drawn nearest to it. @param {import('./stage.js').Stage} stage @returns {Picked | null} */
export function pickMiddle(stage) {
  const box = stage.canvas.getBoundingClientRect();
  const [x, y] = [box.left + box.width / 2, box.top + box.height / 2];
  const hit = pick(stage, x, y);
  if (hit) return hit;
  let closest = Infinity;
  let found = null;
  for (const view of stage.views) {
    if (!view.body.visible) continue;
    for (let n = 0; n < (view.body.surface || view.body.count); n++) {
      const place = stage.toScreen(view.drawnAt(n));
      const away = Math.hypot(place.x - x, place.y - y);
      if (place.depth > 1 || away >= closest) continue;
      closest = away;
      found = { view, node: n };
    }
  }
  if (!found) return null;
  const { view, node } = found;
  const seen = stage.toScreen(view.drawnAt(node));
  // What hides that node is meant.
  return pick(stage, seen.x, seen.y) ?? { body: view.body.index, node, sceneNode: view.body.sceneNode[node], nodes: [node], point: view.drawnAt(node), distance: 0 };
}

/** @param {any} body @param {number[]} o @param {number[]} d @param {number} limit */
function hitFaces(body, o, d, limit) {
  const { triangles, x, rest } = body;
  const k = shared.exaggeration.value;
  const cut = shared.cut.value ? shared.plane.value : null;
  const p = new Float64Array(9);
  let distance = limit;
  let found = -1;
  for (let t = 0; t < triangles.length; t += 3) {
    for (let corner = 0; corner < 3; corner++) {
      const i = 3 * triangles[t + corner];
      for (let c = 0; c < 3; c++) p[3 * corner + c] = k === 1 ? x[i + c] : rest[i + c] + k * (x[i + c] - rest[i + c]);
    }
    const at = hitTriangle(p, o, d);
    if (!(at > 0 && at < distance)) continue;
    if (cut && cut.x * (o[0] + at * d[0]) + cut.y * (o[1] + at * d[1]) + cut.z * (o[2] + at * d[2]) > cut.w) continue;
    distance = at;
    found = t;
  }
  return found < 0 ? null : { distance, nodes: [...triangles.subarray(found, found + 3)] };
}

/**
 * Distance along the ray to a triangle, or NaN (Möller and Trumbore).
 * @param {Float64Array} p nine coordinates @param {number[]} o @param {number[]} d
 */
export function hitTriangle(p, o, d) {
  const e1x = p[3] - p[0], e1y = p[4] - p[1], e1z = p[5] - p[2];
  const e2x = p[6] - p[0], e2y = p[7] - p[1], e2z = p[8] - p[2];
  const hx = d[1] * e2z - d[2] * e2y, hy = d[2] * e2x - d[0] * e2z, hz = d[0] * e2y - d[1] * e2x;
  const det = e1x * hx + e1y * hy + e1z * hz;
  if (det === 0) return NaN;
  const sx = o[0] - p[0], sy = o[1] - p[1], sz = o[2] - p[2];
  const u = (sx * hx + sy * hy + sz * hz) / det;
  if (u < 0 || u > 1) return NaN;
  const qx = sy * e1z - sz * e1y, qy = sz * e1x - sx * e1z, qz = sx * e1y - sy * e1x;
  const v = (d[0] * qx + d[1] * qy + d[2] * qz) / det;
  if (v < 0 || u + v > 1) return NaN;
  return (e2x * qx + e2y * qy + e2z * qz) / det;
}

/** The section of a cut hides what is behind it: its nearest node is picked. */
function hitSection(/** @type {any} */ stage, /** @type {number[]} */ o, /** @type {number[]} */ d, /** @type {any} */ best) {
  const { fill } = stage.cut;
  if (!fill.object.visible) return best;
  let distance = best?.distance ?? Infinity;
  let found = false;
  const p = new Float64Array(9);
  for (let i = 0; i < fill.count; i += 3) {
    p.set(fill.position.subarray(3 * i, 3 * i + 9));
    const at = hitTriangle(p, o, d);
    if (at > 0 && at < distance) {
      distance = at;
      found = true;
    }
  }
  if (!found) return best;
  const point = o.map((c, i) => c + distance * d[i]);
  let closest = Infinity;
  for (const view of stage.views) {
    if (!view.body.visible || !view.body.tetrahedra) continue;
    for (let n = 0; n < view.body.count; n++) {
      const [x, y, z] = view.drawnAt(n);
      const square = (x - point[0]) ** 2 + (y - point[1]) ** 2 + (z - point[2]) ** 2;
      if (square < closest) {
        closest = square;
        best = { body: view.body.index, node: n, nodes: [n], distance };
      }
    }
  }
  return best;
}

/** A node of a surface whose outline the pointer just misses: the nearest one to the eye. */
function nearestBeside(/** @type {any} */ stage, /** @type {number} */ x, /** @type {number} */ y) {
  if (!stage.store.view.surface) return null;
  const { camera } = stage;
  const m = camera.projectionMatrix.clone().multiply(camera.matrixWorldInverse).elements;
  const picture = stage.canvas.getBoundingClientRect();
  const eye = camera.position.toArray();
  const cut = shared.cut.value ? shared.plane.value : null;
  let found = null;
  for (const view of stage.views) {
    if (!view.body.visible || view.body.triangles.length === 0) continue;
    for (let n = 0; n < view.body.surface; n++) {
      const p = view.drawnAt(n);
      const w = m[3] * p[0] + m[7] * p[1] + m[11] * p[2] + m[15];
      const px = picture.left + ((m[0] * p[0] + m[4] * p[1] + m[8] * p[2] + m[12]) / w + 1) * 0.5 * picture.width;
      const py = picture.top + (1 - (m[1] * p[0] + m[5] * p[1] + m[9] * p[2] + m[13]) / w) * 0.5 * picture.height;
      if (!(w > 0 && Math.hypot(px - x, py - y) < BESIDE)) continue;
      if (cut && cut.x * p[0] + cut.y * p[1] + cut.z * p[2] > cut.w) continue;
      const distance = Math.hypot(p[0] - eye[0], p[1] - eye[1], p[2] - eye[2]);
      if (!found || distance < found.distance) found = { body: view.body.index, node: n, nodes: [n], distance };
    }
  }
  return found;
}

/** Nodes without faces: points, and bodies of lines. */
function nearestLoose(/** @type {any} */ stage, /** @type {number} */ x, /** @type {number} */ y, /** @type {any} */ best) {
  let found = null;
  let closest = NEAR;
  const origin = stage.camera.position.toArray();
  for (const view of stage.views) {
    if (!view.body.visible) continue;
    const loose = view.body.triangles.length ? view.body.points : [...view.body.points, ...view.body.edges, ...view.body.beams.flatMap((/** @type {number[]} */ beam) => beam.slice(0, 2)),
      ...view.body.balls.map((/** @type {number[]} */ ball) => ball[0])];
    for (const node of loose) {
      const at = view.drawnAt(node);
      const place = stage.toScreen(at);
      const away = Math.hypot(place.x - x, place.y - y);
      const distance = Math.hypot(...at.map((/** @type {number} */ c, /** @type {number} */ i) => c - origin[i]));
      if (place.depth > 1 || away >= closest || (best && distance > 1.02 * best.distance)) continue;
      closest = away;
      found = { body: view.body.index, node, nodes: [node], distance };
    }
  }
  return found;
}

/**
 * The end of a rigid frame's axis under the pointer: by it the frame is turned.
 * @param {import('./stage.js').Stage} stage @param {number} x @param {number} y
 * @returns {{body: number, frame: number, end: number[]} | null}
 */
export function pickAxis(stage, x, y) {
  let found = null;
  let closest = NEAR;
  if (!stage.store.view.frames) return null;
  for (const view of stage.views) {
    if (!view.body.visible) continue;
    for (let frame = 0; frame < view.body.frames.length; frame++)
      for (const end of view.axesOf(frame)) {
        const place = stage.toScreen(end);
        const away = Math.hypot(place.x - x, place.y - y);
        if (place.depth > 1 || away >= closest) continue;
        closest = away;
        found = { body: view.body.index, frame, end };
      }
  }
  return found;
}

/** @param {any} view @param {number[]} nodes @param {number[]} point */
function nearest(view, nodes, point) {
  let best = nodes[0];
  let closest = Infinity;
  for (const node of nodes) {
    const at = view.drawnAt(node);
    const away = Math.hypot(at[0] - point[0], at[1] - point[1], at[2] - point[2]);
    if (away < closest) [closest, best] = [away, node];
  }
  return best;
}
