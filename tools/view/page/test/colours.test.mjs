// SPDX-License-Identifier: LGPL-2.1-or-later
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { MAPS, bodyColour, colourAt, colourTable, toOklab } from '../src/colours.js';

const lightness = (name, t) => toOklab(colourAt(name, t))[0];
const PLACES = Array.from({ length: 101 }, (_, i) => i / 100);

for (const name of ['viridis', 'cividis'])
  test(`${name} grows lighter, evenly`, () => {
    const total = lightness(name, 1) - lightness(name, 0);
    assert.ok(total > 0.55);
    for (const t of PLACES.slice(1)) {
      const step = lightness(name, t) - lightness(name, t - 0.01);
      assert.ok(step > 0 && step < (3 * total) / 100, `at ${t}: ${step}`);
    }
  });

test('the signed map is lightest at zero and even on both sides', () => {
  for (const t of PLACES.slice(1, 50)) {
    assert.ok(lightness('diverging', t) > lightness('diverging', t - 0.01));
    assert.ok(Math.abs(lightness('diverging', t) - lightness('diverging', 1 - t)) < 0.03);
  }
  const [, a, b] = toOklab(colourAt('diverging', 0.5));
  assert.ok(Math.hypot(a, b) < 0.01, 'zero has a hue');
});

test('blue and red are told apart by people who see no red or no green', () => {
  // In Oklab, b (yellow to blue) is what remains.
  assert.ok(toOklab(colourAt('diverging', 1))[2] - toOklab(colourAt('diverging', 0))[2] > 0.1);
});

test('a table has as many colours as asked for, and ends where the map ends', () => {
  const table = colourTable('viridis', 256);
  assert.equal(table.length, 1024);
  assert.deepEqual([...table.slice(0, 4)], [0x44, 0x01, 0x54, 255]);
  assert.deepEqual([...table.slice(-4)], [0xfd, 0xe7, 0x25, 255]);
  for (const { colours } of Object.values(MAPS)) assert.equal(colours.length, 33);
});

test('neighbouring bodies have different colours', () => {
  for (let b = 0; b < 8; b++) assert.notDeepEqual(bodyColour(b), bodyColour(b + 1));
});
