// SPDX-License-Identifier: LGPL-2.1-or-later
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { bulk, extremes } from '../src/colouring.js';

test('the range of most values leaves out one in a hundred at either end, and what is no number', () => {
  const values = Float32Array.from({ length: 1001 }, (_, i) => i);
  values[500] = NaN;
  const all = [Infinity, -Infinity];
  extremes(values, all);
  assert.deepEqual(all, [0, 1000]);
  const most = [Infinity, -Infinity];
  bulk(values, most);
  assert.ok(Math.abs(most[0] - 9.5) <= 1 && Math.abs(most[1] - 990.5) <= 1, String(most));
  bulk(new Float32Array([NaN]), most);
  assert.ok(most[1] < 1000);
});

test('a range of many values is near that of all', () => {
  const values = Float32Array.from({ length: 200000 }, (_, i) => ((i * 7919) % 200000) / 200000);
  const most = [Infinity, -Infinity];
  bulk(values, most);
  assert.ok(Math.abs(most[0] - 0.01) < 0.01 && Math.abs(most[1] - 0.99) < 0.01, String(most));
});
