// A value that components follow.
import { useEffect, useState } from 'preact/hooks';

export class Signal<T> {
  private listeners = new Set<() => void>();
  constructor(private current: T) {}

  get value(): T {
    return this.current;
  }

  set value(next: T) {
    if (next === this.current) return;
    this.current = next;
    for (const listener of [...this.listeners]) listener();
  }

  subscribe(listener: () => void): () => void {
    this.listeners.add(listener);
    return () => this.listeners.delete(listener);
  }
}

export function useSignal<T>(signal: Signal<T>): T {
  const [, redraw] = useState(0);
  useEffect(() => {
    const kept = signal.value;
    const stop = signal.subscribe(() => redraw((n) => n + 1));
    if (signal.value !== kept) redraw((n) => n + 1);
    return stop;
  }, [signal]);
  return signal.value;
}
