// SPDX-License-Identifier: LGPL-2.1-or-later
// True places and drawn ones: the deformation is drawn larger by a factor k, and hands act in truth.

/** @param {ArrayLike<number>} rest @param {ArrayLike<number>} x @param {number} k @returns {number[]} where it is drawn */
export const exaggerated = (rest, x, k) => [0, 1, 2].map((c) => rest[c] + k * (x[c] - rest[c]));

/** @param {Float32Array} values three for each node @param {number} node */
const of = (values, node) => values.subarray(3 * node, 3 * node + 3);

/**
 * The true place of a point that was picked on the drawn surface: the same point of the same face; of a single node its place.
 * @param {{x: Float32Array, rest: Float32Array}} body
 * @param {{node: number, nodes: number[], point: number[]}} picked
 * @param {number} k
 * @returns {number[]}
 */
export function truePlace({ x, rest }, { node, nodes, point }, k) {
  if (k === 1) return point;
  if (nodes.length !== 3) return [...of(x, node)];
  const [a, b, c] = nodes.map((n) => exaggerated(of(rest, n), of(x, n), k));
  const along = (/** @type {number[]} */ p) => p.map((value, i) => value - a[i]);
  const dot = (/** @type {number[]} */ p, /** @type {number[]} */ q) => p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
  const [u, v, w] = [along(b), along(c), along(point)];
  const uu = dot(u, u), uv = dot(u, v), vv = dot(v, v);
  const area = uu * vv - uv * uv;
  if (!(area > 0)) return [...of(x, node)];
  const s = (vv * dot(u, w) - uv * dot(v, w)) / area;
  const t = (uu * dot(v, w) - uv * dot(u, w)) / area;
  const [p, q, r] = nodes.map((n) => of(x, n));
  return [0, 1, 2].map((i) => (1 - s - t) * p[i] + s * q[i] + t * r[i]);
}

/**
 * How far from its true place a ball is drawn, so that it touches the drawn body where it touches the true one: as far as the
 * node of the surface that is nearest to it.
 * @param {{x: Float32Array, rest: Float32Array, surface: number}} body @param {number[]} centre @param {number} k
 * @returns {number[]}
 */
export function shiftOfBall({ x, rest, surface }, centre, k) {
  if (k === 1) return [0, 0, 0];
  let closest = Infinity;
  let nearest = -1;
  for (let n = 0; n < surface; n++) {
    const square = (x[3 * n] - centre[0]) ** 2 + (x[3 * n + 1] - centre[1]) ** 2 + (x[3 * n + 2] - centre[2]) ** 2;
    if (square < closest) [closest, nearest] = [square, n];
  }
  return nearest < 0 ? [0, 0, 0] : [0, 1, 2].map((c) => (k - 1) * (x[3 * nearest + c] - rest[3 * nearest + c]));
}
