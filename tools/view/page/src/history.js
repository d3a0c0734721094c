// SPDX-License-Identifier: LGPL-2.1-or-later
// Frames kept in the page, to look back while the run goes on. When they fill their share of memory every second one is
// dropped, and from then on only every second one is kept: the whole run stays covered evenly.

export const LIMIT = 256e6; // bytes

export class History {
  /** @param {import('./store.js').Store} store @param {number} [limit] bytes */
  constructor(store, limit = LIMIT) {
    this.store = store;
    this.limit = limit;
    /** Kept for every how many arrived. */
    this.stride = 1;
    this.skipped = 0;
    this.clear();
    store.on('scene', () => store.sameScene || (store.exported && store.changed) || this.clear());
    store.on('arrived', (packet) => this.keep(packet));
  }

  clear() {
    /** @type {any[]} */
    this.frames = [];
    this.bytes = 0;
    this.stride = 1;
    this.skipped = 0;
    /** The step before which nothing is known. */
    this.latest = -1;
    /** Number of the run that the frames belong to: it grows with each reset. */
    this.run = 0;
  }

  /** @param {any} packet */
  keep(packet) {
    if (this.store.scene.mode === 'recording' && !this.store.exported) return; // the server has them all
    const { step, run = 0 } = packet.header;
    if (this.frames.length && (run !== this.run || step < this.latest)) { // the run was reset
      this.clear();
      this.store.following = true; // nothing is left to look back at
    }
    this.latest = step;
    this.run = run;
    const last = this.frames[this.frames.length - 1];
    // the same instant with other fields or nodes; a recording has times, and no steps
    if (last && last.header.step === step && last.header.time === packet.header.time) {
      this.bytes += packet.bytes - last.bytes;
      this.frames[this.frames.length - 1] = packet;
      return;
    }
    if (this.frames.length && ++this.skipped < this.stride) return;
    this.skipped = 0;
    this.frames.push(packet);
    this.bytes += packet.bytes;
    if (this.bytes > this.limit && this.frames.length > 2) this.thin();
  }

  thin() {
    this.frames = this.frames.filter((_, i) => i % 2 === 0);
    this.bytes = this.frames.reduce((sum, frame) => sum + frame.bytes, 0);
    this.stride *= 2;
  }

  /** The last frame, at or before one, that has an array: fields and loads do not come with each. @param {number} index @param {string} name */
  lastWith(index, name) {
    for (let i = index; i >= 0 && this.frames[i].scene === this.frames[index].scene; i--) if (this.frames[i].arrays[name]) return this.frames[i];
    return null;
  }
}
