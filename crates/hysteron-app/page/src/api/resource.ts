// Answers of the server, kept by their address; fetched anew where an event says that they changed.
import { useEffect, useState } from 'preact/hooks';
import { change, get, Refusal } from './client';
import { begin, type Begun } from './requests';

export interface Answer<T> {
  value?: T;
  error?: Refusal;
  loading: boolean;
}

interface Entry extends Answer<unknown> {
  listeners: Set<() => void>;
  stale: boolean;
  used: number;
  /** The request that is open. */
  begun?: Begun;
}

const KEPT = 60;
const entries = new Map<string, Entry>();
let clock = 0;

function entry(address: string): Entry {
  let found = entries.get(address);
  if (!found) {
    found = { loading: false, stale: true, listeners: new Set(), used: ++clock };
    entries.set(address, found);
    forgetOldest();
  }
  found.used = ++clock;
  return found;
}

function forgetOldest(): void {
  if (entries.size <= KEPT) return;
  const unused = [...entries]
    .filter(([, e]) => e.listeners.size === 0)
    .sort((a, b) => a[1].used - b[1].used);
  for (const [address] of unused.slice(0, entries.size - KEPT)) entries.delete(address);
}

/** An address, or an address and the body of a question, on two lines. */
function ask(address: string, e: Entry): Promise<unknown> {
  const [resource = '', body] = address.split('\n');
  const begun = (e.begun = begin(resource));
  return body === undefined ? get(resource, begun) : change('POST', resource, JSON.parse(body), begun);
}

/** Ends a question that nothing on the page waits for any more: its answer may take minutes. */
function abandon(address: string, e: Entry): void {
  if (!e.loading || e.listeners.size || !address.includes('\n')) return;
  e.stale = true;
  e.begun?.stop();
}

async function load(address: string): Promise<void> {
  const e = entry(address);
  if (e.loading) return;
  e.loading = true;
  e.stale = false;
  try {
    e.value = await ask(address, e);
    e.error = undefined;
  } catch (error) {
    e.error = error instanceof Refusal ? error : new Refusal(0, { what: String(error) });
    e.value = undefined;
  }
  e.loading = false;
  for (const listener of [...e.listeners]) listener();
  if (e.stale && e.listeners.size) void load(address);
}

const gone = new Set<string>();

/** What begins with `prefix` was deleted: nothing asks for it until it is put back. */
export function deletedAt(prefix: string): void {
  gone.add(prefix);
}

export function putBack(): void {
  gone.clear();
  changed('');
}

/** Marks what begins with `prefix` as changed; what is on the page is fetched at once. */
export function changed(prefix: string): void {
  for (const [address, e] of entries) {
    if (!address.startsWith(prefix)) continue;
    if ([...gone].some((start) => address.startsWith(start))) continue;
    e.stale = true;
    if (e.listeners.size) void load(address);
  }
}

/** Lists that may have changed between their first answer and the first event. */
export function listsChanged(): void {
  for (const list of ['records', 'models', 'reports', 'workspace']) {
    const e = entries.get(list);
    if (!e) continue;
    e.stale = true;
    if (e.listeners.size) void load(list);
  }
}

export function useResource<T>(address: string | null): Answer<T> {
  const [, redraw] = useState(0);
  useEffect(() => {
    if (!address) return;
    const e = entry(address);
    const listener = (): void => redraw((n) => n + 1);
    e.listeners.add(listener);
    if (e.stale) void load(address);
    listener();
    return () => {
      e.listeners.delete(listener);
      abandon(address, e);
    };
  }, [address]);
  if (!address) return { loading: false };
  const e = entries.get(address);
  if (!e) return { loading: true };
  return { value: e.value as T | undefined, error: e.error, loading: e.loading || e.stale };
}

/** The newest answer of a changing address: the one before it stays until the next is there. */
export function useLatest<T>(address: string | null): Answer<T> {
  const answer = useResource<T>(address);
  const [last, keep] = useState<T | undefined>(undefined);
  useEffect(() => {
    if (answer.value !== undefined) keep(answer.value);
  }, [answer.value]);
  return { ...answer, value: answer.value ?? (answer.error ? undefined : last) };
}

/** As `useLatest`, for a question that is too long for an address. */
export function useAnswer<T>(resource: string | null, body: unknown): Answer<T> {
  return useLatest<T>(resource && `${resource}\n${JSON.stringify(body)}`);
}

/** Answers of several addresses. */
export function useAll<T>(addresses: string[]): Answer<T>[] {
  const [, redraw] = useState(0);
  const all = addresses.join('\n\n');
  useEffect(() => {
    const listener = (): void => redraw((n) => n + 1);
    const list = addresses.map(entry);
    addresses.forEach((address, i) => {
      list[i]?.listeners.add(listener);
      if (list[i]?.stale) void load(address);
    });
    listener();
    return () => list.forEach((e) => e.listeners.delete(listener));
  }, [all]);
  return addresses.map((address) => {
    const e = entries.get(address);
    return e ? { value: e.value as T | undefined, error: e.error, loading: e.loading } : { loading: true };
  });
}
