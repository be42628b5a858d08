// Icons of 16 pixels, as strokes.
const STROKES = {
  zoom: 'M11.5 7a4.5 4.5 0 1 1-9 0a4.5 4.5 0 1 1 9 0M10.5 10.5 14 14M5 7h4M7 5v4',
  pan:
    'M8 2v12M2 8h12M8 2 6.3 3.7M8 2l1.7 1.7M8 14l-1.7-1.7M8 14l1.7-1.7M2 8l1.7-1.7M2 8l1.7 1.7' +
    'M14 8l-1.7-1.7M14 8l-1.7 1.7',
  reset: 'M3 3v4h4M3.4 7A5 5 0 1 1 3 9.5',
  mask: 'M2 3v10M14 3v10M5 5l6 6M5 9l3 3M8 4l3 3',
  cut: 'M6 4a2 2 0 1 1-4 0a2 2 0 1 1 4 0M6 12a2 2 0 1 1-4 0a2 2 0 1 1 4 0M5.6 5.2 14 12M5.6 10.8 14 4',
  down: 'M8 2v8M4.8 7 8 10.2 11.2 7M3 13.5h10',
  copy:
    'M5 6.2A1.2 1.2 0 0 1 6.2 5h6.1a1.2 1.2 0 0 1 1.2 1.2v6.1' +
    'a1.2 1.2 0 0 1-1.2 1.2H6.2A1.2 1.2 0 0 1 5 12.3Z' +
    'M3 10.5V3.3A.8.8 0 0 1 3.8 2.5H10',
  warn: 'M8 2 14.5 13.5H1.5ZM8 6.5v3.2M8 11.6v.1',
  info: 'M14 8a6 6 0 1 1-12 0a6 6 0 1 1 12 0M8 7.3v4M8 4.8v.1',
  ok: 'M14 8a6 6 0 1 1-12 0a6 6 0 1 1 12 0M5.3 8.2l2 2 3.5-4',
  bad: 'M14 8a6 6 0 1 1-12 0a6 6 0 1 1 12 0M5.8 5.8l4.4 4.4M10.2 5.8l-4.4 4.4',
  next: 'M2 8h11M9.5 4.5 13 8l-3.5 3.5',
  link: 'M6.5 9.5 9.5 6.5M7 4.8l1.5-1.5a2.6 2.6 0 0 1 4 4L11 8.8M9 11.2l-1.5 1.5a2.6 2.6 0 0 1-4-4L5 7.2',
  stop: 'M4 4h8v8H4Z',
  run: 'M14 8a6 6 0 1 1-12 0a6 6 0 1 1 12 0M8 4.5V8l2.3 1.6',
  dot: 'M14 8a6 6 0 1 1-12 0a6 6 0 1 1 12 0',
  half: 'M14 8a6 6 0 1 1-12 0a6 6 0 1 1 12 0M8 2v12',
  theme: 'M13.5 8a5.5 5.5 0 1 1-11 0a5.5 5.5 0 1 1 11 0M8 2.5v11M10 3.4v9.2M12 5v6',
  trash: 'M3 4.5h10M6.5 4.5V3h3v1.5M4.5 4.5l.6 9h5.8l.6-9M7 7v4M9 7v4',
  close: 'M4 4l8 8M12 4l-8 8',
} as const;

export type IconName = keyof typeof STROKES;

export function Icon({ name }: { name: IconName }) {
  return (
    <svg class="i" viewBox="0 0 16 16" aria-hidden="true">
      <path d={STROKES[name]} />
    </svg>
  );
}
