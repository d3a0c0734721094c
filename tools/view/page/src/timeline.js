// SPDX-License-Identifier: LGPL-2.1-or-later
// The line of time below the picture: looks back at kept frames, plays recordings, shows where the time of a step goes.
import { h, signButton } from './dom.js';
import { number } from './formats.js';

const PLAY = 'M4 2.5v11l9.5-5.5z';
const SHARES = [['step', 'Step', '#4f8fb0'], ['copy', 'Transfer', '#c98a3d'], ['fields', 'Fields', '#8f78b5'], ['drawing', 'Drawing', '#6aa06a']];

export class Timeline {
  /**
   * @param {HTMLElement} element @param {import('./store.js').Store} store @param {import('./stage.js').Stage} stage
   * @param {import('./history.js').History} history @param {import('./commands.js').Commands} commands
   */
  constructor(element, store, stage, history, commands) {
    Object.assign(this, { store, stage, history, commands });
    this.store = store;
    this.history = history;
    this.commands = commands;
    this.measured = { at: 0, spent: 0, share: 0 };
    this.index = -1;
    this.playing = 0;
    this.loop = true;
    this.play = signButton('play', 'Play', PLAY, () => this.toggle());
    this.slider = h('input', { test: 'timeline', type: 'range', min: 0, max: 0, step: 1, value: 0, 'aria-label': 'Time shown', oninput: () => this.seek(Number(this.slider.value)) });
    this.at = h('span', { class: 'at number', 'data-test': 'shown-time' });
    this.live = h('button', { test: 'live', type: 'button', title: 'Show the run as it is now', onclick: () => this.goLive() }, 'Live');
    this.shareBar = h('span', { class: 'bar' }, ...SHARES.map(([, , colour]) => {
      const part = h('span');
      part.style.background = colour;
      return part;
    }));
    this.shareText = h('span', { class: 'number', 'data-test': 'shares' });
    this.shares = h('span', { class: 'shares', title: 'Where the time of the simulation goes; drawing happens in the browser beside it' }, this.shareBar, this.shareText);
    element.append(this.play, this.slider, this.at, this.live, this.shares);
    store.on('arrived', () => this.update());
    store.on('status', () => this.update());
    store.on('scene', () => {
      if (!store.continued && !(store.exported && store.changed)) {
        this.stop();
        this.index = -1;
      }
      this.update();
    });
    store.on('frame', () => this.showTime());
    this.update();
  }

  get mode() {
    if (!this.commands.connection) return 'exported';
    return this.store.scene?.mode === 'recording' ? 'recording' : 'live';
  }

  get count() {
    return this.mode === 'recording' ? this.store.status.recording?.count ?? 0 : this.history.frames.length;
  }

  update() {
    const { mode, count } = this;
    const wasLive = this.store.following && mode === 'live';
    this.slider.max = String(Math.max(0, count - 1));
    this.slider.disabled = count < 2;
    if (wasLive) this.slider.value = this.slider.max;
    else if (mode === 'recording' && this.store.status.recording && document.activeElement !== this.slider && !this.playing)
      this.slider.value = String(this.store.newest?.header.index ?? this.store.status.recording.index ?? 0);
    this.play.hidden = mode === 'live';
    this.live.hidden = mode !== 'live';
    this.live.setAttribute('aria-pressed', String(this.store.following));
    this.shares.hidden = mode !== 'live';
    this.showShares();
    this.showTime();
  }

  showTime() {
    const header = this.store.shown?.header;
    this.at.textContent = header ? `${number(header.time, 4)} ${this.store.unit('s')}`.trim() : '';
    this.slider.setAttribute('aria-valuetext', this.at.textContent);
  }

  showShares() {
    const { status } = this.store;
    const now = performance.now();
    if (now - this.measured.at > 500) {
      const { drawMilliseconds } = this.stage;
      this.measured = { at: now, spent: drawMilliseconds, share: (drawMilliseconds - this.measured.spent) / (now - this.measured.at) };
    }
    const share = status.running ? { ...status.share, drawing: this.measured.share } : {};
    const parts = SHARES.map(([key]) => share[key] ?? 0);
    const total = Math.max(1, parts.reduce((sum, part) => sum + part, 0));
    parts.forEach((part, i) => (this.shareBar.children[i].style.width = `${(100 * part) / total}%`));
    const percent = (/** @type {number} */ part) => `${Math.round(100 * part)} %`;
    this.shareText.textContent = `step ${number(status.step_ms ?? 0, 2)} ms · ${SHARES.map(([, name], i) => `${name.toLowerCase()} ${percent(parts[i])}`).join(' · ')}`;
  }

  /** Shows an instant of the past, or of a recording. @param {number} index */
  seek(index) {
    this.index = Math.min(this.count - 1, Math.max(0, index));
    this.slider.value = String(this.index);
    if (this.mode === 'recording') return this.commands.send({ do: 'seek', index: this.index });
    const frame = this.history.frames[this.index];
    if (!frame) return;
    this.store.following = false;
    this.store.show(frame, (name) => this.history.lastWith(this.index, name));
    this.live.setAttribute('aria-pressed', 'false');
  }

  goLive() {
    this.stop();
    this.store.following = true;
    if (this.store.newest) this.store.show(this.store.newest);
    this.update();
  }

  /** @param {number} steps */
  move(steps) {
    this.stop();
    this.seek((this.index < 0 ? Number(this.slider.value) : this.index) + steps);
  }

  toggle() {
    if (this.playing) return this.stop();
    this.play.setAttribute('aria-pressed', 'true');
    const start = Number(this.slider.value) >= this.count - 1 ? 0 : Number(this.slider.value);
    const begun = performance.now();
    const times = this.times();
    const duration = times[times.length - 1] - times[0];
    let index = -1;
    const tick = () => {
      if (!this.playing) return;
      const now = times[start] - times[0] + (performance.now() - begun) / 1000;
      if (now > duration && !this.loop) {
        this.seek(times.length - 1);
        return this.stop();
      }
      const time = times[0] + (duration > 0 ? now % (duration + 0.4) : 0); // rests a moment at the end
      let next = times.findIndex((t) => t > time) - 1;
      if (next < 0) next = time >= times[times.length - 1] ? times.length - 1 : 0;
      if (next !== index) this.seek((index = next));
      this.playing = requestAnimationFrame(tick);
    };
    this.playing = requestAnimationFrame(tick);
  }

  stop() {
    cancelAnimationFrame(this.playing);
    this.playing = 0;
    this.play.setAttribute('aria-pressed', 'false');
  }

  /** The times of all instants [s]. @returns {number[]} */
  times() {
    if (this.mode === 'recording') {
      const { times, count } = this.store.status.recording;
      return times ?? Array.from({ length: count }, (_, i) => i * (this.store.scene.dt || 0.04));
    }
    return this.history.frames.map((frame) => frame.header.time);
  }
}
