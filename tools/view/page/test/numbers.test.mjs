// SPDX-License-Identifier: LGPL-2.1-or-later
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { alike, number, quantity, ticks } from '../src/formats.js';
import { History } from '../src/history.js';
import { Series } from '../src/series.js';
import { Store } from '../src/store.js';

test('quantities are written with prefixes that suit them', () => {
  assert.equal(quantity(12345, 'Pa'), '12.3 kPa');
  assert.equal(quantity(-0.0021, 'm'), '−2.10 mm');
  assert.equal(quantity(0, 'N'), '0 N');
  assert.equal(quantity(250, 's'), '250 s');
  assert.equal(quantity(0.001, 'm2'), '0.00100 m2');
  assert.equal(number(NaN), 'NaN');
  assert.equal(number(1.5e-7), '1.5e−7');
});

test('ticks are round and lie within the range', () => {
  assert.deepEqual(ticks(0, 1, 5), [0, 0.2, 0.4, 0.6000000000000001, 0.8, 1]);
  assert.deepEqual(ticks(3, 3, 5), [3]);
  for (const tick of ticks(-1.234, 5.678, 5)) assert.ok(tick >= -1.234 && tick <= 5.678);
  assert.deepEqual(alike([0, 0.25, 0.5]), ['0.00', '0.25', '0.50']);
});

function frame(step, bytes = 100) {
  return { header: { step, time: step / 100 }, arrays: {}, bytes };
}

test('kept frames stay below their limit and cover the whole run evenly', () => {
  const store = new Store();
  store.scene = { mode: 'live' };
  const history = new History(store, 5000);
  for (let step = 0; step < 1000; step++) history.keep(frame(step));
  assert.ok(history.bytes <= 5000);
  assert.ok(history.frames.length > 20);
  const steps = history.frames.map(({ header }) => header.step);
  const gaps = steps.slice(1).map((step, i) => step - steps[i]);
  assert.equal(Math.min(...gaps), Math.max(...gaps));
  assert.equal(steps[0], 0);
  history.keep(frame(3));
  assert.equal(history.frames.length, 1, 'a reset begins anew');
});

test('a series aligns values that begin late, forgets the time before a reset and is written as CSV', () => {
  const series = new Series();
  series.add(0, { a: 1 });
  series.add(1, { a: 2, b: 0.1 });
  series.add(1, { a: 3, b: 0.2 });
  assert.equal(series.csv(), 'time,a,b\n0,1,\n1,3,0.2\n');
  series.add(0.5, { a: 7 });
  assert.deepEqual(series.times, [0.5]);
});

test('units with a prefix of their own keep their size', () => {
  assert.equal(quantity(10.7, 'N'), '10.7 N');
  assert.equal(quantity(10700, 'mN'), '10.7 N'); // of a scene in mm, kg, s
  assert.equal(quantity(12, 'kPa'), '12.0 kPa');
  assert.equal(quantity(0.02, 'MPa'), '20.0 kPa');
  assert.equal(quantity(120, 'mm'), '120 mm');
  assert.equal(quantity(3, 'mm/s'), '3.00 mm/s');
  assert.equal(quantity(5, 'uJ'), '5.00 µJ');
  assert.equal(quantity(12345, ''), '12345'); // unknown units: a number alone
});
