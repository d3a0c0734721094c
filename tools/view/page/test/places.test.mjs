// SPDX-License-Identifier: LGPL-2.1-or-later
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { nameOfKey } from '../src/keys.js';
import { watchedByMonitor } from '../src/monitors.js';
import { exaggerated, shiftOfBall, truePlace } from '../src/places.js';

const rest = Float32Array.of(0, 0, 0, 1, 0, 0, 0, 1, 0);
const x = Float32Array.of(0, 0, 0.5, 1, 0, 0.25, 0.25, 1, 0.5);
const body = { rest, x, surface: 3 };
const near = (a, b) => a.forEach((value, i) => assert.ok(Math.abs(value - b[i]) < 1e-6, `${a} is not ${b}`));

test('a point picked on the exaggerated face is the same point of the true one', () => {
  const weights = [0.2, 0.3, 0.5];
  const mix = (points) => [0, 1, 2].map((c) => weights.reduce((sum, w, n) => sum + w * points[n][c], 0));
  const of = (values, n) => values.subarray(3 * n, 3 * n + 3);
  const drawn = mix([0, 1, 2].map((n) => exaggerated(of(rest, n), of(x, n), 7)));
  near(truePlace(body, { node: 2, nodes: [0, 1, 2], point: drawn }, 7), mix([0, 1, 2].map((n) => of(x, n))));
  near(truePlace(body, { node: 2, nodes: [2], point: drawn }, 7), of(x, 2));
  assert.deepEqual(truePlace(body, { node: 2, nodes: [0, 1, 2], point: [1, 2, 3] }, 1), [1, 2, 3]);
});

test('a ball is drawn where it touches the exaggerated body', () => {
  near(shiftOfBall(body, [0, 0, 0.6], 5), [0, 0, 2]);
  near(shiftOfBall(body, [0.25, 1.1, 0.5], 5), [1, 0, 2]);
  near(shiftOfBall(body, [0, 0, 0.6], 1), [0, 0, 0]);
});

test('letters are told by Shift, not by Caps Lock', () => {
  const name = (key, shiftKey = false, altKey = false) => nameOfKey({ key, shiftKey, altKey });
  assert.equal(name('R'), 'r');
  assert.equal(name('r', true), 'Shift r');
  assert.equal(name('R', true), 'Shift r');
  assert.equal(name('?', true), '?');
  assert.equal(name('+', true), '+');
  assert.equal(name('ArrowLeft', true), 'Shift ArrowLeft');
  assert.equal(name('ArrowLeft', false, true), 'Alt ArrowLeft');
  assert.equal(name('1'), '1');
});

test('the nodes of a monitor are found', () => {
  const bodies = [{ index: 0, node: '/a', path: '/a/dofs', sceneNode: Int32Array.of(9, 6, 3) }, { index: 1, node: '/a/b', path: '/a/b/dofs', sceneNode: Int32Array.of(3, 6) }];
  const monitor = (path, indices, mstate = '', long = false) => watchedByMonitor({ type: 'Monitor', path, attributes: [{ name: 'indices', value: indices, long }, { name: 'mstate', value: mstate }] }, bodies);
  assert.deepEqual(monitor('/a/m', '6 9'), { body: 0, nodes: [1, 0], problem: '' });
  assert.deepEqual(monitor('/a/b/m', '6'), { body: 1, nodes: [1], problem: '' });
  assert.deepEqual(monitor('/a/b/c/m', '6'), { body: 1, nodes: [1], problem: '' });
  assert.deepEqual(monitor('/a/b/m', '9', '@/a/dofs'), { body: 0, nodes: [0], problem: '' });
  assert.match(monitor('/a/m', '40 values', '', true).problem, /40 values, too many/);
  assert.match(monitor('/z/m', '6').problem, /not drawn/);
  assert.equal(watchedByMonitor({ type: 'Mass', path: '/a/mass' }, bodies), null);
});
