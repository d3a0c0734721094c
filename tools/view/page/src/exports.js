// SPDX-License-Identifier: LGPL-2.1-or-later
// The tab "Export": picture, video, one page that replays, the changed scene, the actions, the numbers.
import html from '../index.html';
import { download, h, numberField, row } from './dom.js';
import { exportedPage } from './recording.js';

const VIDEO = ['video/webm;codecs=vp9', 'video/webm;codecs=vp8', 'video/webm', 'video/mp4'];

export class ExportPanel {
  /** @param {HTMLElement} body @param {any} parts */
  constructor(body, parts) {
    Object.assign(this, parts);
    this.store = parts.store;
    this.stage = parts.stage;
    this.stride = 1;
    /** @type {MediaRecorder | null} */
    this.recorder = null;
    const button = (/** @type {string} */ test, /** @type {string} */ label, /** @type {() => any} */ act) =>
      h('button', { test, type: 'button', onclick: () => this.run(act) }, label);
    this.video = button('export-video', 'Record a video', () => this.toggleVideo());
    this.note = h('p', { class: 'quiet', test: 'export-note', role: 'status' });
    this.problem = h('div', { class: 'error', 'data-error': 'export', role: 'alert' });
    const strideField = numberField('export-stride', 'One frame in how many', '1', (value) => (this.stride = value >= 1 ? Math.floor(value) : 1), { size: 3 });
    this.live = h('div', {}, h('h2', {}, 'Scene and actions'), h('div', { class: 'buttons' }, button('export-xml', 'Scene with changes (XML)', () => this.ask('xml')),
      button('export-actions', 'Actions of this run', () => this.ask('actions'))), h('p', { class: 'quiet' }, 'The actions repeat this run to the bit: stroma run SCENE --replay FILE.'));
    body.append(h('h2', {}, 'Picture and video'), h('div', { class: 'buttons' }, button('export-png', 'Picture (PNG)', () => this.png()), this.video),
      h('h2', {}, 'One page that replays'), row('One frame in', strideField), h('div', { class: 'buttons' }, button('export-html', 'Page (HTML)', () => this.html())),
      h('p', { class: 'quiet' }, 'It holds the frames seen so far and opens without a server. With a cut on, it can be cut too.'),
      this.live, h('h2', {}, 'Numbers'), h('div', { class: 'buttons' }, button('export-csv', 'Plotted values (CSV)', () => parts.panels.tabs.get('plots').panel.save())), this.note, this.problem);
    for (const kind of ['xml', 'actions'])
      this.store.on(kind, (/** @type {any} */ message) => {
        for (const { name, text } of [message, ...(message.included ?? [])]) // changed files that the scene includes
          download(new Blob([text], { type: kind === 'xml' ? 'application/xml' : 'text/plain' }), name);
      });
    this.store.on('scene', () => (this.live.hidden = this.store.scene.mode !== 'live' || !parts.commands.connection));
    this.store.on('arrived', (/** @type {any} */ packet) => waitFor?.(packet));
    this.stage.afterDraw.push(() => this.recorder && this.compose(this.videoCanvas));
  }

  get name() {
    return (this.store.scene?.name ?? 'scene').replace(/\.[^.]*$/, '');
  }

  /** @param {() => any} act */
  async run(act) {
    this.problem.textContent = '';
    this.note.textContent = '';
    try {
      await act();
    } catch (problem) {
      this.problem.textContent = /** @type {Error} */ (problem).message;
    }
  }

  /** @param {string} what */
  async ask(what) {
    const reply = await this.connection.ask({ do: what });
    if (!reply.ok) throw new Error(reply.message);
    if (reply.message) this.note.textContent = reply.message;
  }

  /** The picture with legend and forces, on a plain canvas. @param {HTMLCanvasElement} target */
  compose(target) {
    const { canvas } = this.stage;
    const scale = canvas.width / canvas.clientWidth;
    const context = /** @type {CanvasRenderingContext2D} */ (target.getContext('2d'));
    context.drawImage(canvas, 0, 0, target.width, target.height);
    /** @type {any} */ (this).legend.draw(context, target.width, target.height, scale);
    /** @type {any} */ (this).hint.draw(context, scale);
    const style = getComputedStyle(document.documentElement);
    const bounds = canvas.getBoundingClientRect();
    context.save();
    context.scale(scale, scale);
    context.font = '600 13px system-ui, sans-serif';
    context.textBaseline = 'middle';
    for (const label of /** @type {any} */ (this).hands.labels.values()) {
      if (label.hidden) continue;
      const { x, y } = this.stage.toScreen(label.at);
      const [left, top] = [x - bounds.left + 12, y - bounds.top - 26];
      context.fillStyle = style.getPropertyValue('--panel');
      context.beginPath();
      context.roundRect(left, top, context.measureText(label.textContent).width + 14, 20, 9);
      context.fill();
      context.fillStyle = style.getPropertyValue('--text');
      context.fillText(label.textContent, left + 7, top + 10);
    }
    context.restore();
  }

  plainCanvas() {
    const target = document.createElement('canvas');
    target.width = this.stage.canvas.width - (this.stage.canvas.width % 2); // video codecs want even numbers
    target.height = this.stage.canvas.height - (this.stage.canvas.height % 2);
    return target;
  }

  async png() {
    const target = this.plainCanvas();
    this.stage.draw(); // the canvas is empty after it was shown
    this.compose(target);
    const blob = await new Promise((resolve) => target.toBlob(resolve, 'image/png'));
    if (!blob) throw new Error('The browser could not write the picture.');
    download(/** @type {any} */ (blob), `${this.name}.png`);
  }

  toggleVideo() {
    if (this.recorder) return this.recorder.stop();
    const type = typeof MediaRecorder === 'undefined' ? undefined : VIDEO.find((t) => MediaRecorder.isTypeSupported(t));
    if (!type) throw new Error('This browser records no video; Firefox and Chromium do.');
    this.videoCanvas = this.plainCanvas();
    const recorder = new MediaRecorder(this.videoCanvas.captureStream(60), { mimeType: type, videoBitsPerSecond: 8e6 });
    /** @type {Blob[]} */
    const pieces = [];
    recorder.ondataavailable = (event) => event.data.size && pieces.push(event.data);
    recorder.onstop = () => {
      this.recorder = null;
      this.video.textContent = 'Record a video';
      this.video.classList.remove('main');
      if (pieces.length) download(new Blob(pieces, { type }), `${this.name}.${type.includes('mp4') ? 'mp4' : 'webm'}`);
      else this.problem.textContent = 'The video has no picture: nothing was drawn while it was recorded.';
    };
    this.recorder = recorder;
    recorder.start(1000);
    this.video.textContent = 'Stop and save the video';
    this.video.classList.add('main');
    this.stage.requestDraw();
  }

  async html() {
    this.note.textContent = 'Writing the page.';
    const { camera, controls } = this.stage;
    const { colour, map, range, low, high, exaggeration, wireframe, loads, contacts, obstacles, cut } = this.store.view;
    const view = { colour, map, range, low, high, exaggeration, wireframe, loads, contacts, obstacles, cut,
      camera: { position: camera.position.toArray(), target: controls.target.toArray() } };
    const { frames, count } = this.frames();
    const text = await exportedPage(this.store, await ownText(), view, frames, count, this.stride);
    download(new Blob([text], { type: 'text/html' }), `${this.name}.html`);
    this.note.textContent = `The page has ${(text.length / 1e6).toFixed(1)} MB and ${count} frames.`;
  }

  /** The frames to write: the kept ones, or all instants of a recording. */
  frames() {
    const { timeline, history, store, commands } = /** @type {any} */ (this);
    if (timeline.mode === 'recording') {
      const count = Math.ceil(timeline.count / this.stride);
      const { stride } = this;
      return { count, frames: (async function* () {
        for (let k = 0; k < count; k++) {
          const came = new Promise((resolve, reject) => {
            const timeout = setTimeout(() => reject(new Error(`Frame ${k * stride} of the recording did not come within 10 s.`)), 10000);
            waitFor = (packet) => packet.header.index === k * stride && (clearTimeout(timeout), resolve(packet));
          });
          commands.send({ do: 'seek', index: k * stride });
          yield await came;
        }
        waitFor = null;
      })() };
    }
    const frames = history.frames.filter((/** @type {any} */ _, /** @type {number} */ i) => i % this.stride === 0);
    return { frames, count: frames.length };
  }
}

/** @type {((packet: any) => void) | null} */
let waitFor = null;

/** The text of this page itself. @returns {Promise<{html: string, css: string, js: string}>} */
async function ownText() {
  if (document.getElementById('stroma-recording')) {
    const scripts = document.querySelectorAll('script:not([type])');
    return { html, css: document.querySelector('style')?.textContent?.trimStart() ?? '', js: scripts[scripts.length - 1].textContent?.trimStart() ?? '' };
  }
  const read = async (/** @type {string} */ name) => {
    const answer = await fetch(name);
    if (!answer.ok) throw new Error(`The server did not give ${name} (${answer.status}).`);
    return answer.text();
  };
  return { html, css: await read('app.css'), js: await read('app.js') };
}
