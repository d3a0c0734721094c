// SPDX-License-Identifier: LGPL-2.1-or-later
import assert from 'node:assert/strict';
import test from 'node:test';
import { beamCurve, rotationVector, turnTowards, turned } from '../src/beams.js';

const near = (/** @type {number[]} */ a, /** @type {number[]} */ b, tolerance = 1e-12) =>
  a.forEach((value, i) => assert.ok(Math.abs(value - b[i]) < tolerance, `${a} and ${b}`));
const about = (/** @type {number[]} */ axis, /** @type {number} */ angle) => [...axis.map((c) => Math.sin(angle / 2) * c), Math.cos(angle / 2)];

test('a vector turns with its frame', () => {
  near(turned([1, 0, 0], about([0, 0, 1], Math.PI / 2)), [0, 1, 0]);
  near(turned([0, 1, 0], about([1, 0, 0], Math.PI / 2)), [0, 0, 1]);
});

test('a straight beam is straight, and a bent one leaves its ends along their axes', () => {
  const beam = [0, 1, 0, 1, 0.1, 2, 0, 0, 2, 0, 0];
  for (const [i, place] of beamCurve(beam, [0, 0, 0], [2, 0, 0], [0, 0, 0, 1], [0, 0, 0, 1], 4).entries()) near(place, [i / 2, 0, 0]);
  // a quarter of a circle of length 2
  const radius = 4 / Math.PI;
  const curve = beamCurve(beam, [0, 0, 0], [radius, radius, 0], [0, 0, 0, 1], about([0, 0, 1], Math.PI / 2), 100);
  near(curve[0], [0, 0, 0]);
  near(curve[100], [radius, radius, 0]);
  near(curve[1].map((c) => c / curve[1][0]), [1, 0, 0], 0.02);
  for (const place of curve) assert.ok(Math.abs(Math.hypot(place[0], place[1] - radius) - radius) < 0.02 * radius, `${place}`);
});

test('a frame turns as its axis is dragged', () => {
  near(turnTowards([0, 0, 0, 1], [1, 0, 0], [0, 3, 0]), [0, 0, Math.PI / 2]);
  const start = about([0, 0, 1], 0.4);
  near(turnTowards(start, [1, 0, 0], [Math.cos(0.3), Math.sin(0.3), 0]), [0, 0, 0.7]);
  near(turnTowards(start, [1, 0, 0], [1, 0, 0]), [0, 0, 0.4]);
  near(turnTowards(start, [1, 0, 0], [-1, 0, 0]), [0, 0, 0.4]);
  near(rotationVector([0, 0, -Math.sin(0.2), -Math.cos(0.2)]), [0, 0, 0.4]);
  const tilted = turnTowards(about([1, 0, 0], 0.5), [0, 0, 1], [0, 1, 1]);
  near(tilted, [0.5 - Math.PI / 4, 0, 0]);
});
