// SPDX-License-Identifier: LGPL-2.1-or-later
// The page without a server: it holds its recording itself.
import { fromBase64, gunzip, readPacket, splitPackets } from './messages.js';

/** The packets that the page holds, or null when it belongs to a server. @returns {string[] | null} */
export function exportedRecording() {
  const element = document.getElementById('stroma-recording');
  return element ? JSON.parse(element.textContent ?? '{}').packets ?? [] : null;
}

/**
 * @param {string[]} packets base64 of gzip of packets
 * @param {any} parts of the page
 */
export async function playExported(packets, { store, stage, history, timeline, banner }) {
  try {
    store.exported = true;
    history.limit = Infinity; // they are in memory anyway
    for (const part of packets)
      for (const bytes of splitPackets(await gunzip(fromBase64(part)))) {
        const packet = readPacket(bytes);
        store.receivePacket(packet);
      }
    if (history.frames.length === 0) throw new Error('it has no frames');
    store.setConnection('recording', '');
    store.receiveText({ is: 'ready' });
    startAsExported(history.frames[0].scene.packet.header.view, store, stage);
    timeline.seek(0);
    timeline.update();
    if (history.frames.length > 1) timeline.toggle();
  } catch (problem) {
    banner.noteShown = true;
    banner.show(`The recording in this page could not be read: ${/** @type {Error} */ (problem).message}.`, 'bad');
  }
}

/** The choices and the camera of the page that exported. @param {any} chosen @param {any} store @param {any} stage */
function startAsExported(chosen, store, stage) {
  const { camera, ...view } = chosen ?? {};
  store.setView(view);
  if (!camera) return;
  stage.camera.position.fromArray(camera.position);
  stage.controls.target.fromArray(camera.target);
  stage.controls.update();
}
