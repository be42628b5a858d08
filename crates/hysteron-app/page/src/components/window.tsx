// What depends on the width of the window.
import type { ComponentChildren } from 'preact';
import { useEffect, useRef, useState } from 'preact/hooks';

const NARROW = '(max-width: 1120px)';

export function useNarrow(): boolean {
  const [narrow, set] = useState(() => matchMedia(NARROW).matches);
  useEffect(() => {
    const media = matchMedia(NARROW);
    const follow = (): void => set(media.matches);
    media.addEventListener('change', follow);
    return () => media.removeEventListener('change', follow);
  }, []);
  return narrow;
}

/** Folds to one line in a narrow window. */
export function Fold({
  title,
  folded,
  children,
}: {
  title: string;
  folded: boolean;
  children: ComponentChildren;
}) {
  const narrow = useNarrow();
  if (!narrow || !folded) return <>{children}</>;
  return (
    <details class="fold">
      <summary>{title}</summary>
      {children}
    </details>
  );
}

/** A table that scrolls sideways where it has to, then also by keys. */
export function TableBox({ label, children }: { label: string; children: ComponentChildren }) {
  const box = useRef<HTMLDivElement>(null);
  const [scrolls, set] = useState(false);
  useEffect(() => {
    const element = box.current;
    if (!element) return;
    const size = new ResizeObserver(() => set(element.scrollWidth > element.clientWidth));
    size.observe(element);
    return () => size.disconnect();
  }, []);
  const reach = scrolls ? { tabIndex: 0, role: 'region' as const, 'aria-label': label } : {};
  return (
    <div class="tw" ref={box} {...reach}>
      {children}
    </div>
  );
}
