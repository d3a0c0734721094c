// SPDX-License-Identifier: LGPL-2.1-or-later
// The websocket: connects, sends, connects again with growing delay when the connection is lost.
import { readPacket } from './messages.js';

const FIRST_DELAY = 250; // [ms]
const LONGEST_DELAY = 8000;

export class Connection {
  /** @param {import('./store.js').Store} store */
  constructor(store) {
    this.store = store;
    this.delay = FIRST_DELAY;
    this.requests = 0;
    /** @type {Map<number, (reply: {ok: boolean, message: string}) => void>} */
    this.waiting = new Map();
    /** @type {WebSocket | null} */
    this.socket = null;
    this.retry = 0;
    this.stopped = false;
  }

  open() {
    clearTimeout(this.retry);
    const address = location.origin.replace(/^http/, 'ws') + '/live';
    const socket = new WebSocket(address);
    socket.binaryType = 'arraybuffer';
    this.socket = socket;
    socket.onopen = () => {
      this.delay = FIRST_DELAY;
      this.store.setConnection('open', '');
      this.store.restart();
      this.send({ do: 'hello', ...(this.store.build ? { build: this.store.build } : {}) });
    };
    socket.onmessage = (event) => {
      if (socket === this.socket) this.receive(event.data);
    };
    socket.onclose = () => {
      if (socket === this.socket) this.lost();
    };
  }

  lost() {
    this.socket = null;
    for (const answer of this.waiting.values()) answer({ ok: false, message: 'The connection was lost.' });
    this.waiting.clear();
    if (this.stopped) return;
    const seconds = this.delay / 1000;
    const again = this.delay === LONGEST_DELAY ? ' If the program was started again, open the address that it printed.' : '';
    this.store.setConnection('lost',
      `The connection to the simulation is lost. It is tried again in ${seconds < 1 ? 'a moment' : `${Math.round(seconds)} s`}.${again}`);
    this.retry = window.setTimeout(() => this.open(), this.delay);
    this.delay = Math.min(2 * this.delay, LONGEST_DELAY);
  }

  /** @param {string | ArrayBuffer} data */
  receive(data) {
    try {
      if (typeof data !== 'string') return this.store.receivePacket(readPacket(data));
      const message = JSON.parse(data);
      if (message.is === 'reload') return this.reload();
      if (message.is === 'reply') {
        this.waiting.get(message.request)?.(message);
        this.waiting.delete(message.request);
      }
      this.store.receiveText(message);
    } catch (problem) {
      this.store.say('error', `A message of the server could not be read: ${/** @type {Error} */ (problem).message}`);
    }
  }

  /** Closes without a word: the page is being left. */
  leave() {
    clearTimeout(this.retry);
    const { socket } = this;
    this.socket = null;
    socket?.close();
  }

  reload() {
    this.stopped = true;
    this.socket?.close();
    this.store.setConnection('reload', 'The server was built anew. Reload this page to go on.');
  }

  get isOpen() {
    return this.socket?.readyState === WebSocket.OPEN;
  }

  /** @param {any} message @returns {boolean} whether it could be sent */
  send(message) {
    if (!this.isOpen) return false;
    this.socket?.send(JSON.stringify(message));
    return true;
  }

  /**
   * Sends and waits for the reply.
   * @param {any} message
   * @returns {Promise<{ok: boolean, message: string}>}
   */
  ask(message) {
    const request = ++this.requests;
    return new Promise((resolve) => {
      this.waiting.set(request, resolve);
      if (!this.send({ ...message, request })) {
        this.waiting.delete(request);
        resolve({ ok: false, message: 'There is no connection to the simulation.' });
      }
    });
  }
}
