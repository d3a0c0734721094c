// SPDX-License-Identifier: LGPL-2.1-or-later
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { fromBase64, gunzip, readPacket, splitPackets, writePacket } from '../src/messages.js';
import { History } from '../src/history.js';
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

/** A line of three edges whose first node goes: the last one takes its number. */
function changingPackets() {
  const scene = (generation, nodes, more, arrays) => writePacket({
    is: 'scene', generation, ...more, client: 0, build: 'b', name: 'line.xml', mode: 'recording', dt: 0.1, gravity: [0, 0, 0],
    bodies: [{ path: '/a/dofs', node: '/a', name: 'a', nodes, surface: nodes, cells: { tetrahedra: 0, hexahedra: 0 }, interactive: false, why: '', frames: [], size: 1 }], fields: [],
  }, { '0.triangles': new Int32Array(0), '0.owner': new Int32Array(0), '0.points': new Int32Array(0), '0.springs': new Int32Array(0), ...arrays });
  const held = (generation, nodes) => writePacket({ is: 'held', generation }, { '0.held': Int32Array.from(nodes), '0.guided': new Int32Array(0) });
  const shown = (generation, step, x) => writePacket({ is: 'frame', generation, frame: step, step, time: 0.1 * step, nodes: 'all', format: 'f32', applied: {}, hands: [], values: {} },
    { '0.x': Float32Array.from(x.flatMap((c) => [c, 0, step])) });
  return [
    scene(1, 4, { view: { colour: 'displacement' } }, { '0.node': Int32Array.of(0, 1, 2, 3), '0.rest': Float32Array.of(0, 0, 0, 1, 0, 0, 2, 0, 0, 3, 0, 0), '0.edges': Int32Array.of(0, 1, 1, 2, 2, 3) }),
    held(1, [0, 3]), shown(1, 1, [0, 1, 2, 3]), shown(1, 2, [0, 1, 2, 3]),
    scene(2, 3, { follows: 1 }, { '0.node': Int32Array.of(0, 1, 2), '0.rest': Float32Array.of(3, 0, 0, 1, 0, 0, 2, 0, 0), '0.edges': Int32Array.of(1, 2, 2, 0), '0.before': Int32Array.of(3, 1, 2) }),
    held(2, [0]), shown(2, 3, [3, 1, 2]), shown(2, 4, [3, 1, 2]),
  ];
}

/** As exported.js fills a page. */
function played(packets) {
  const store = new Store();
  store.exported = true;
  const history = new History(store, Infinity);
  for (const bytes of packets) store.receivePacket(readPacket(bytes));
  const seek = (index) => {
    store.following = false;
    store.show(history.frames[index], (name) => history.lastWith(index, name));
  };
  return { store, history, seek };
}

test('frames of an exported page have the mesh of their time, back and forth', () => {
  const { store, history, seek } = played(changingPackets());
  assert.deepEqual(history.frames.map(({ header }) => header.step), [1, 2, 3, 4]);
  for (const index of [3, 0, 2, 1, 1, 3, 0]) {
    seek(index);
    const [body] = store.bodies;
    assert.equal(history.frames.length, 4, 'no frame is forgotten');
    assert.equal(body.count, index < 2 ? 4 : 3);
    assert.deepEqual([...body.x].filter((_, i) => i % 3 === 0), index < 2 ? [0, 1, 2, 3] : [3, 1, 2]);
    assert.ok([...body.x].filter((_, i) => i % 3 === 2).every((z) => z === index + 1));
    assert.deepEqual([...body.held], index < 2 ? [0, 3] : [0]);
    assert.equal(body.edges.length, index < 2 ? 6 : 4);
  }
});

test('a node of such a page keeps its place in each mesh, or has none', () => {
  const { store, history, seek } = played(changingPackets());
  seek(0);
  assert.deepEqual([3, 1, 0].map((node) => store.nodeIn(history.frames[3], 0, node)), [0, 1, -1]);
  let moved = null;
  store.on('scene', () => (moved = [3, 0].map((node) => store.changed && store.nodeNow({ body: 0, node }))));
  seek(3);
  assert.deepEqual(moved, [{ body: 0, node: 0 }, null]);
  seek(1);
  assert.deepEqual(moved, [null, { body: 0, node: 3 }], 'node 0 of the small mesh is node 3 of the first; there is no node 3');
});

test('such a page is exported again with all its meshes', async () => {
  const { store, history, seek } = played(changingPackets());
  seek(2);
  const text = await exportedPage(store, PAGE, { colour: 'displacement' }, history.frames, 4, 1);
  const { packets } = JSON.parse(text.match(/id="stroma-recording">(.*?)<\/script>/)[1]);
  const again = [];
  for (const part of packets) again.push(...splitPackets(await gunzip(fromBase64(part))));
  assert.deepEqual(again.map((bytes) => readPacket(bytes).header.is), ['scene', 'held', 'frame', 'frame', 'scene', 'held', 'frame', 'frame']);
  const copy = played(again);
  assert.equal(copy.history.frames[0].scene.packet.header.view.colour, 'displacement');
  for (const index of [3, 0]) {
    copy.seek(index);
    assert.equal(copy.store.bodies[0].count, index < 2 ? 4 : 3);
  }
  assert.equal(copy.store.nodeIn(copy.history.frames[3], 0, 3), 0);
  assert.equal(store.shown, history.frames[2], 'what was shown is shown again');
  assert.equal(store.bodies[0].count, 3);
  seek(0);
  await exportedPage(store, PAGE, {}, history.frames, 4, 1);
  assert.equal(store.shown, history.frames[0]);
  assert.equal(store.bodies[0].count, 4, 'in its own mesh');
});
