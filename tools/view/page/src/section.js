// SPDX-License-Identifier: LGPL-2.1-or-later
// The section of cells by a plane: its polygons as triangles, and their outlines.

// Tetrahedra and hexahedra in VTK's order of nodes.
export const TETRAHEDRON_EDGES = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];
export const HEXAHEDRON_EDGES = [[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 6], [6, 7], [7, 4], [0, 4], [1, 5], [2, 6], [3, 7]];

/**
 * @typedef {object} Section what receives the section: a corner of a triangle, and an end of an outline
 * @property {(x: number, y: number, z: number, value: number) => void} corner
 * @property {(x: number, y: number, z: number) => void} end
 */

/**
 * Cuts cells of one kind by the plane of the points whose `distance` is zero.
 * @param {Int32Array} cells nodes of the cells, one after the other
 * @param {number[][]} edges of one cell
 * @param {Float32Array} x positions of the nodes
 * @param {Float32Array} distance signed distance of each node from the plane
 * @param {number[]} normal of the plane
 * @param {(edgeA: number, edgeB: number, t: number, cell: number) => number} valueAt value at a point of an edge
 * @param {Section} out
 */
export function cutCells(cells, edges, x, distance, normal, valueAt, out) {
  const corners = edges.length === 6 ? 4 : 8;
  const [u, v] = axesAcross(normal);
  const points = new Float64Array(3 * 12);
  const values = new Float64Array(12);
  const angles = new Float64Array(12);
  const order = new Int32Array(12);
  for (let start = 0, cell = 0; start < cells.length; start += corners, cell++) {
    let above = 0;
    for (let k = 0; k < corners; k++) if (distance[cells[start + k]] > 0) above++;
    if (above === 0 || above === corners) continue;
    let count = 0;
    for (const [p, q] of edges) {
      const a = cells[start + p];
      const b = cells[start + q];
      if (distance[a] > 0 === distance[b] > 0) continue;
      const t = distance[a] / (distance[a] - distance[b]);
      for (let c = 0; c < 3; c++) points[3 * count + c] = x[3 * a + c] + t * (x[3 * b + c] - x[3 * a + c]);
      values[count++] = valueAt(a, b, t, cell);
    }
    if (count < 3) continue;
    sortAround(points, count, u, v, angles, order);
    for (let k = 1; k + 1 < count; k++)
      for (const i of [order[0], order[k], order[k + 1]])
        out.corner(points[3 * i], points[3 * i + 1], points[3 * i + 2], values[i]);
    for (let k = 0; k < count; k++)
      for (const i of [order[k], order[(k + 1) % count]]) out.end(points[3 * i], points[3 * i + 1], points[3 * i + 2]);
  }
}

/** Two directions across `normal`. @param {number[]} normal */
function axesAcross(normal) {
  const other = Math.abs(normal[1]) < 0.9 * Math.hypot(...normal) ? [0, 1, 0] : [1, 0, 0];
  const u = cross(normal, other);
  return [u, cross(normal, u)];
}

/** @param {number[]} a @param {number[]} b */
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];

/**
 * The order of the points around their centre; cells are convex or nearly so.
 * @param {Float64Array} points @param {number} count @param {number[]} u @param {number[]} v
 * @param {Float64Array} angles @param {Int32Array} order
 */
function sortAround(points, count, u, v, angles, order) {
  let cx = 0, cy = 0, cz = 0;
  for (let i = 0; i < count; i++) {
    cx += points[3 * i] / count;
    cy += points[3 * i + 1] / count;
    cz += points[3 * i + 2] / count;
  }
  for (let i = 0; i < count; i++) {
    const dx = points[3 * i] - cx, dy = points[3 * i + 1] - cy, dz = points[3 * i + 2] - cz;
    const angle = Math.atan2(dx * v[0] + dy * v[1] + dz * v[2], dx * u[0] + dy * u[1] + dz * u[2]);
    let place = i;
    while (place > 0 && angles[place - 1] > angle) {
      angles[place] = angles[place - 1];
      order[place] = order[place - 1];
      place--;
    }
    angles[place] = angle;
    order[place] = i;
  }
}

/**
 * Signed distances of nodes from a plane.
 * @param {Float32Array} x @param {number[]} normal of length 1 @param {number} offset @param {Float32Array} out
 */
export function distances(x, normal, offset, out) {
  const [a, b, c] = normal;
  for (let i = 0, n = 0; n < out.length; n++, i += 3) out[n] = a * x[i] + b * x[i + 1] + c * x[i + 2] - offset;
}
