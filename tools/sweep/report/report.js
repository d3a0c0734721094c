// SPDX-License-Identifier: LGPL-2.1-or-later
// The page of a sweep: details of a point, the table, the keys.
(() => {
  const data = JSON.parse(document.getElementById('data').textContent);
  const rows = data.configurations;
  const details = document.getElementById('details'), tip = document.getElementById('tip');
  let chosen = -1;

  const digits = (value, count = 3) => Number(value.toPrecision(count)).toString();
  const seconds = (value) => (value >= 100 ? `${digits(value)} s` : value >= 1 ? `${digits(value)} s` : value >= 1e-3 ? `${digits(value * 1e3)} ms` : `${digits(value * 1e6)} µs`);
  const share = (value) => (data.error.relative ? `${digits(value * 100)} %` : digits(value));
  const bytes = (value) => `${digits(value / 1e6)} MB`;
  const length = (value) => (value === 0 ? '' : data.units.length !== 'm' ? `${digits(value)} ${data.units.length}`.trim() : value < 1 ? `${digits(value * 1e3)} mm` : `${digits(value)} m`);
  const errorOf = (row) => (row.error === null ? 'none' : (row.is_reference ? 'about ' : '') + share(row.error));

  function element(tag, text, parent, kind) {
    const made = document.createElement(tag);
    if (text !== undefined) made.textContent = text;
    if (kind) made.className = kind;
    if (parent) parent.append(made);
    return made;
  }

  async function copy(text, button) {
    try {
      await navigator.clipboard.writeText(text);
    } catch {  // a file opened from disk may have no clipboard
      const area = element('textarea', text, document.body);
      area.select();
      document.execCommand('copy');
      area.remove();
    }
    if (!button) return;
    const before = button.textContent;
    button.textContent = 'copied';
    setTimeout(() => { button.textContent = before; }, 1200);
  }

  function choose(index) {
    chosen = index;
    for (const one of document.querySelectorAll('.chosen')) one.classList.remove('chosen');
    details.hidden = index < 0;
    if (index < 0) return;
    for (const one of document.querySelectorAll(`[data-entry="${index}"]`)) one.classList.add('chosen');
    const row = rows[index];
    details.replaceChildren();
    const top = element('div', undefined, details, 'top');
    element('strong', row.name, top);
    if (row.on_front) element('span', 'on the front', top);
    if (row.is_reference) element('span', 'the reference', top);
    const button = element('button', 'copy the command', top);
    button.onclick = () => copy(row.command, button);
    element('button', 'close', top).onclick = () => choose(-1);
    const list = element('dl', undefined, details);
    const fact = (name, value) => {
      const pair = element('div', undefined, list);
      element('dt', name, pair);
      element('dd', value, pair);
    };
    fact('outcome', row.outcome);
    if (row.sentence) fact('why', row.sentence);
    fact('error', errorOf(row) + (row.error !== null && data.error.uncertainty > 0 ? ` ± ${share(data.error.uncertainty)}` : ''));
    if (row.runs > 0) {
      if (row.timed) fact('time to the end', `${seconds(row.seconds)} (${row.runs === 1 ? 'one run' : `median of ${row.runs}, ${seconds(row.seconds_spread)} apart`})${row.disturbed ? ', disturbed' : ''}`);
      if (row.timed) fact('per step', seconds(row.ms_per_step / 1e3));
      if (row.timed) fact('loading', seconds(row.load_seconds));
      fact('steps', row.steps);
      fact('Newton iterations', row.newton_iterations);
      fact('linear iterations', row.linear_iterations);
      fact('memory', bytes(row.peak_memory_bytes));
      fact('threads', row.threads);
      if (row.nodes) fact('mesh', `${row.nodes} nodes, ${row.cells} cells, h ${length(row.spacing)}`);
      if (row.points_outside) fact('compared outside of the mesh', `${row.points_outside.count} points, up to ${length(row.points_outside.farthest)}`);
      if (row.warnings) fact('warnings', row.warnings);
      fact('load at the start', row.measured.map((run) => digits(run.load_at_start, 2)).join(', '));
      fact('cores', row.measured.map((run) => run.cores.join('+')).join(', '));
    }
    element('pre', row.command, details);
  }

  // ---- points ----
  const points = [...document.querySelectorAll('.point')];
  for (const point of points) {
    const index = Number(point.dataset.entry), row = rows[index];
    point.setAttribute('tabindex', '-1');
    point.setAttribute('role', 'button');
    const text = `${row.name}\n${row.error === null ? row.sentence : `error ${errorOf(row)}${row.timed ? `, ${seconds(row.seconds)}` : ''}`}`;
    point.setAttribute('aria-label', text.replace('\n', ': '));
    point.onclick = () => choose(index);
    point.onpointerenter = (event) => {
      tip.textContent = text;
      tip.hidden = false;
      tip.style.left = `${Math.min(event.clientX + 14, innerWidth - tip.offsetWidth - 8)}px`;
      tip.style.top = `${Math.max(8, event.clientY - tip.offsetHeight - 12)}px`;
    };
    point.onpointerleave = () => { tip.hidden = true; };
  }
  for (const chart of document.querySelectorAll('svg.chart')) {
    const first = chart.querySelector('.point');
    if (first) first.setAttribute('tabindex', '0');
  }

  function goTo(from, key) {
    const chart = from.closest('svg');
    const place = (point) => { const box = point.getBoundingClientRect(); return [box.x + box.width / 2, box.y + box.height / 2]; };
    const [x, y] = place(from);
    const sign = key === 'ArrowRight' || key === 'ArrowDown' ? 1 : -1, across = key === 'ArrowLeft' || key === 'ArrowRight';
    let best = null, least = Infinity;
    for (const other of chart.querySelectorAll('.point')) {
      const [u, v] = place(other), along = sign * (across ? u - x : v - y), aside = Math.abs(across ? v - y : u - x);
      if (other === from || along <= 0.5) continue;
      if (along + 2 * aside < least) { least = along + 2 * aside; best = other; }
    }
    if (best) { best.focus(); choose(Number(best.dataset.entry)); }
  }

  document.addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const point = document.activeElement?.closest?.('.point');
    if (event.key === 'Escape') choose(-1);
    else if (event.key === 't') theme();
    else if (point && event.key.startsWith('Arrow')) { event.preventDefault(); goTo(point, event.key); }
    else if (point && (event.key === 'Enter' || event.key === ' ')) {
      event.preventDefault();
      choose(Number(point.dataset.entry));
      copy(rows[chosen].command, details.querySelector('button'));
    }
  });

  // ---- tables ----
  for (const button of document.querySelectorAll('button.copy')) button.onclick = (event) => { event.stopPropagation(); copy(button.dataset.text, button); };
  for (const row of document.querySelectorAll('tbody tr[data-entry]')) row.onclick = () => choose(Number(row.dataset.entry));

  const attributes = Object.keys(rows.find((row) => Object.keys(row.settings).length)?.settings ?? {});
  const short = (name) => name.slice(name.lastIndexOf('/') + 1);
  const columns = [
    ...attributes.map((name) => ({ title: short(name), value: (row) => row.settings[name] ?? '' })),
    { title: 'error', value: (row) => row.error ?? Infinity, text: errorOf },
    { title: 'time to the end', value: (row) => row.seconds, text: (row) => (row.timed ? seconds(row.seconds) : '') },
    { title: 'per step', value: (row) => row.ms_per_step, text: (row) => (row.timed ? seconds(row.ms_per_step / 1e3) : '') },
    { title: 'Newton', value: (row) => row.newton_iterations },
    { title: 'linear', value: (row) => row.linear_iterations },
    { title: 'memory', value: (row) => row.peak_memory_bytes, text: (row) => (row.runs ? bytes(row.peak_memory_bytes) : '') },
    { title: 'nodes', value: (row) => row.nodes },
    { title: 'outcome', value: (row) => row.outcome, text: (row) => row.outcome + (row.is_reference ? ', the reference' : '') + (row.disturbed ? ', disturbed' : '') },
    { title: 'why', value: (row) => row.sentence ?? '' },
  ];
  const table = document.getElementById('all');
  const head = element('tr', undefined, element('thead', undefined, table));
  const body = element('tbody', undefined, table);
  let sorted = null, ascending = true;

  function fill(order) {
    body.replaceChildren();
    for (const index of order) {
      const row = rows[index], line = element('tr', undefined, body);
      line.dataset.entry = index;
      line.className = (row.error === null ? 'bad' : '') + (row.on_front ? ' front' : '') + (index === chosen ? ' chosen' : '');
      for (const column of columns) {
        const value = column.value(row);
        element('td', column.text ? column.text(row) : value, line, typeof value === 'number' ? 'number' : '');
      }
      line.onclick = () => choose(index);
    }
  }
  const order = rows.map((_, index) => index);
  for (const column of columns) {
    const cell = element('th', column.title, head);
    cell.onclick = () => {
      ascending = sorted === column ? !ascending : true;
      sorted = column;
      const compare = (a, b) => {
        const u = column.value(rows[a]), v = column.value(rows[b]);
        const n = typeof u === 'number' ? u - v || 0 : String(u).localeCompare(String(v), undefined, { numeric: true });
        return ascending ? n : -n;
      };
      fill([...order].sort(compare));
    };
  }
  fill(order);

  // ---- light and dark ----
  function theme() {
    const root = document.documentElement;
    const dark = root.dataset.theme ? root.dataset.theme === 'dark' : matchMedia('(prefers-color-scheme: dark)').matches;
    root.dataset.theme = dark ? 'light' : 'dark';
  }
  document.getElementById('theme').onclick = theme;
})();
