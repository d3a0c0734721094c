// SPDX-License-Identifier: LGPL-2.1-or-later
// Makes the packets of an exported page from kept frames: 16-bit positions, and without what only a section needs.
import { gzip, joinPackets, quantise, toBase64, writePacket } from './messages.js';

export const LARGEST = 50e6; // bytes of an exported page
const PIECE = 16e6; // bytes compressed at once

/**
 * @param {import('./store.js').Store} store
 * @param {any} view choices that the exported page starts with
 * @param {number} [generation] of the scene
 * @param {{scene: any, counts: number[]} | null} [before] the scene whose meshes have changed to these, and how many nodes of each body are written
 * @returns {ArrayBuffer[]} the packets before the frames
 */
export function openingPackets(store, view, generation = 1, before = null) {
  const inside = withInside(store);
  /** @type {Record<string, any>} */
  const arrays = {};
  const held = /** @type {Record<string, any>} */ ({});
  const cells = /** @type {Record<string, any>} */ ({});
  const bodies = store.bodies.map((body, b) => {
    const count = inside ? body.count : body.surface;
    const known = (/** @type {Int32Array} */ nodes, /** @type {number} */ group) => {
      const kept = [];
      for (let i = 0; i < nodes.length; i += group)
        if (nodes.subarray(i, i + group).every((n) => n < count)) kept.push(...nodes.subarray(i, i + group));
      return Int32Array.from(kept);
    };
    Object.assign(arrays, {
      [`${b}.node`]: body.sceneNode.subarray(0, count), [`${b}.rest`]: body.rest.subarray(0, 3 * count), [`${b}.triangles`]: body.triangles,
      [`${b}.owner`]: body.owner, [`${b}.edges`]: body.edges, [`${b}.points`]: body.points, [`${b}.springs`]: known(body.springs, 2),
    });
    if (before) arrays[`${b}.before`] = store.numbersIn(before.scene, store.sceneShown, b).subarray(0, count).map((n) => (n < before.counts[b] ? n : -1));
    held[`${b}.held`] = known(body.held, 1);
    held[`${b}.guided`] = known(body.guided, 1);
    if (inside && body.tetrahedra) cells[`${b}.tetrahedra`] = body.tetrahedra;
    if (inside && body.hexahedra) cells[`${b}.hexahedra`] = body.hexahedra;
    return {
      path: body.path, node: body.node, name: body.name, nodes: count, surface: body.surface, cells: inside ? body.cells : { tetrahedra: 0, hexahedra: 0 },
      interactive: false, why: 'This page replays a recording.', frames: body.frames.map(([place]) => [place]), beams: body.beams, balls: body.balls, axis: body.axis, size: body.size,
    };
  });
  const links = [];
  const kinds = [];
  const all = store.links ?? new Int32Array(0);
  for (let k = 0; k < all.length; k += 4)
    if (all[k + 1] < bodies[all[k]].nodes && all[k + 3] < bodies[all[k + 2]].nodes) {
      links.push(...all.subarray(k, k + 4));
      kinds.push(store.linkKinds[k / 4]);
    }
  Object.assign(arrays, { links: Int32Array.from(links), link_kind: Uint8Array.from(kinds) });
  store.obstacles.forEach((obstacle, k) => Object.assign(arrays, { [`o${k}.points`]: obstacle.points, [`o${k}.triangles`]: obstacle.triangles }));
  const obstacles = store.obstacles.map(({ path, name, solid }) => ({ path, name, solid, movable: false }));
  const { name, dt, gravity, build } = store.scene;
  const fields = [...store.chosenFields().values()];
  const follows = before ? { follows: generation - 1 } : {};
  const packets = [writePacket({ is: 'scene', generation, ...follows, client: 0, build, name, mode: 'recording', dt, gravity, bodies, fields, obstacles, contacts: store.contacts, view }, arrays),
    writePacket({ is: 'held', generation }, held)];
  if (inside) packets.push(writePacket({ is: 'cells', generation }, cells));
  return packets;
}

/** Whether the page exported can cut: it can when it does now. @param {import('./store.js').Store} store */
const withInside = (store) => store.view.cut.on && store.bodies.some((body) => body.tetrahedra);

/**
 * @param {import('./store.js').Store} store @param {any} packet a frame as it came
 * @param {number} number of the frame
 * @param {number} [generation] of its scene
 */
export function framePacket(store, packet, number, generation = 1) {
  const { header, arrays } = packet;
  const inside = withInside(store);
  const whole = header.nodes === 'all';
  /** @type {Record<string, any>} */
  const out = {};
  const boxes = store.bodies.map((body, b) => {
    const x = arrays[`${b}.x`];
    const kept = inside || !whole ? x : x.subarray(0, 3 * body.surface);
    if (arrays[`${b}.load`] && store.view.loads) out[`${b}.load`] = arrays[`${b}.load`].subarray(0, kept.length);
    if (arrays[`${b}.turn`]) out[`${b}.turn`] = arrays[`${b}.turn`];
    const { values, box } = kept instanceof Uint16Array ? { values: kept, box: header.boxes[b] } : quantise(kept);
    out[`${b}.x`] = values;
    return box;
  });
  for (const field of store.chosenFields().values()) {
    const values = arrays[`f${field.id}`];
    if (!values) continue;
    const body = store.bodies[field.body];
    if (inside || !whole) out[`f${field.id}`] = values;
    else if (field.on === 'nodes') out[`f${field.id}`] = values.subarray(0, body.surface);
    else out[`f${field.id}`] = body.cells.tetrahedra + body.cells.hexahedra ? Float32Array.from(body.owner, (cell) => values[cell]) : values;
  }
  const contacts = header.contacts && store.view.contacts ? { contacts: header.contacts } : {};
  if (header.contacts && store.view.contacts)
    for (const name of Object.keys(arrays)) if (/^c\d+\./.test(name)) out[name] = arrays[name];
  return writePacket({ is: 'frame', generation, frame: number, step: header.step, time: header.time, run: header.run ?? 0, nodes: inside && whole ? 'all' : 'surface', format: 'u16',
    applied: {}, hands: header.hands ?? [], values: header.values ?? {}, boxes, ...(header.moved ? { moved: header.moved } : {}), ...contacts }, out);
}

/**
 * The text of one page that replays the frames; refuses what would be too large.
 * @param {import('./store.js').Store} store
 * @param {{html: string, css: string, js: string}} page
 * @param {any} view
 * @param {AsyncIterable<any> | Iterable<any>} frames
 * @param {number} count of the frames
 * @param {number} stride every how many frames of the run they are
 * @returns {Promise<string>}
 */
export async function exportedPage(store, page, view, frames, count, stride) {
  let generation = 0;
  /** The scene of the last frame. @type {{scene: any, counts: number[]} | null} */
  let last = null;
  /** @type {ArrayBuffer[]} */
  let pieces = [];
  let waiting = 0;
  /** @type {string[]} */
  const parts = [];
  let size = page.js.length + page.css.length + page.html.length;
  let number = 0;
  const pack = async () => {
    if (pieces.length === 0) return;
    const part = toBase64(await gzip(joinPackets(pieces)));
    parts.push(part);
    size += part.length;
    pieces = [];
    waiting = 0;
    if (size > LARGEST) {
      const whole = number > 0 ? (size / number) * count : size;
      throw new Error(number > 0 ? `The page would have about ${Math.round(whole / 1e6)} MB; at most 50 MB are written. Take one frame in ${Math.ceil((1.1 * stride * whole) / LARGEST)}.`
        : 'The mesh alone is larger than 50 MB; a single page cannot hold it.');
    }
  };
  const { shown } = store;
  try {
    for await (const packet of frames) {
      if (store.exported && packet.scene !== store.sceneShown) store.returnTo(packet.scene);
      if (last?.scene !== store.sceneShown) {
        const opening = openingPackets(store, last ? {} : view, ++generation, last);
        waiting += opening.reduce((sum, piece) => sum + piece.byteLength, 0);
        pieces.push(...opening);
        last = { scene: store.sceneShown, counts: store.bodies.map((body) => (withInside(store) ? body.count : body.surface)) };
      }
      pieces.push(framePacket(store, packet, number++, generation));
      waiting += pieces[pieces.length - 1].byteLength;
      if (waiting > PIECE) await pack();
    }
  } finally {
    if (shown && store.exported) store.show(shown);
  }
  await pack();
  if (number === 0) throw new Error('There are no frames to write yet. Run the scene first.');
  // What would end a script early in the page is written so that it does not.
  const safe = page.js.replaceAll('</script', '<\\/script');
  return page.html.replace('<link rel="stylesheet" href="app.css">', () => `<style>\n${page.css}</style>`)
    .replace('<script src="app.js"></script>', () => `<script type="application/json" id="stroma-recording">${JSON.stringify({ packets: parts })}</script>\n<script>\n${safe}</script>`);
}
