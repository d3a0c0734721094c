// SPDX-License-Identifier: LGPL-2.1-or-later
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { MAPS, bodyColour, colourAt, colourTable } from '../src/colours.js';

/** Björn Ottosson's Oklab of a colour of a screen: lightness, a, b. */
function toOklab(colour) {
  const [r, g, b] = colour.map((c) => (c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4));
  const l = Math.cbrt(0.4122214708 * r + 0.5363325363 * g + 0.0514459929 * b);
  const m = Math.cbrt(0.2119034982 * r + 0.6806995451 * g + 0.1073969566 * b);
  const s = Math.cbrt(0.0883024619 * r + 0.2817188376 * g + 0.6299787005 * b);
  return [0.2104542553 * l + 0.793617785 * m - 0.0040720468 * s, 1.9779984951 * l - 2.428592205 * m + 0.4505937099 * s,
    0.0259040371 * l + 0.7827717662 * m - 0.808675766 * s];
}
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
  assert.deepEqual(Object.keys(MAPS), ['viridis', 'cividis', 'diverging']);
  for (const { colours } of Object.values(MAPS)) assert.equal(colours.length, 33);
});

test('neighbouring bodies have different colours', () => {
  for (let b = 0; b < 8; b++) assert.notDeepEqual(bodyColour(b), bodyColour(b + 1));
});
