// A reference drawn by hand: points over time, joined by straight lines.
import type { Range } from '../../plot/spec';

/** Begins a drawn reference in the URL. */
export const DRAWN = 'draw:';

/** `0 0, 0.1 5` as points; null where it cannot be read. */
export function read(text: string): Range[] | null {
  const points = text
    .split(/[,;\n]+/)
    .map((part) => part.trim().split(/\s+/).map(Number))
    .filter((pair) => pair.length > 1 || pair[0] !== 0);
  const whole = points.every((pair) => pair.length === 2 && pair.every(Number.isFinite));
  const sorted = (points as Range[]).sort((a, b) => a[0] - b[0]);
  return whole && sorted.length >= 2 ? sorted : null;
}

export function written(points: Range[]): string {
  return points
    .map(([time, value]) => `${Number(time.toPrecision(4))} ${Number(value.toPrecision(4))}`)
    .join(', ');
}

/** Samples of the drawn lines at the rate of the controller. */
export function sampled(points: Range[], rate: number): number[] {
  const last = points[points.length - 1]?.[0] ?? 0;
  const values: number[] = [];
  let at = 0;
  for (let i = 0; i <= Math.round(last * rate); i++) {
    const time = i / rate;
    while (at < points.length - 2 && time > (points[at + 1]?.[0] ?? 0)) at++;
    const [t0, y0] = points[at] ?? [0, 0];
    const [t1, y1] = points[at + 1] ?? [t0 + 1, y0];
    const share = t1 > t0 ? Math.max(0, Math.min(1, (time - t0) / (t1 - t0))) : 1;
    values.push(y0 + (y1 - y0) * share);
  }
  return values;
}
