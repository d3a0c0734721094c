// SPDX-License-Identifier: LGPL-2.1-or-later
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { scaleOf } from '../src/contact_panel.js';

test('forces and moments have the prefix that suits the largest', () => {
  assert.deepEqual(scaleOf([0.0992, -0.0019], 'N'), { factor: 1e-3, unit: 'mN', least: 0.0992e-4 });
  const moment = scaleOf([8.7e-5, -0.002], 'N m');
  assert.equal(moment.unit, 'mN m');
  assert.equal(moment.factor, 1e-3);
  assert.equal(scaleOf([0, 0], 'N m').unit, 'N m');
  assert.equal(scaleOf([1, 2], '').unit, '');
});
