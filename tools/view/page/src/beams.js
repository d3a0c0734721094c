// SPDX-License-Identifier: LGPL-2.1-or-later
// The curve of a beam between two rigid frames: a cubic that leaves each end along the direction in which the beam is fixed to it.

/** A vector turned by a unit quaternion x y z w. @param {number[]} v @param {number[]} q @returns {number[]} */
export function turned([x, y, z], [a, b, c, w]) {
  const tx = 2 * (b * z - c * y), ty = 2 * (c * x - a * z), tz = 2 * (a * y - b * x);
  return [x + w * tx + b * tz - c * ty, y + w * ty + c * tx - a * tz, z + w * tz + a * ty - b * tx];
}

/**
 * @param {number[]} beam nodes and frames of both ends, radius, chord at rest in the axes of both ends
 * @param {number[]} a place of the first end @param {number[]} b @param {number[]} turnA orientation @param {number[]} turnB
 * @param {number} pieces
 * @returns {number[][]} pieces + 1 places
 */
export function beamCurve(beam, a, b, turnA, turnB, pieces) {
  const from = turned(beam.slice(5, 8), turnA);
  const to = turned(beam.slice(8, 11), turnB);
  return Array.from({ length: pieces + 1 }, (_, i) => {
    const s = i / pieces;
    const square = s * s;
    const cube = square * s;
    return [0, 1, 2].map((c) => (2 * cube - 3 * square + 1) * a[c] + (cube - 2 * square + s) * from[c] + (3 * square - 2 * cube) * b[c] + (cube - square) * to[c]);
  });
}

/**
 * The rotation vector of the shortest turn that takes the direction `arm` to `to`, after the orientation `start`.
 * @param {number[]} start unit quaternion x y z w @param {number[]} arm @param {number[]} to
 */
export function turnTowards(start, arm, to) {
  const size = Math.hypot(...arm) * Math.hypot(...to);
  if (!(size > 0)) return rotationVector(start);
  const w = 1 + (arm[0] * to[0] + arm[1] * to[1] + arm[2] * to[2]) / size;
  const by = [(arm[1] * to[2] - arm[2] * to[1]) / size, (arm[2] * to[0] - arm[0] * to[2]) / size, (arm[0] * to[1] - arm[1] * to[0]) / size, w];
  const length = Math.hypot(...by);
  if (length < 1e-9) return rotationVector(start); // straight back: any axis would do, none is meant
  const [a, b, c, d] = by.map((n) => n / length);
  const [x, y, z, v] = start;
  return rotationVector([d * x + a * v + b * z - c * y, d * y - a * z + b * v + c * x, d * z + a * y - b * x + c * v, d * v - a * x - b * y - c * z]);
}

/** Axis times angle of a unit quaternion, the shorter way. @param {number[]} q */
export function rotationVector(q) {
  const sine = Math.hypot(q[0], q[1], q[2]);
  if (sine === 0) return [0, 0, 0];
  const factor = (Math.sign(q[3] || 1) * 2 * Math.atan2(sine, Math.abs(q[3]))) / sine;
  return [factor * q[0], factor * q[1], factor * q[2]];
}
