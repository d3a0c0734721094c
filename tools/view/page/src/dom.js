// SPDX-License-Identifier: LGPL-2.1-or-later
// Elements in short.

/**
 * Makes an element. `test` gives it a name for people who script the page: id and data-test.
 * @param {string} tag
 * @param {Record<string, any>} [attributes] strings; functions for events ("onclick"); properties such as value and checked
 * @param {...(Node | string | null | undefined | false)} children
 * @returns {any}
 */
export function h(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === null || value === undefined || value === false) continue;
    if (name === 'test') {
      element.id = value;
      element.dataset.test = value;
    } else if (typeof value === 'function') element.addEventListener(name.slice(2), value);
    else if (['value', 'checked', 'disabled', 'hidden', 'selected', 'open'].includes(name)) /** @type {any} */ (element)[name] = value;
    else element.setAttribute(name, value === true ? '' : String(value));
  }
  element.append(...children.filter((child) => child !== null && child !== undefined && child !== false).map((child) => /** @type {any} */ (child)));
  return element;
}

/** A button with a drawn sign. @param {string} test @param {string} label @param {string} path of the sign in a square of 16 @param {() => void} onclick */
export function signButton(test, label, path, onclick) {
  const svg = document.createElementNS('http://www.w3.org/2000/svg', 'svg');
  svg.setAttribute('viewBox', '0 0 16 16');
  svg.setAttribute('aria-hidden', 'true');
  const drawn = document.createElementNS('http://www.w3.org/2000/svg', 'path');
  drawn.setAttribute('d', path);
  svg.append(drawn);
  const button = h('button', { test, type: 'button', class: 'sign', title: label, 'aria-label': label, onclick });
  button.append(svg);
  return button;
}

/** @param {string} test @param {string} label @param {boolean} checked @param {(on: boolean) => void} change */
export function checkbox(test, label, checked, change) {
  const input = h('input', { test, type: 'checkbox', checked, onchange: () => change(input.checked) });
  return h('label', { class: 'check' }, input, label);
}

/** @param {string} test @param {string} label @param {[string, string][]} options value and text @param {string} value @param {(value: string) => void} change */
export function choice(test, label, options, value, change) {
  const select = h('select', { test, 'aria-label': label, onchange: () => change(select.value) },
    ...options.map(([key, text]) => h('option', { value: key, selected: key === value }, text)));
  select.value = value;
  return select;
}

/** A number that is taken over by Enter or by leaving the field. */
export function numberField(/** @type {string} */ test, /** @type {string} */ label, /** @type {string} */ value, /** @type {(value: number, text: string) => void} */ change, /** @type {Record<string, any>} */ more = {}) {
  const input = h('input', { test, type: 'text', inputmode: 'decimal', 'aria-label': label, value, size: 8, ...more,
    onchange: () => change(Number(input.value.replace(',', '.')), input.value.trim()) });
  return input;
}

/** A row of a panel: a label and what it names. @param {string} label @param {...any} children */
export const row = (label, ...children) => h('div', { class: 'row' }, h('span', { class: 'name' }, label), h('span', { class: 'what' }, ...children));

/** @param {Blob} blob @param {string} name of the file */
export function download(blob, name) {
  const link = h('a', { href: URL.createObjectURL(blob), download: name });
  document.body.append(link);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(link.href), 60000);
}
