// SPDX-License-Identifier: LGPL-2.1-or-later
// Colour maps that are even to the eye and safe for the colour-blind, and the quiet colours of bodies: of tools/drawing/colours.json,
// which pictures have too.
import description from './colour_tables.js';

/** @typedef {[number, number, number]} Colour red, green and blue, 0 to 1, as a screen takes them (sRGB) */

/** @param {string} text six hexadecimal digits @returns {Colour} */
export function hex(text) {
  return [0, 2, 4].map((i) => parseInt(text.slice(i, i + 2), 16) / 255);
}

/** @type {Record<string, {title: string, colours: Colour[]}>} */
export const MAPS = Object.fromEntries(description.maps.filter((map) => map.title)
  .map(({ name, title, places }) => [name, { title, colours: places.join(' ').split(' ').map(hex) }]));

/** @param {string} name @param {number} t 0 to 1 @returns {Colour} */
export function colourAt(name, t) {
  const { colours } = MAPS[name];
  const place = Math.min(1, Math.max(0, t)) * (colours.length - 1);
  const i = Math.min(colours.length - 2, Math.floor(place));
  return [0, 1, 2].map((c) => colours[i][c] + (colours[i + 1][c] - colours[i][c]) * (place - i));
}

/** @param {string} name @param {number} count @returns {Uint8Array} `count` colours of four bytes */
export function colourTable(name, count) {
  const bytes = new Uint8Array(4 * count);
  for (let i = 0; i < count; i++)
    bytes.set([...colourAt(name, i / (count - 1)).map((c) => Math.round(255 * c)), 255], 4 * i);
  return bytes;
}

/** @param {string} name @returns {string} a CSS gradient from the lowest value at the bottom to the highest */
export function gradient(name) {
  const stops = Array.from({ length: 17 }, (_, i) => css(colourAt(name, i / 16)));
  return `linear-gradient(to top, ${stops.join(', ')})`;
}

/** @param {Colour} colour */
export const css = (colour) => `rgb(${colour.map((c) => Math.round(255 * c)).join(', ')})`;

const BODIES = description.bodies.split(' ').map(hex);

/** @param {number} number @returns {Colour} */
export const bodyColour = (number) => BODIES[number % BODIES.length];

/** Of the lines of cells: the dark ends of the maps swallow dark ones. @param {string} field that colours the bodies @returns {Colour} */
export const lineColour = (field) => (field ? [0.78, 0.8, 0.82] : [0.08, 0.09, 0.1]);
