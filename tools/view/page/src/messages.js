// SPDX-License-Identifier: LGPL-2.1-or-later
// Packets as the server sends them and as an exported page holds them: a JSON header and arrays that are read in place.

const MAGIC = 0x314d5253; // "SRM1" read as a little-endian number

/** @type {Record<string, any>} */
const KINDS = { f32: Float32Array, u16: Uint16Array, i32: Int32Array, u8: Uint8Array };

/**
 * @typedef {Float32Array | Uint16Array | Int32Array | Uint8Array} Values
 * @typedef {{header: any, arrays: Record<string, any>, bytes: number}} Packet
 */

/**
 * Reads one packet. The arrays share the memory of `buffer`.
 * @param {ArrayBuffer} buffer
 * @returns {Packet}
 */
export function readPacket(buffer) {
  if (buffer.byteLength < 8) throw new Error(`A packet has ${buffer.byteLength} bytes; at least 8 were expected.`);
  const view = new DataView(buffer);
  if (view.getUint32(0, true) !== MAGIC) throw new Error('A packet does not start with "SRM1".');
  const length = view.getUint32(4, true);
  if (length % 8 !== 0) throw new Error(`The header of a packet has ${length} bytes; a multiple of 8 was expected.`);
  const start = 8 + length;
  if (start > buffer.byteLength)
    throw new Error(`The header of a packet has ${length} bytes, but only ${buffer.byteLength - 8} follow.`);
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 8, length)));
  /** @type {Record<string, any>} */
  const arrays = {};
  for (const [name, entry] of Object.entries(header.arrays ?? {})) {
    const { type, offset, length: count } = /** @type {any} */ (entry);
    const Kind = KINDS[type];
    if (!Kind) throw new Error(`The array "${name}" has the type "${type}"; f32, u16, i32 or u8 was expected.`);
    if (offset % 8 !== 0) throw new Error(`The array "${name}" starts at ${offset}; a multiple of 8 was expected.`);
    if (start + offset + count * Kind.BYTES_PER_ELEMENT > buffer.byteLength)
      throw new Error(`The array "${name}" ends after the packet.`);
    arrays[name] = new Kind(buffer, start + offset, count);
  }
  return { header, arrays, bytes: buffer.byteLength };
}

/** @param {Values} values @returns {string} the name of the type in a header */
function typeOf(values) {
  for (const [name, Kind] of Object.entries(KINDS)) if (values instanceof Kind) return name;
  throw new Error('A packet holds arrays of f32, u16, i32 or u8 only.');
}

/**
 * Writes one packet; `header.arrays` is made here.
 * @param {any} header
 * @param {Record<string, Values>} arrays
 * @returns {ArrayBuffer}
 */
export function writePacket(header, arrays) {
  /** @type {Record<string, any>} */
  const table = {};
  let end = 0;
  for (const [name, values] of Object.entries(arrays)) {
    table[name] = { type: typeOf(values), offset: end, length: values.length };
    end += Math.ceil(values.byteLength / 8) * 8;
  }
  const text = new TextEncoder().encode(JSON.stringify({ ...header, arrays: table }));
  const length = Math.ceil(text.length / 8) * 8;
  const buffer = new ArrayBuffer(8 + length + end);
  const view = new DataView(buffer);
  view.setUint32(0, MAGIC, true);
  view.setUint32(4, length, true);
  const bytes = new Uint8Array(buffer);
  bytes.fill(32, 8, 8 + length);
  bytes.set(text, 8);
  for (const [name, values] of Object.entries(arrays))
    bytes.set(new Uint8Array(values.buffer, values.byteOffset, values.byteLength), 8 + length + table[name].offset);
  return buffer;
}

/**
 * Packets one after the other, each preceded by its length as u32.
 * @param {ArrayBuffer[]} packets
 * @returns {Uint8Array}
 */
export function joinPackets(packets) {
  const total = packets.reduce((sum, packet) => sum + 4 + packet.byteLength, 0);
  const bytes = new Uint8Array(total);
  const view = new DataView(bytes.buffer);
  let at = 0;
  for (const packet of packets) {
    view.setUint32(at, packet.byteLength, true);
    bytes.set(new Uint8Array(packet), at + 4);
    at += 4 + packet.byteLength;
  }
  return bytes;
}

/**
 * The reverse of joinPackets. Each packet is copied, so that its arrays are aligned.
 * @param {Uint8Array} bytes
 * @returns {ArrayBuffer[]}
 */
export function splitPackets(bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const packets = [];
  for (let at = 0; at < bytes.length; ) {
    const length = at + 4 <= bytes.length ? view.getUint32(at, true) : Infinity;
    if (at + 4 + length > bytes.length) throw new Error('The recording ends in the middle of a packet.');
    packets.push(/** @type {ArrayBuffer} */ (bytes.slice(at + 4, at + 4 + length).buffer));
    at += 4 + length;
  }
  return packets;
}

/**
 * Positions as 16-bit numbers in a box.
 * @param {Float32Array} x
 * @returns {{values: Uint16Array, box: number[]}}
 */
export function quantise(x) {
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < x.length; i++) {
    const c = i % 3;
    if (x[i] < low[c]) low[c] = x[i];
    if (x[i] > high[c]) high[c] = x[i];
  }
  for (let c = 0; c < 3; c++) if (!Number.isFinite(low[c]) || !Number.isFinite(high[c])) low[c] = high[c] = 0;
  const scale = low.map((l, c) => (high[c] > l ? 65535 / (high[c] - l) : 0));
  const values = new Uint16Array(x.length);
  for (let i = 0; i < x.length; i++) values[i] = Math.round((x[i] - low[i % 3]) * scale[i % 3]);
  return { values, box: [...low, ...high] };
}

/**
 * The reverse of quantise, into `out`.
 * @param {Uint16Array} values
 * @param {number[]} box
 * @param {Float32Array} out
 */
export function dequantise(values, box, out) {
  for (let c = 0; c < 3; c++) {
    const step = (box[3 + c] - box[c]) / 65535;
    for (let i = c; i < values.length; i += 3) out[i] = box[c] + values[i] * step;
  }
}

/** @param {Uint8Array} bytes @param {any} transform @returns {Promise<Uint8Array>} */
async function through(bytes, transform) {
  const stream = new Blob([/** @type {any} */ (bytes)]).stream().pipeThrough(transform);
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** @param {Uint8Array} bytes */
export const gzip = (bytes) => through(bytes, new CompressionStream('gzip'));
/** @param {Uint8Array} bytes */
export const gunzip = (bytes) => through(bytes, new DecompressionStream('gzip'));

/** @param {Uint8Array} bytes @returns {string} */
export function toBase64(bytes) {
  const parts = [];
  for (let at = 0; at < bytes.length; at += 0x6000) // a multiple of 3, so that the pieces join
    parts.push(btoa(String.fromCharCode(...bytes.subarray(at, at + 0x6000))));
  return parts.join('');
}

/** @param {string} text @returns {Uint8Array} */
export function fromBase64(text) {
  const binary = atob(text);
  const bytes = new Uint8Array(binary.length);
  for (let i = 0; i < binary.length; i++) bytes[i] = binary.charCodeAt(i);
  return bytes;
}
