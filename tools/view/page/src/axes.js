// SPDX-License-Identifier: LGPL-2.1-or-later
// The directions of the axes, in a corner of the picture.

const COLOURS = ['#c9433a', '#3f8f4a', '#3b6fc4'];

/** @param {HTMLElement} parent @param {import('./stage.js').Stage} stage */
export function showAxes(parent, stage) {
  const make = (/** @type {string} */ tag, /** @type {Record<string, string>} */ attributes) => {
    const element = document.createElementNS('http://www.w3.org/2000/svg', tag);
    for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
    return element;
  };
  const svg = make('svg', { id: 'axes', viewBox: '-32 -32 64 64', 'aria-hidden': 'true' });
  const lines = COLOURS.map((stroke) => make('line', { x1: '0', y1: '0', stroke }));
  const texts = COLOURS.map((fill) => make('text', { fill }));
  texts.forEach((text, c) => (text.textContent = 'xyz'[c]));
  svg.append(...lines, ...texts);
  parent.append(svg);
  let last = '';
  stage.afterDraw.push(() => {
    const e = stage.camera.matrixWorldInverse.elements;
    const key = e.slice(0, 11).join();
    if (key === last) return;
    last = key;
    for (let c = 0; c < 3; c++) {
      const x = e[4 * c], y = -e[4 * c + 1];
      lines[c].setAttribute('x2', String(19 * x));
      lines[c].setAttribute('y2', String(19 * y));
      texts[c].setAttribute('x', String(27 * x));
      texts[c].setAttribute('y', String(27 * y));
    }
  });
}
