// Keys of the page: rooms, records, copy, stop. Keys of a figure are its own.
import { RAIL } from './rail';
import { go } from './route';
import { Signal } from './signal';

/** Single keys can be switched off (WCAG 2.1.4): they may be typed by speech. */
export const keysOn = new Signal(localStorage.getItem('keys') !== 'off');
keysOn.subscribe(() => localStorage.setItem('keys', keysOn.value ? 'on' : 'off'));

export function listen(): void {
  document.addEventListener('keydown', (event) => {
    const target = event.target as HTMLElement | null;
    if (!keysOn.value || event.ctrlKey || event.metaKey || event.altKey) return;
    if (target?.closest('input, select, textarea, [contenteditable]')) return;
    const room = RAIL[Number(event.key) - 1];
    if (room) return go({}, room[0]);
    if (event.key === 'c') press('[data-key="c"]');
    else if (event.key === 's') press('[data-key="s"], [data-key="s2"]');
    else if (event.key === 'j') step(1);
    else if (event.key === 'k') step(-1);
  });
}

function press(selector: string): void {
  document.querySelector<HTMLElement>(selector)?.click();
}

/** To the next or previous of a list whose buttons have `data-step`. */
function step(by: number): void {
  const list = [...document.querySelectorAll<HTMLElement>('[data-step]')];
  const at = list.findIndex((button) => button.getAttribute('aria-pressed') === 'true');
  const next = list[at + by];
  next?.click();
  next?.focus();
}
