// SPDX-License-Identifier: LGPL-2.1-or-later
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { fromBase64, gunzip, readPacket, splitPackets, writePacket } from '../src/messages.js';
import { exportedPage, framePacket, openingPackets } from '../src/recording.js';
import { Store } from '../src/store.js';

// Two tetrahedra with a common face; node 4 stands for an inner node that the surface does not use.
const REST = Float32Array.of(0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0.2, 0.2, 0.2);
const PAGE = { html: '<link rel="stylesheet" href="app.css"><script src="app.js"></script>', css: 'p{}', js: 'let text = "</script>";' };

function scene() {
  const store = new Store();
  store.receivePacket(readPacket(writePacket({
    is: 'scene', generation: 1, client: 3, build: 'b', name: 'two.xml', mode: 'live', dt: 0.1, gravity: [0, 0, 0],
    bodies: [{ path: '/a/dofs', node: '/a', name: 'a', nodes: 5, surface: 4, cells: { tetrahedra: 2, hexahedra: 0 }, interactive: true, why: '', frames: [], size: 1 }],
    fields: [{ id: 1, body: 0, name: 'speed', on: 'nodes', unit: 'm/s' }, { id: 2, body: 0, name: 'stress', on: 'cells', unit: 'Pa' }],
  }, { '0.node': Int32Array.of(4, 3, 2, 1, 0), '0.rest': REST, '0.triangles': Int32Array.of(0, 2, 1, 0, 1, 3, 1, 2, 3), '0.owner': Int32Array.of(0, 1, 1),
    '0.edges': Int32Array.of(0, 1), '0.points': new Int32Array(0), '0.springs': Int32Array.of(0, 1, 0, 4) })));
  store.receivePacket(readPacket(writePacket({ is: 'held', generation: 1 }, { '0.held': Int32Array.of(2, 4), '0.guided': new Int32Array(0) })));
  store.receivePacket(readPacket(writePacket({ is: 'cells', generation: 1 }, { '0.tetrahedra': Int32Array.of(0, 1, 2, 4, 1, 2, 3, 4), '0.hexahedra': new Int32Array(0) })));
  return store;
}

const frame = (step) => readPacket(writePacket({ is: 'frame', generation: 1, frame: step, step, time: 0.1 * step, nodes: 'all', format: 'f32', applied: {}, hands: [], values: {} },
  { '0.x': REST.map((c) => c + 0.01 * step), f1: Float32Array.of(1, 2, 3, 4, 5), f2: Float32Array.of(10, 20) }));

test('without a cut only the surface is written', () => {
  const store = scene();
  store.view.colour = 'stress|cells|Pa';
  const [opening, held] = openingPackets(store, {}).map(readPacket);
  assert.equal(opening.header.bodies[0].nodes, 4);
  assert.deepEqual(opening.header.fields.map((field) => field.id), [2]);
  assert.deepEqual(opening.arrays['0.springs'], Int32Array.of(0, 1));
  assert.deepEqual(held.arrays['0.held'], Int32Array.of(2));
  const { header, arrays } = readPacket(framePacket(store, frame(3), 0));
  assert.equal(header.nodes, 'surface');
  assert.equal(arrays['0.x'].length, 12);
  assert.deepEqual(arrays.f2, Float32Array.of(10, 20, 20), 'one value for each triangle');
  assert.equal(arrays.f1, undefined);
});

test('with a cut the inside is written too', () => {
  const store = scene();
  store.view.colour = 'speed|nodes|m/s';
  store.setCut({ on: true });
  const packets = openingPackets(store, {}).map(readPacket);
  assert.deepEqual(packets.map(({ header }) => header.is), ['scene', 'held', 'cells']);
  const { header, arrays } = readPacket(framePacket(store, frame(3), 0));
  assert.equal(header.nodes, 'all');
  assert.equal(arrays['0.x'].length, 15);
  assert.deepEqual(arrays.f1, Float32Array.of(1, 2, 3, 4, 5));
});

test('an exported page is read back by the page', async () => {
  const text = await exportedPage(scene(), PAGE, { colour: 'displacement' }, [1, 2, 3].map(frame), 3, 1);
  assert.equal(text.match(/<\/script>/g).length, 2, 'nothing ends a script early');
  assert.ok(text.startsWith('<style>'));
  const { packets } = JSON.parse(text.match(/id="stroma-recording">(.*?)<\/script>/)[1]);
  const again = new Store();
  let frames = 0;
  again.on('frame', () => frames++);
  for (const part of packets) for (const bytes of splitPackets(await gunzip(fromBase64(part)))) again.receivePacket(readPacket(bytes));
  assert.equal(frames, 3);
  assert.equal(again.scene.view.colour, 'displacement');
  for (let i = 0; i < 12; i++) assert.ok(Math.abs(again.bodies[0].x[i] - REST[i] - 0.03) < 1e-5);
});

test('what would be too large is refused with the stride that fits', async () => {
  await assert.rejects(exportedPage(scene(), PAGE, {}, [], 0, 1), /no frames/);
  const large = { ...PAGE, js: ' '.repeat(60e6) };
  await assert.rejects(exportedPage(scene(), large, {}, [frame(1)], 1, 1), /about 60 MB; at most 50 MB are written. Take one frame in 2\./);
});

test('cell values that came for all cells are told from those for triangles', () => {
  const store = scene();
  store.receivePacket(frame(1));
  assert.ok(store.valuesOfAll.has(2));
  assert.ok(store.bodies[0].inside);
  store.receivePacket(readPacket(writePacket({ is: 'frame', generation: 1, frame: 9, step: 9, time: 1, nodes: 'surface', format: 'f32' }, { '0.x': REST.subarray(0, 12), f2: Float32Array.of(1, 2, 3) })));
  assert.ok(!store.valuesOfAll.has(2));
  assert.ok(!store.bodies[0].inside);
  store.receivePacket(readPacket(writePacket({ is: 'frame', generation: 1, frame: 10, step: 10, time: 1.1, nodes: 'surface', format: 'f32' }, { '0.x': REST.subarray(0, 12) })));
  assert.deepEqual(store.values.get(2), Float32Array.of(1, 2, 3), 'the last values are kept');
});
