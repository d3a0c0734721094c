// SPDX-License-Identifier: LGPL-2.1-or-later
// Numbers over time: what the frames say of energies, the solver, hands and watched nodes. A table whose rows are frames.

const MOST_ROWS = 20000;

export class Series {
  constructor() {
    this.clear();
  }

  clear() {
    /** @type {number[]} */
    this.times = [];
    this.run = 0;
    /** @type {Map<string, (number | null)[]>} */
    this.columns = new Map();
  }

  /** @param {number} time [s] @param {Record<string, number>} values @param {number} [run] a number that grows with each reset */
  add(time, values, run = 0) {
    if (run !== this.run || time < this.times[this.times.length - 1]) this.clear(); // the run was reset
    this.run = run;
    if (time === this.times[this.times.length - 1]) this.drop(); // the same instant, seen again
    const names = Object.keys(values);
    if (names.length === 0) return;
    for (const name of names) if (!this.columns.has(name)) this.columns.set(name, new Array(this.times.length).fill(null));
    this.times.push(time);
    for (const [name, column] of this.columns) column.push(Number.isFinite(values[name]) ? values[name] : null);
    if (this.times.length > MOST_ROWS) this.thin();
  }

  /** Columns of nodes, "node.BODY.NODE", have other names now. @param {Map<string, string>} names */
  rename(names) {
    this.columns = new Map([...this.columns].map(([name, column]) => {
      const of = name.split('.').slice(0, 3).join('.');
      return [names.has(of) ? names.get(of) + name.slice(of.length) : name, column];
    }));
  }

  drop() {
    this.times.pop();
    for (const column of this.columns.values()) column.pop();
  }

  /** Every second row goes. */
  thin() {
    this.times = this.times.filter((_, i) => i % 2 === 0);
    for (const [name, column] of this.columns) this.columns.set(name, column.filter((_, i) => i % 2 === 0));
  }

  /** @param {string} name */
  column(name) {
    return this.columns.get(name) ?? new Array(this.times.length).fill(null);
  }

  /** @returns {string} all columns; numbers with all their digits */
  csv() {
    const names = [...this.columns.keys()].sort();
    const quoted = (/** @type {string} */ name) => (/[",\n]/.test(name) ? `"${name.replaceAll('"', '""')}"` : name);
    const lines = [['time', ...names].map(quoted).join(',')];
    this.times.forEach((time, i) => lines.push([time, ...names.map((name) => this.columns.get(name)?.[i] ?? '')].join(',')));
    return lines.join('\n') + '\n';
  }
}
