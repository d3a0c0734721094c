// SPDX-License-Identifier: LGPL-2.1-or-later
// The legend: what the colours mean, with numbers and unit. It is drawn into pictures and videos too.
import { colourAt, css, gradient } from './colours.js';
import { alike, number, scaleFor, ticks } from './formats.js';
import { h } from './dom.js';
import { shared } from './gpu.js';

export class Legend {
  /** @param {HTMLElement} parent @param {import('./store.js').Store} store @param {import('./stage.js').Stage} stage */
  constructor(parent, store, stage) {
    this.store = store;
    this.stage = stage;
    this.caption = h('div', { class: 'caption' });
    this.scale = h('div', { class: 'scale' });
    this.marks = h('div', { class: 'marks' });
    this.notes = h('div', { class: 'notes' });
    this.element = h('div', { id: 'legend', 'data-test': 'legend', role: 'img', hidden: true }, this.caption, this.scale, this.marks, this.notes);
    parent.append(this.element);
    this.last = '';
    stage.afterDraw.push(() => this.update());
  }

  /** The largest value that is shown now. */
  get most() { return this.stage.colouring.largest; }

  /** What the legend says now, or null. */
  content() {
    const { view } = this.store;
    if (!view.colour || !view.legend || !this.store.scene) return null;
    const { x: low, y: high } = shared.range.value;
    const scale = scaleFor(Math.max(Math.abs(low), Math.abs(high)), this.store.colourUnit);
    const places = high > low ? ticks(low, high, 5) : [low];
    const texts = alike(places.map((place) => place / scale.factor));
    const { most } = this;
    const unit = scale.unit ? ` ${scale.unit}` : '';
    return {
      caption: titleOf(view.colour) + (scale.unit ? ` [${scale.unit}]` : ''), map: view.map,
      maximum: Number.isFinite(most) ? `Maximum ${number(most / scale.factor)}${unit}` : '',
      note: view.range === 'most' && view.colour !== 'displacement' && !this.stage.colouring.isOfContact ? '98 % of the values' : '',
      marks: places.map((place, i) => ({ at: high > low ? (place - low) / (high - low) : 0.5, text: texts[i] })),
    };
  }

  update() {
    const content = this.content();
    const key = JSON.stringify(content);
    if (key === this.last) return;
    this.last = key;
    this.element.hidden = !content;
    if (!content) return;
    this.caption.textContent = content.caption;
    this.notes.replaceChildren(...[content.maximum, content.note].filter(Boolean).map((line) => h('div', {}, line)));
    this.scale.style.background = gradient(content.map);
    this.element.setAttribute('aria-label', `${content.caption}, from ${content.marks[0]?.text} to ${content.marks[content.marks.length - 1]?.text}`);
    this.marks.replaceChildren(...content.marks.map(({ at, text }) => {
      const mark = h('span', {}, text);
      mark.style.top = `${100 * (1 - at)}%`;
      return mark;
    }));
  }

  /** Draws the legend into a picture. @param {CanvasRenderingContext2D} context @param {number} width @param {number} height @param {number} scale pixels per CSS pixel */
  draw(context, width, height, scale) {
    const content = this.content();
    if (!content) return;
    const style = getComputedStyle(document.documentElement);
    context.save();
    context.scale(scale, scale);
    context.font = '600 12px system-ui, sans-serif';
    const notes = [content.maximum, content.note].filter(Boolean);
    const box = { w: Math.max(92, ...[content.caption, ...notes].map((line) => context.measureText(line).width + 20)), h: 196 + 16 * notes.length };
    const left = width / scale - box.w - 14;
    const top = height / scale - box.h - 14;
    context.fillStyle = style.getPropertyValue('--panel');
    context.strokeStyle = style.getPropertyValue('--line');
    context.beginPath();
    context.roundRect(left, top, box.w, box.h, 8);
    context.fill();
    context.stroke();
    context.fillStyle = style.getPropertyValue('--text');
    context.textBaseline = 'middle';
    context.fillText(content.caption, left + 10, top + 16);
    const [from, length] = [top + 32, 150];
    for (let i = 0; i < length; i++) {
      context.fillStyle = css(colourAt(content.map, 1 - i / (length - 1)));
      context.fillRect(left + 10, from + i, 14, 1.5);
    }
    context.fillStyle = style.getPropertyValue('--text');
    context.font = '12px system-ui, sans-serif';
    for (const { at, text } of content.marks) context.fillText(text, left + 32, from + (1 - at) * length);
    notes.forEach((line, i) => context.fillText(line, left + 10, from + length + 20 + 16 * i));
    context.restore();
  }
}

/** @type {Record<string, string>} */
const TITLES = { pressures: 'Contact pressure', gaps: 'Contact gap', contactAreas: 'Contact area', contactStates: 'Sticks 1, slides 2', contactForces: 'Contact force', frictionForces: 'Friction force' };

/** The name of a choice of colour for people. @param {string} key */
export function titleOf(key) {
  const [name, ...more] = key.split('|')[0].split(' ');
  if (TITLES[name]) return [TITLES[name], ...more].join(' ');
  const spaced = name.replace(/([a-z])([A-Z])/g, '$1 $2');
  return spaced.charAt(0).toUpperCase() + spaced.slice(1);
}
