// SPDX-License-Identifier: LGPL-2.1-or-later
// The scene as a tree: nodes, their bodies to show and hide, their components.
import { bodyColour, css } from './colours.js';
import { h, signButton } from './dom.js';

const FRAME = 'M2 2h4v1.6H3.6V6H2zM10 2h4v4h-1.6V3.6H10zM2 10h1.6v2.4H6V14H2zM12.4 10H14v4h-4v-1.6h2.4z';

export class Tree {
  /** @param {HTMLElement} element @param {import('./store.js').Store} store @param {import('./stage.js').Stage} stage */
  constructor(element, store, stage) {
    this.element = element;
    this.store = store;
    this.stage = stage;
    /** @type {Set<string>} */
    this.folded = new Set();
    this.body = h('div', { class: 'body', test: 'tree' });
    element.append(h('div', { class: 'head' }, 'Scene',
      h('button', { test: 'show-all', type: 'button', class: 'small', onclick: () => this.showAll() }, 'Show all')), this.body);
    for (const event of ['scene', 'components', 'selection']) store.on(event, () => this.update());
  }

  showAll() {
    for (const body of this.store.bodies) body.visible = true;
    this.changed();
  }

  changed() {
    this.stage.choose();
    this.store.emit('visible');
    this.update();
  }

  update() {
    const root = this.store.components ?? this.fromBodies();
    // Values of attributes are not shown here: what is pointed at stays as long as nothing else changed.
    const shape = JSON.stringify([root, this.store.selected, [...this.folded], this.store.bodies.map((body) => [body.node, body.visible, body.count])],
      (key, value) => (key === 'attributes' ? undefined : value));
    if (shape === this.shape) return;
    this.shape = shape;
    const focused = this.body.contains(document.activeElement) ? nameOf(/** @type {Element} */ (document.activeElement)) : '';
    const scroll = this.body.scrollTop;
    this.body.replaceChildren(h('ul', { class: 'tree' }, this.node(root)));
    this.body.scrollTop = scroll;
    if (focused) [...this.body.querySelectorAll('button, input')].find((element) => nameOf(element) === focused)?.focus({ preventScroll: true });
  }

  /** The tree while the server has not told its components, or in an exported page. */
  fromBodies() {
    const root = { name: this.store.scene?.name ?? 'scene', path: '/', components: [], children: /** @type {any[]} */ ([]) };
    for (const body of this.store.bodies) {
      let at = root;
      for (const name of body.node.split('/').filter(Boolean)) {
        const path = `${at.path === '/' ? '' : at.path}/${name}`;
        let child = at.children.find((c) => c.path === path);
        if (!child) at.children.push((child = { name, path, components: [], children: [] }));
        at = child;
      }
    }
    return root;
  }

  /** @param {any} node */
  node(node) {
    const inside = node.path === '/' ? '/' : node.path + '/';
    const bodies = this.store.bodies.filter((body) => body.node === node.path || (body.node + '/').startsWith(inside));
    const own = this.store.bodies.filter((body) => body.node === node.path);
    const folded = this.folded.has(node.path);
    const more = node.children?.length + node.components?.length > 0;
    const fold = h('button', { class: 'fold', type: 'button', 'aria-expanded': String(!folded), 'aria-label': `Fold ${node.name}`, onclick: () => {
      if (folded) this.folded.delete(node.path);
      else this.folded.add(node.path);
      this.update();
    } }, more ? (folded ? '▸' : '▾') : '');
    const shown = bodies.length ? h('input', { type: 'checkbox', 'data-test': `show-${node.path}`, 'data-node': node.path, 'aria-label': `Show ${node.name}`, checked: bodies.every((b) => b.visible),
      onchange: (/** @type {any} */ event) => {
        for (const body of bodies) body.visible = event.target.checked;
        this.changed();
      } }) : null;
    if (shown) shown.indeterminate = bodies.some((b) => b.visible) && !bodies.every((b) => b.visible);
    const dots = own.map((body) => {
      const dot = h('span', { class: 'dot', title: `${body.count} nodes` });
      dot.style.background = css(bodyColour(body.index));
      return dot;
    });
    const frame = bodies.length && this.store.bodies.length > 1 ? signButton(`frame-${node.path}`, `Frame ${node.name || '/'}`, FRAME,
      () => bodies.some((body) => body.visible) && this.stage.fit((body) => bodies.includes(body))) : null;
    return h('li', {}, h('div', { class: `item${this.store.selected === node.path ? ' chosen' : ''}` }, fold, shown, ...dots,
      h('button', { class: 'link', type: 'button', title: node.path, onclick: () => this.store.select(node.path) }, node.name || '/'), frame),
    folded ? null : h('ul', { class: 'tree' },
      ...(node.components ?? []).map((/** @type {any} */ component) => this.component(component)),
      ...(node.children ?? []).map((/** @type {any} */ child) => this.node(child))));
  }

  /** @param {any} component */
  component(component) {
    const named = component.name && component.name !== component.type;
    return h('li', {}, h('div', { class: `item${this.store.selected === component.path ? ' chosen' : ''}` }, h('span', { class: 'fold' }),
      h('button', { class: 'link', type: 'button', 'data-path': component.path, title: `${component.path}\n${component.help ?? ''}`, onclick: () => this.store.select(component.path) },
        named ? component.name : '', named ? ' ' : '', h('span', { class: 'type' }, component.type))));
  }
}

/** What stays of a control when the tree is made anew. @param {Element} element */
const nameOf = (element) => element.getAttribute('aria-label') ?? `${element.tagName} ${element.getAttribute('title')}`;
