// SPDX-License-Identifier: LGPL-2.1-or-later
// The page without a server: it holds its recording itself.
import { fromBase64, gunzip, readPacket, splitPackets } from './messages.js';

/** The packets that the page holds, or null when it belongs to a server. @returns {string[] | null} */
export function exportedRecording() {
  const element = document.getElementById('stroma-recording');
  return element ? JSON.parse(element.textContent ?? '{}').packets ?? [] : null;
}

/**
 * @param {string[]} parts base64 of gzip of packets @param {import('./store.js').Store} store @param {import('./history.js').History} history
 * @param {import('./timeline.js').Timeline} timeline @param {import('./banner.js').Banner} banner
 */
export async function playExported(parts, store, history, timeline, banner) {
  try {
    history.limit = Infinity; // they are in memory anyway
    for (const part of parts)
      for (const bytes of splitPackets(await gunzip(fromBase64(part)))) {
        const packet = readPacket(bytes);
        if (packet.header.is === 'scene') store.view.colour = packet.header.view?.colour ?? store.view.colour;
        store.receivePacket(packet);
      }
    if (history.frames.length === 0) throw new Error('it has no frames');
    store.setConnection('recording', '');
    store.receiveText({ is: 'ready' });
    timeline.seek(0);
    timeline.update();
    if (history.frames.length > 1) timeline.toggle();
  } catch (problem) {
    banner.noteShown = true;
    banner.show(`The recording in this page could not be read: ${/** @type {Error} */ (problem).message}.`, 'bad');
  }
}
