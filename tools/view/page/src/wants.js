// SPDX-License-Identifier: LGPL-2.1-or-later
// Tells the server what the page wants to see, when that changes.

export class Wants {
  /** @param {import('./store.js').Store} store @param {import('./stage.js').Stage} stage @param {import('./connection.js').Connection | null} connection */
  constructor(store, stage, connection) {
    this.store = store;
    this.stage = stage;
    this.connection = connection;
    this.last = '';
    this.lastWatch = '';
    /** @type {any} */
    this.asking = 0;
    /** Values that the plots want: "energy", "solver". @type {Set<string>} */
    this.groups = new Set();
    /** Who looks at numbers of contacts besides arrows. @type {Set<string>} */
    this.contacts = new Set();
    store.on('scene', () => {
      this.last = this.lastWatch = '';
      this.tell();
      if (!store.changed) return connection?.send({ do: 'components' });
      clearTimeout(this.asking); // a tool that carves changes the mesh in every step
      this.asking = setTimeout(() => connection?.send({ do: 'components' }), 500);
    });
    store.on('view', () => this.tell());
    store.on('visible', () => this.tell());
    store.on('watched', () => this.tell());
  }

  tell() {
    if (!this.connection?.isOpen || !this.store.scene) return;
    const { view } = this.store;
    const fields = [...this.store.chosenFields().values()].map((field) => field.id);
    const want = JSON.stringify({
      do: 'want', nodes: this.stage.cut.needsInside ? 'all' : 'surface', fields, loads: view.loads, contacts: view.contacts || this.contacts.size > 0, format: view.remote ? 'u16' : 'f32', fps: 60,
    });
    if (want !== this.last && this.connection.send(JSON.parse(want))) this.last = want;
    const values = [...this.groups];
    const nodes = [...this.store.watched, ...(this.store.picked ? [this.store.picked] : [])];
    for (const { body, node } of nodes)
      for (const what of ['position', 'velocity', 'reaction']) values.push(`node.${body}.${this.store.bodies[body]?.sceneNode[node]}.${what}`);
    const watch = JSON.stringify({ do: 'watch', values: [...new Set(values)] });
    if (watch !== this.lastWatch && this.connection.send(JSON.parse(watch))) this.lastWatch = watch;
  }
}
