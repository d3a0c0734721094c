// SPDX-License-Identifier: LGPL-2.1-or-later
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { History } from '../src/history.js';
import { Store } from '../src/store.js';

/** @param {number} step @param {number} time @param {number} [run] */
const frame = (step, time, run = 0) => ({ header: { is: 'frame', step, time, run }, arrays: {}, bytes: 100 });

test('the instants of a recording, which all have step 0, are kept apart by their times', () => {
  const store = new Store();
  store.scene = { mode: 'recording' };
  store.exported = true;
  const history = new History(store);
  for (let i = 0; i < 5; i++) history.keep(frame(0, 0.1 * i));
  assert.deepEqual(history.frames.map(({ header }) => header.time), [0, 1, 2, 3, 4].map((i) => 0.1 * i));
});

test('the same instant with other fields takes the place of the one before, and a new run begins anew', () => {
  const store = new Store();
  store.scene = { mode: 'live' };
  const history = new History(store);
  history.keep(frame(3, 0.3));
  history.keep(frame(3, 0.3));
  history.keep(frame(4, 0.4));
  assert.equal(history.frames.length, 2);
  history.keep(frame(5, 0.5, 1));
  assert.equal(history.frames.length, 1);
});
