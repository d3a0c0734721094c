// SPDX-License-Identifier: LGPL-2.1-or-later
// Numbers as people read them.

/** @type {[number, string][]} */
const PREFIXES = [[1e9, 'G'], [1e6, 'M'], [1e3, 'k'], [1, ''], [1e-3, 'm'], [1e-6, 'µ'], [1e-9, 'n']];
// The unit may have a prefix of its own, as kPa of a scene in mm, kg, s. Square metres and kilograms take none.
const PREFIXED = /^([GMkcmuµn]?)(Pa|N|J|W|m|s|Hz|m\/s|N\/m|m\/s2|m\/s\^2|Pa s)$/;
/** @type {Record<string, number>} */
const OWN = { G: 1e9, M: 1e6, k: 1e3, '': 1, c: 1e-2, m: 1e-3, u: 1e-6, µ: 1e-6, n: 1e-9 };

/** @param {number} value @param {number} [digits] significant ones */
export function number(value, digits = 3) {
  if (!Number.isFinite(value)) return String(value);
  if (value === 0) return '0';
  const size = Math.abs(value);
  if (size >= 1e6 || size < 1e-4) return value.toExponential(digits - 1).replace(/\.?0*e/, 'e').replace('e+', 'e').replace('-', '−');
  const decimals = Math.max(0, digits - 1 - Math.floor(Math.log10(size)));
  return value.toFixed(Math.min(decimals, 12)).replace('-', '−');
}

/**
 * The factor and the unit that suit numbers up to `largest`.
 * @param {number} largest @param {string} unit
 * @returns {{factor: number, unit: string}} numbers are divided by the factor
 */
export function scaleFor(largest, unit) {
  const [, given, plain] = unit.match(PREFIXED) ?? [];
  if (plain === undefined || !(largest > 0) || !Number.isFinite(largest)) return { factor: 1, unit };
  const own = OWN[given];
  for (const [factor, prefix] of PREFIXES)
    if (largest * own >= factor * (1 - 1e-9) && (plain !== 's' || factor <= 1)) return { factor: factor / own, unit: prefix + plain };
  return { factor: 1 / own, unit: plain };
}

/** @param {number} value @param {string} unit @param {number} [digits] */
export function quantity(value, unit, digits = 3) {
  const scale = scaleFor(Math.abs(value), unit);
  return `${number(value / scale.factor, digits)} ${scale.unit}`.trim();
}

/** Round numbers from `low` to `high`, about `count` of them. @param {number} low @param {number} high @param {number} count */
export function ticks(low, high, count) {
  if (!(high > low)) return [low];
  const raw = (high - low) / count;
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = power * ([1, 2, 2.5, 5, 10].find((m) => m * power >= raw * 0.999) ?? 10);
  const list = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k++) list.push(k * step + 0); // no negative zero
  return list;
}

/** As many decimals as tell `values` apart. @param {number[]} values */
export function alike(values) {
  const step = values.length > 1 ? Math.abs(values[1] - values[0]) : Math.abs(values[0]) || 1;
  const largest = Math.max(...values.map(Math.abs));
  if (largest >= 1e6 || (largest > 0 && largest < 1e-4)) return values.map((value) => number(value, 3));
  const decimals = Math.min(9, Math.max(0, Math.ceil(-Math.log10(step) - 1e-9) + (/^(25|2\.5)/.test(String(step / 10 ** Math.floor(Math.log10(step)))) ? 1 : 0)));
  return values.map((value) => value.toFixed(decimals).replace('-', '−'));
}
