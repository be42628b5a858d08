// Requests that take long: how far the server is with each, and their end.
import { Signal } from '../signal';
import type { RequestProgress } from './types';

export interface Open {
  /** Its name among the events. */
  name: string;
  resource: string;
  progress: RequestProgress | null;
  /** Ends the request, and with it the computation. */
  stop: () => void;
}

/** Requests that are open for longer than a moment. */
export const open = new Signal<Open[]>([]);

/** Time after which a request is shown. */
const MOMENT = 400;
let count = 0;
const page = Math.random().toString(36).slice(2, 10);

export interface Begun {
  name: string;
  signal: AbortSignal;
  stop: () => void;
  end: () => void;
}

/** Begins a request; it is listed once it takes longer than a moment. */
export function begin(resource: string): Begun {
  const name = `${page}-${++count}`;
  const aborts = new AbortController();
  const stop = (): void => aborts.abort();
  const timer = setTimeout(
    () => (open.value = [...open.value, { name, resource, progress: null, stop }]),
    MOMENT,
  );
  const end = (): void => {
    clearTimeout(timer);
    if (open.value.some((request) => request.name === name))
      open.value = open.value.filter((request) => request.name !== name);
  };
  return { name, signal: aborts.signal, stop, end };
}

/** Event `progress`. */
export function progressed(progress: RequestProgress): void {
  if (!open.value.some((request) => request.name === progress.request)) return;
  open.value = open.value.map((request) =>
    request.name === progress.request ? { ...request, progress } : request,
  );
}
