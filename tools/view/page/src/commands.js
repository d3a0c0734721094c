// SPDX-License-Identifier: LGPL-2.1-or-later
// Commands to the simulation. One page has control: it is taken when nobody has it, and asked for when another page has.

export class Commands {
  /** @param {import('./connection.js').Connection | null} connection none in an exported page @param {import('./store.js').Store} store */
  constructor(connection, store) {
    this.connection = connection;
    this.store = store;
  }

  get hasControl() {
    return this.store.scene && this.store.status.control === this.store.scene.client;
  }

  /** Whether a command may be sent now; takes control when nobody has it. */
  mayCommand() {
    if (!this.connection?.isOpen || !this.store.scene) return false;
    const { control } = this.store.status;
    if (control === null || control === undefined) {
      this.connection.send({ do: 'control' });
      this.store.status.control = this.store.scene.client; // the status that follows says the same
    }
    return this.hasControl;
  }

  /**
   * @param {any} message
   * @returns {Promise<{ok: boolean, message: string}>}
   */
  async ask(message) {
    if (!this.connection) return { ok: false, message: 'This page replays a recording: there is no simulation to command.' };
    if (this.connection.isOpen && !this.mayCommand()) {
      this.store.emit('control-needed');
      return { ok: false, message: 'Another page has control of this run. Take control first.', needsControl: true };
    }
    return this.connection.ask(message);
  }

  /** Like ask, and a refusal is shown among the messages. @param {any} message */
  async tell(message) {
    const reply = await this.ask(message);
    if (!reply.ok && !(/** @type {any} */ (reply).needsControl)) this.store.notify(reply.message);
    return reply;
  }

  /** Without a reply, for what is sent often. @param {any} message */
  send(message) {
    return this.mayCommand() && this.connection?.send(message);
  }

  /** What needs no control. @param {any} message */
  request(message) {
    return this.connection?.send(message) ?? false;
  }

  takeControl() {
    return this.connection?.ask({ do: 'control' });
  }
}
