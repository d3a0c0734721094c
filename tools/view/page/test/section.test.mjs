// SPDX-License-Identifier: LGPL-2.1-or-later
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { HEXAHEDRON_EDGES, TETRAHEDRON_EDGES, cutCells, distances } from '../src/section.js';

const TETRAHEDRON = Float32Array.of(0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1);
const CUBE = Float32Array.of(0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0, 0, 1, 1, 0, 1, 1, 1, 1, 0, 1, 1);

/** Cuts one cell; returns the area of the section, its corners and outlines. */
function cut(x, edges, normal, offset, values = null) {
  const length = Math.hypot(...normal);
  const n = normal.map((c) => c / length);
  const distance = new Float32Array(x.length / 3);
  distances(x, n, offset / length, distance);
  const corners = [];
  const ends = [];
  const cell = Int32Array.from({ length: x.length / 3 }, (_, i) => i);
  cutCells(cell, edges, x, distance, n, (a, b, t) => (values ? values[a] + t * (values[b] - values[a]) : 0),
    { corner: (...p) => corners.push(p), end: (...p) => ends.push(p) });
  let area = 0;
  for (let i = 0; i < corners.length; i += 3) {
    const [p, q, r] = corners.slice(i, i + 3);
    const u = [0, 1, 2].map((c) => q[c] - p[c]);
    const v = [0, 1, 2].map((c) => r[c] - p[c]);
    area += 0.5 * Math.hypot(u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]);
  }
  for (const p of corners) assert.ok(Math.abs(p[0] * n[0] + p[1] * n[1] + p[2] * n[2] - offset / length) < 1e-6, 'a corner is off the plane');
  return { area, corners, ends };
}

const near = (a, b) => assert.ok(Math.abs(a - b) < 1e-6, `${a} instead of ${b}`);

test('a tetrahedron is cut to a triangle near a corner', () => {
  const { area, corners, ends } = cut(TETRAHEDRON, TETRAHEDRON_EDGES, [0, 0, 1], 0.25);
  near(area, 0.5 * 0.75 * 0.75);
  assert.equal(corners.length, 3);
  assert.equal(ends.length, 6);
});

test('a tetrahedron is cut to a quadrangle between two edges', () => {
  const { area, corners, ends } = cut(TETRAHEDRON, TETRAHEDRON_EDGES, [1, 1, 0], 0.5);
  near(area, 0.5 * 0.5 * Math.SQRT2); // 0.5 high, 0.5 sqrt(2) wide
  assert.equal(corners.length, 6);
  assert.equal(ends.length, 8);
});

test('a hexahedron is cut to a square, a hexagon and a triangle', () => {
  near(cut(CUBE, HEXAHEDRON_EDGES, [1, 0, 0], 0.3).area, 1);
  const hexagon = cut(CUBE, HEXAHEDRON_EDGES, [1, 1, 1], 1.5);
  near(hexagon.area, (3 * Math.sqrt(3)) / 4);
  assert.equal(hexagon.ends.length, 12);
  near(cut(CUBE, HEXAHEDRON_EDGES, [1, 1, 1], 0.5).area, (Math.sqrt(3) / 2) * 0.25);
});

test('the section of a plane beside a cell is empty, and a corner on the plane does no harm', () => {
  assert.equal(cut(CUBE, HEXAHEDRON_EDGES, [1, 0, 0], 2).corners.length, 0);
  near(cut(CUBE, HEXAHEDRON_EDGES, [1, -1, 0], 0).area, Math.SQRT2);
});

test('a linear field is exact on the section', () => {
  const field = Array.from({ length: 8 }, (_, i) => 1 + 2 * CUBE[3 * i] - CUBE[3 * i + 1] + 3 * CUBE[3 * i + 2]);
  for (const [x, y, z, value] of cut(CUBE, HEXAHEDRON_EDGES, [1, 2, 3], 2.2, field).corners) near(value, 1 + 2 * x - y + 3 * z);
});
