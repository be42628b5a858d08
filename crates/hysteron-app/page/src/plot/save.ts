// A figure as a file: PNG of the canvas, SVG, or the numbers as CSV.
import type { Figure } from './figure';
import type { Line, Spec } from './spec';
import { svg } from './svg';

export const FORMS = ['PNG', 'SVG', 'CSV'] as const;
export type FigureForm = (typeof FORMS)[number];

export async function save(figure: Figure, spec: Spec, form: FigureForm): Promise<void> {
  const name = spec.title
    .toLowerCase()
    .replace(/[^a-z0-9.]+/g, '-')
    .replace(/^-|-$/g, '');
  const ending = form.toLowerCase();
  if (form === 'PNG') {
    const blob = await picture(figure.canvas());
    if (blob) download(blob, `${name}.${ending}`);
  } else if (form === 'SVG') {
    const text = svg(spec, figure.shown, figure.canvas().clientWidth);
    download(new Blob([text], { type: 'image/svg+xml' }), `${name}.${ending}`);
  } else {
    download(new Blob([csv(spec)], { type: 'text/csv' }), `${name}.${ending}`);
  }
}

function picture(canvas: HTMLCanvasElement): Promise<Blob | null> {
  const copy = document.createElement('canvas');
  copy.width = canvas.width;
  copy.height = canvas.height;
  const ctx = copy.getContext('2d');
  if (ctx) {
    ctx.fillStyle = getComputedStyle(document.documentElement).getPropertyValue('--paper').trim();
    ctx.fillRect(0, 0, copy.width, copy.height);
    ctx.drawImage(canvas, 0, 0);
  }
  return new Promise((resolve) => copy.toBlob(resolve, 'image/png'));
}

/** One row a point, all lines beneath each other: they need not share their points. */
function csv(spec: Spec): string {
  const rows = [`line,"${spec.x.label}","${spec.y.label}"`];
  const add = (name: string, line: Pick<Line, 'x' | 'y'>): void => {
    for (let i = 0; i < line.x.length; i++) rows.push(`${name},${line.x[i]},${line.y[i] ?? ''}`);
  };
  for (const line of spec.lines) add(line.name ?? spec.title.replace(/,/g, ''), line);
  if (spec.band) {
    add('band low', { x: spec.band.x, y: spec.band.low });
    add('band high', { x: spec.band.x, y: spec.band.high });
  }
  return `${rows.join('\n')}\n`;
}

export function download(blob: Blob, name: string): void {
  const link = document.createElement('a');
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}
