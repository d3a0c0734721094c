// SPDX-License-Identifier: LGPL-2.1-or-later
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { History } from '../src/history.js';
import { Series } from '../src/series.js';
import { Store } from '../src/store.js';
import { Timeline } from '../src/timeline.js';

const REST = Float32Array.of(0, 0, 0, 1, 0, 0, 0, 1, 0);

function scene(generation = 1, node = [0, 1, 2]) {
  return {
    header: { is: 'scene', generation, client: 3, build: 'b', name: 'one.xml', mode: 'live', dt: 0.1, gravity: [0, 0, 0],
      bodies: [{ path: '/a/dofs', node: '/a', name: 'a', nodes: 3, surface: 3, cells: { tetrahedra: 0, hexahedra: 0 }, interactive: true, why: '', frames: [], size: 1 }],
      fields: [{ id: 1, body: 0, name: 'speed', on: 'nodes', unit: 'm/s' }] },
    arrays: { '0.node': Int32Array.from(node), '0.rest': REST, '0.triangles': Int32Array.of(0, 1, 2), '0.owner': Int32Array.of(0), '0.edges': new Int32Array(0), '0.points': new Int32Array(0), '0.springs': new Int32Array(0) }, bytes: 100,
  };
}

const held = (...nodes) => ({ header: { is: 'held', generation: 1 }, arrays: { '0.held': Int32Array.from(nodes), '0.guided': new Int32Array(0) }, bytes: 10 });

function frame(step, more = {}, header = {}) {
  return { header: { is: 'frame', generation: 1, frame: step, step, time: 0.1 * step, nodes: 'surface', format: 'f32', ...header },
    arrays: { '0.x': REST.map((c) => c + step), ...more }, bytes: 100 };
}

function opened() {
  const store = new Store();
  const history = new History(store);
  store.receivePacket(scene());
  return { store, history, seek: (index) => Timeline.prototype.seek.call({ count: history.frames.length, slider: {}, mode: 'live', history, store, live: { setAttribute() {} } }, index) };
}

test('looking back shows the loads, fields and held nodes of then; the newest return', () => {
  const { store, seek } = opened();
  const body = () => store.bodies[0];
  store.receivePacket(held(0));
  const loads = [1, 2].map((force) => new Float32Array(9).fill(force));
  store.receivePacket(frame(0));
  store.receivePacket(frame(1, { '0.load': loads[0], f1: Float32Array.of(1, 1, 1) }));
  store.receivePacket(frame(2));
  store.receivePacket(held(1, 2));
  store.receivePacket(frame(3, { '0.load': loads[1], f1: Float32Array.of(3, 3, 3) }));
  store.receivePacket(frame(4));
  assert.equal(body().load, loads[1]);
  seek(2);
  assert.equal(body().load, loads[0], 'the loads of then');
  assert.equal(store.values.get(1)[0], 1);
  assert.deepEqual([...body().held], [0]);
  seek(0);
  assert.equal(body().load, null, 'before the first loads there are none');
  assert.equal(store.values.has(1), false);
  seek(3);
  assert.deepEqual([...body().held], [1, 2]);
  seek(1);
  store.receivePacket(held(2));
  store.receivePacket(frame(5));
  assert.deepEqual([...body().held], [0], 'news do not change the past');
  store.following = true;
  store.show(store.newest);
  assert.equal(body().load, loads[1], 'the newest loads, though the newest frame has none');
  assert.equal(store.values.get(1)[0], 3);
  assert.deepEqual([...body().held], [2]);
});

test('a frame that belongs to no known scene is reported, so that it is answered', () => {
  const store = new Store();
  const dropped = [];
  store.on('dropped', (number) => dropped.push(number));
  store.receivePacket(frame(7));
  store.receivePacket(scene(2));
  store.receivePacket(frame(8));
  store.receivePacket(frame(9, {}, { generation: 2 }));
  assert.deepEqual(dropped, [7, 8]);
  assert.equal(store.shown.header.frame, 9);
});

test('a reset is told by the number of the run', () => {
  const { store, history } = opened();
  for (let step = 0; step < 5; step++) store.receivePacket(frame(step, {}, { run: 0 }));
  store.following = false;
  store.receivePacket(frame(6, {}, { run: 1, frame: 6 })); // further than the run before had come
  assert.deepEqual(history.frames.map(({ header }) => header.run), [1]);
  assert.equal(store.shown.header.step, 6, 'there is nothing left to look back at');
  const series = new Series();
  series.add(0.1, { a: 1 }, 0);
  series.add(0.2, { a: 2 }, 0);
  series.add(0.3, { a: 3 }, 1);
  assert.deepEqual(series.times, [0.3]);
  series.add(0.4, { a: 4 }, 1);
  assert.deepEqual(series.column('a'), [3, 4]);
});

test('a scene sent again within a connection keeps what is shown; a new connection does not', () => {
  const { store, history } = opened();
  store.receivePacket(held(0));
  store.receivePacket(frame(4));
  store.bodies[0].visible = false;
  const again = scene(2);
  delete again.header.client; // it goes to all pages at once
  store.receivePacket(again);
  assert.ok(store.sameScene && store.continued);
  assert.equal(store.scene.client, 3);
  assert.equal(store.bodies[0].x[0], 4, 'the body stays where it was');
  assert.deepEqual([...store.bodies[0].held], [0]);
  assert.equal(store.bodies[0].visible, false);
  assert.equal(history.frames.length, 1);
  assert.equal(store.shown.header.frame, 4);
  store.restart();
  store.receivePacket(scene(2));
  assert.ok(store.sameScene && !store.continued);
  store.receivePacket(scene(3, [2, 1, 0]));
  assert.ok(!store.sameScene && !store.continued, 'nodes with other numbers are another scene');
  assert.equal(history.frames.length, 0);
});

test('doubts are those that the server told last', () => {
  const store = new Store();
  store.receiveText({ is: 'status', doubts: ['The step is large.'] });
  store.receiveText({ is: 'status', running: true });
  assert.deepEqual(store.status.doubts, ['The step is large.']);
  store.receiveText({ is: 'status', doubts: [] });
  assert.deepEqual(store.status.doubts, []);
});
