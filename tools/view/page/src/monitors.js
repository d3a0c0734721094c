// SPDX-License-Identifier: LGPL-2.1-or-later
// What a component of type Monitor watches, as nodes of the page.

/**
 * @param {{type?: string, path: string, attributes?: {name: string, value: string, long: boolean}[]}} component
 * @param {{index: number, node: string, path: string, sceneNode: Int32Array}[]} bodies
 * @returns {{body: number, nodes: number[], problem: string} | null} null for other components; a sentence when nothing can be plotted
 */
export function watchedByMonitor({ type, path, attributes = [] }, bodies) {
  if (type !== 'Monitor') return null;
  const of = (/** @type {string} */ name) => attributes.find((attribute) => attribute.name === name);
  const none = (/** @type {string} */ problem) => ({ body: -1, nodes: [], problem });
  const indices = of('indices');
  if (!indices || indices.long) return none(`It watches ${indices?.value ?? 'nodes'}, too many to plot.`);
  const node = path.replace(/\/[^/]*$/, '') || '/';
  // Without a link it is the state of its node, or of the nearest node above that has one.
  const link = of('mstate')?.value.replace(/^@/, '') ?? '';
  const above = bodies.filter((b) => b.node === node || b.node === '/' || node.startsWith(`${b.node}/`));
  const body = link.startsWith('/') ? bodies.find((b) => b.path === link)
    : link ? bodies.find((b) => b.node === node && b.path.endsWith(`/${link}`)) : above.sort((a, b) => b.node.length - a.node.length)[0];
  if (!body) return none('What it watches is not drawn and cannot be plotted.');
  const nodes = (indices.value.match(/\d+/g) ?? []).map((n) => body.sceneNode.indexOf(Number(n))).filter((n) => n >= 0);
  return nodes.length ? { body: body.index, nodes, problem: '' } : none('None of its nodes is drawn.');
}
