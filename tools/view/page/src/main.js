// SPDX-License-Identifier: LGPL-2.1-or-later
// The page of `stroma view`: puts its parts together and tells the server what is wanted.
import { Bar } from './bar.js';
import { Banner } from './banner.js';
import { Commands } from './commands.js';
import { Connection } from './connection.js';
import { History } from './history.js';
import { Hands } from './hands.js';
import { Legend } from './legend.js';
import { Panels } from './panels.js';
import { Stage } from './stage.js';
import { Store } from './store.js';
import { Timeline } from './timeline.js';
import { Tree } from './tree.js';
import { Wants } from './wants.js';
import { exportedRecording, playExported } from './exported.js';
import { followTheme } from './theme.js';
import { listenToKeys } from './keys.js';
import { pick } from './picking.js';
import { showAxes } from './axes.js';
import { Hint } from './hint.js';
import { showPicked } from './picked.js';

function start() {
  const element = (/** @type {string} */ id) => /** @type {HTMLElement} */ (document.getElementById(id));
  const store = new Store();
  followTheme(store);
  const recording = exportedRecording();
  const connection = recording ? null : new Connection(store);
  const commands = new Commands(connection, store);
  const banner = new Banner(element('banner'), store, commands);
  let stage;
  try {
    stage = new Stage(/** @type {HTMLCanvasElement} */ (element('canvas')), store);
  } catch (problem) {
    banner.show(`This browser cannot draw in three dimensions (WebGL 2): ${/** @type {Error} */ (problem).message}`, 'bad');
    throw problem;
  }
  const hands = new Hands(stage, store, commands);
  const history = new History(store);
  const wants = new Wants(store, stage, connection);
  const legend = new Legend(/** @type {HTMLElement} */ (element('picture')), store, stage);
  const timeline = new Timeline(element('foot'), store, stage, history, commands);
  const hint = new Hint(element('picture'), { store, stage, hands });
  const parts = { store, stage, hands, history, wants, legend, hint, timeline, commands, connection };
  const panels = new Panels(element('right'), parts);
  const tree = new Tree(element('left'), store, stage);
  const bar = new Bar(element('bar'), parts, { left: tree.element, right: panels.element });
  showAxes(element('picture'), stage);
  showPicked(element('picture'), { ...parts, panels });
  listenToKeys({ ...parts, panels, bar });

  stage.afterDraw.push((arrived) => {
    for (const frame of arrived) connection?.send({ do: 'drawn', frame });
  });
  // What is not drawn is answered too: the server would wait for it.
  store.on('dropped', (frame) => connection?.send({ do: 'drawn', frame }));
  // A page that is left says so; one that comes back as it was begins anew.
  window.addEventListener('pagehide', () => connection?.leave());
  window.addEventListener('pageshow', (event) => event.persisted && connection?.open());
  /** @type {any} */ (window).stroma = {
    store, stage, hands, history, panels, timeline, commands, connection,
    get ready() { return store.ready && stage.frameDrawn >= 0; },
    get frameDrawn() { return stage.frameDrawn; },
    get lastDelay() { return hands.lastDelay; },
    get delays() { return hands.delays; },
    positions: (/** @type {number} */ b) => store.bodies[b].x.slice(0, 3 * (store.bodies[b].inside ? store.bodies[b].count : store.bodies[b].surface)),
    pick: (/** @type {number} */ x, /** @type {number} */ y) => pick(stage, x, y),
    screenOf: (/** @type {number} */ b, /** @type {number} */ node) => stage.toScreen(stage.views[b].drawnAt(node)),
  };
  if (recording) playExported(recording, { store, stage, history, timeline, banner });
  else connection?.open();
}

if (document.readyState === 'loading') document.addEventListener('DOMContentLoaded', start);
else start();
