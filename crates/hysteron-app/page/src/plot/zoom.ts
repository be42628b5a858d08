// The zoom of each figure, in the URL.
import { route, settle } from '../route';
import type { Range, View, Zoom } from './spec';

const name = (key: string): string => `z.${key}`;

export function zoomOf(key: string): Zoom | null {
  const numbers = route.value.query.get(name(key))?.split('_').map(Number) ?? [];
  if (numbers.some((n) => !Number.isFinite(n))) return null;
  const [a, b, c, d] = numbers as [number, number, number?, number?];
  if (numbers.length !== 2 && numbers.length !== 4) return null;
  if (!(a < b) || (c !== undefined && !(c < (d as number)))) return null;
  return { x: [a, b], y: c === undefined ? undefined : ([c, d] as Range) };
}

export function setZoom(key: string, zoom: Zoom | null): void {
  const text = zoom && [...zoom.x, ...(zoom.y ?? [])].map((n) => Number(n.toPrecision(7))).join('_');
  settle({ [name(key)]: text });
}

/** `view` made smaller or larger about a place across. */
export function magnified(view: View, centre: number, factor: number, flat?: boolean): Zoom {
  const [low, high] = view.x;
  const x: Range = [centre - (centre - low) * factor, centre + (high - centre) * factor];
  return flat ? { x } : { x, y: view.y };
}
