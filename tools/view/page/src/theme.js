// SPDX-License-Identifier: LGPL-2.1-or-later
// Light and dark: as the system says, unless the person chose.

const dark = matchMedia('(prefers-color-scheme: dark)');

function remembered() {
  try {
    return localStorage.getItem('stroma-theme') ?? 'auto';
  } catch {
    return 'auto'; // a page from a file may have no storage
  }
}

/** @param {import('./store.js').Store} store */
export function followTheme(store) {
  const apply = () => {
    const { theme } = store.view;
    document.documentElement.dataset.theme = theme === 'auto' ? (dark.matches ? 'dark' : 'light') : theme;
    store.emit('theme');
  };
  store.view.theme = remembered();
  apply();
  dark.addEventListener('change', () => {
    apply();
    store.emit('view', {});
  });
  store.on('view', (change) => {
    if (change.theme === undefined) return;
    try {
      localStorage.setItem('stroma-theme', change.theme);
    } catch { /* not remembered then */ }
    apply();
  });
}
