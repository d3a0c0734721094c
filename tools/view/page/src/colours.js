// SPDX-License-Identifier: LGPL-2.1-or-later
// Colour maps that are even to the eye and safe for the colour-blind, and the quiet colours of bodies.

// viridis (Smith, van der Walt) and cividis (Nuñez, Anderton, Renslow) at 33 even places.
const VIRIDIS =
  '440154470d6048186a482374472d7b4537814240863e49893b528b375b8d33638d2f6b8e2c728e297a8e26828e23898e' +
  '21918c1f988b1fa08822a78528ae8032b67a3fbc734ec36b5ec96270cf5784d44b98d83eaddc30c2df23d8e219ece51b' + 'fde725';
const CIVIDIS =
  '00224e00285b002e6a0533711a386f273e6e32436d3b496c434e6c4b546c535a6d5a5f6e61656f686a716f7073767676' +
  '7d7c788482798c8878938e789b9476a39a74aba072b4a76fbcae6cc4b468cdbb63d5c25edec958e7d150f0d846f9e03a' + 'fee838';

/** @typedef {[number, number, number]} Colour red, green and blue, 0 to 1, as a screen takes them (sRGB) */

/** @param {string} text @returns {Colour[]} */
function table(text) {
  const colours = [];
  for (let i = 0; i < text.length; i += 6) colours.push(hex(text.slice(i, i + 6)));
  return colours;
}

/** @param {string} text six hexadecimal digits @returns {Colour} */
export function hex(text) {
  return [0, 2, 4].map((i) => parseInt(text.slice(i, i + 2), 16) / 255);
}

/** @param {number} c */
const linear = (c) => (c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4);
/** @param {number} c */
const screen = (c) => Math.min(1, Math.max(0, c <= 0.0031308 ? 12.92 * c : 1.055 * c ** (1 / 2.4) - 0.055));

/** Björn Ottosson's Oklab. @param {Colour} colour @returns {Colour} lightness, a, b */
export function toOklab(colour) {
  const [r, g, b] = colour.map(linear);
  const l = Math.cbrt(0.4122214708 * r + 0.5363325363 * g + 0.0514459929 * b);
  const m = Math.cbrt(0.2119034982 * r + 0.6806995451 * g + 0.1073969566 * b);
  const s = Math.cbrt(0.0883024619 * r + 0.2817188376 * g + 0.6299787005 * b);
  return [0.2104542553 * l + 0.793617785 * m - 0.0040720468 * s, 1.9779984951 * l - 2.428592205 * m + 0.4505937099 * s,
    0.0259040371 * l + 0.7827717662 * m - 0.808675766 * s];
}

/** @param {Colour} lab @returns {Colour} */
function fromOklab([L, a, b]) {
  const l = (L + 0.3963377774 * a + 0.2158037573 * b) ** 3;
  const m = (L - 0.1055613458 * a - 0.0638541728 * b) ** 3;
  const s = (L - 0.0894841775 * a - 1.291485548 * b) ** 3;
  return [screen(4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s),
    screen(-1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s),
    screen(-0.0041960863 * l - 0.7034186147 * m + 1.707614701 * s)];
}

/** Blue over a light grey to red; the lightness is even on both sides. @returns {Colour[]} */
function diverging() {
  const blue = toOklab(hex('1b4f9c'));
  const middle = toOklab(hex('ececea'));
  const red = toOklab(hex('a3261f'));
  red[0] = blue[0];
  return Array.from({ length: 33 }, (_, i) => {
    const end = i < 16 ? blue : red;
    const t = Math.abs(i - 16) / 16;
    return fromOklab([0, 1, 2].map((c) => middle[c] + (end[c] - middle[c]) * t));
  });
}

/** @type {Record<string, {title: string, colours: Colour[]}>} */
export const MAPS = {
  viridis: { title: 'Viridis', colours: table(VIRIDIS) },
  cividis: { title: 'Cividis', colours: table(CIVIDIS) },
  diverging: { title: 'Blue to red (signed)', colours: diverging() },
};

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

// Tissue, then bone, vessel, cartilage and other quiet colours, told apart by lightness too.
const BODIES = ['c98276', 'd9cfb4', '7f96b8', '9db48f', 'b99ac0', 'd3a865', '76aaa8', 'a98a74'].map(hex);

/** @param {number} number @returns {Colour} */
export const bodyColour = (number) => BODIES[number % BODIES.length];

/** Of the lines of cells: the dark ends of the maps swallow dark ones. @param {string} field that colours the bodies @returns {Colour} */
export const lineColour = (field) => (field ? [0.78, 0.8, 0.82] : [0.08, 0.09, 0.1]);
