// The URL is the state: room in the path of the hash, everything that is chosen in its query.
import { Signal } from './signal';

export const ROOMS = [
  'records',
  'identify',
  'compare',
  'validate',
  'follow',
  'home',
  'try',
  'history',
] as const;
export type Room = (typeof ROOMS)[number];

export interface Route {
  room: Room;
  query: URLSearchParams;
}

/** What a link to another room keeps: record, model, theme and language of the commands. */
const KEPT = ['r', 'm', 'theme', 'lang'];

function parse(): Route {
  const [path, query] = location.hash.replace(/^#\/?/, '').split('?');
  const room = ROOMS.find((name) => name === path) ?? 'records';
  // An address of no room must not stay above another one.
  if (path && path !== room) history.replaceState(null, '', `#/${room}`);
  return { room, query: new URLSearchParams(query ?? '') };
}

export const route = new Signal<Route>(parse());

export type Changes = Record<string, string | null | undefined>;

/** Address of a room with some values changed; `null` removes one. */
export function address(changes: Changes, room: Room = route.value.room): string {
  const now = route.value;
  const query = new URLSearchParams();
  for (const [key, value] of now.query) {
    if (room === now.room || KEPT.includes(key)) query.append(key, value);
  }
  for (const [key, value] of Object.entries(changes)) {
    if (value == null || value === '') query.delete(key);
    else query.set(key, value);
  }
  const text = query.toString();
  return `#/${room}${text ? `?${text}` : ''}`;
}

export function go(changes: Changes, room?: Room): void {
  const next = address(changes, room);
  if (next !== location.hash) location.hash = next;
}

/** As `go`, without a step in the history: zoom, typed text. */
export function settle(changes: Changes): void {
  history.replaceState(null, '', address(changes));
  route.value = parse();
}

export function applyTheme(): void {
  const theme = route.value.query.get('theme');
  if (theme === 'dark' || theme === 'light') document.documentElement.dataset.theme = theme;
  else delete document.documentElement.dataset.theme;
}

addEventListener('hashchange', () => {
  route.value = parse();
});
route.subscribe(applyTheme);
applyTheme();
