// SPDX-License-Identifier: LGPL-2.1-or-later
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { dequantise, fromBase64, gunzip, gzip, joinPackets, quantise, readPacket, splitPackets, toBase64, writePacket } from '../src/messages.js';

const ARRAYS = { x: Float32Array.of(1.5, -2, 3), short: Uint16Array.of(1, 65535, 7), node: Int32Array.of(-4, 5), kind: Uint8Array.of(9) };

test('a packet that is written is read back, in place', () => {
  const buffer = writePacket({ is: 'frame', name: 'é "quoted"' }, ARRAYS);
  const { header, arrays } = readPacket(buffer);
  assert.equal(header.name, 'é "quoted"');
  for (const [name, values] of Object.entries(ARRAYS)) {
    assert.deepEqual(arrays[name], values);
    assert.equal(arrays[name].buffer, buffer);
    assert.equal(arrays[name].byteOffset % 8, 0);
  }
});

test('a packet laid out by hand is read', () => {
  const text = '{"is":"frame","arrays":{"0.x":{"type":"f32","offset":8,"length":2}}}';
  const length = Math.ceil(text.length / 8) * 8;
  const bytes = new Uint8Array(8 + length + 16);
  bytes.set(new TextEncoder().encode('SRM1'));
  new DataView(bytes.buffer).setUint32(4, length, true);
  bytes.set(new TextEncoder().encode(text.padEnd(length)), 8);
  new DataView(bytes.buffer).setFloat32(8 + length + 12, 0.5, true);
  assert.deepEqual(readPacket(bytes.buffer).arrays['0.x'], Float32Array.of(0, 0.5));
});

test('damaged packets are refused with a sentence', () => {
  const good = writePacket({ is: 'frame' }, ARRAYS);
  assert.throws(() => readPacket(good.slice(0, 4)), /at least 8/);
  assert.throws(() => readPacket(good.slice(0, 40)), /only 32 follow/);
  assert.throws(() => readPacket(good.slice(0, good.byteLength - 8)), /ends after the packet/);
  const wrong = good.slice(0);
  new Uint8Array(wrong)[0] = 0;
  assert.throws(() => readPacket(wrong), /SRM1/);
});

test('packets are joined, compressed, written as text and read back', async () => {
  const packets = [writePacket({ is: 'scene' }, {}), writePacket({ is: 'frame' }, { x: new Float32Array(50000).fill(2) })];
  const text = toBase64(await gzip(joinPackets(packets)));
  assert.ok(text.length < 10000);
  const back = splitPackets(await gunzip(fromBase64(text)));
  assert.deepEqual(back, packets);
  assert.throws(() => splitPackets(joinPackets(packets).subarray(0, -1)), /middle of a packet/);
});

test('positions in 16 bits are right to a half step of their box', () => {
  const x = Float32Array.from({ length: 300 }, (_, i) => Math.sin(i) * (i % 3 === 1 ? 0 : 0.1));
  const { values, box } = quantise(x);
  const back = new Float32Array(x.length);
  dequantise(values, box, back);
  for (let i = 0; i < x.length; i++) assert.ok(Math.abs(back[i] - x[i]) <= 0.2 / 65535 / 2 + 1e-8, `${i}: ${back[i]} ${x[i]}`);
});
