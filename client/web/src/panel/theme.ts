import { byId } from '../dom';

const KEY = 'burnish-theme';
const dark = matchMedia('(prefers-color-scheme: dark)');

/** The system's theme until somebody chooses the other one. */
export function setUpTheme(changed: () => void): void {
  const button = byId<HTMLButtonElement>('theme');
  const shown = () => localStorage.getItem(KEY) ?? (dark.matches ? 'dark' : 'light');
  const apply = () => {
    const chosen = localStorage.getItem(KEY);
    if (chosen) document.documentElement.dataset.theme = chosen;
    else delete document.documentElement.dataset.theme;
    button.textContent = shown() === 'dark' ? 'Light' : 'Dark';
    button.setAttribute('aria-label', `${button.textContent} theme`);
    changed();
  };
  button.onclick = () => {
    const next = shown() === 'dark' ? 'light' : 'dark';
    if (next === (dark.matches ? 'dark' : 'light')) localStorage.removeItem(KEY);
    else localStorage.setItem(KEY, next);
    apply();
  };
  dark.addEventListener('change', apply);
  apply();
}
