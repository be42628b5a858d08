// Pointer in a figure: reading where it is, and zoom, pan, mask or cut where it is dragged.
import type { Figure } from './figure';
import type { Range, Spec, Tool, Zoom } from './spec';

export interface Answers {
  spec: () => Spec;
  tool: () => Tool;
  read: (index: number) => void;
  zoom: (zoom: Zoom | null) => void;
}

/** Less than this is a click, not a drag. */
const THRESHOLD = 6;

export function follow(figure: Figure, answers: Answers): () => void {
  const area = figure.over;
  const box = document.createElement('div');
  box.className = 'chosen';
  box.hidden = true;
  area.append(box);
  let from: { x: number; y: number } | null = null;

  const place = (event: PointerEvent): { x: number; y: number } => {
    const bounds = area.getBoundingClientRect();
    const inside = (value: number, size: number): number => Math.max(0, Math.min(size, value));
    return {
      x: inside(event.clientX - bounds.left, bounds.width),
      y: inside(event.clientY - bounds.top, bounds.height),
    };
  };
  const flat = (): boolean => answers.tool() !== 'zoom' || Boolean(answers.spec().flat);
  const down = (event: PointerEvent): void => {
    if (event.button !== 0) return;
    from = place(event);
    area.setPointerCapture(event.pointerId);
  };
  const move = (event: PointerEvent): void => {
    const now = place(event);
    if (!from) return answers.read(figure.nearest(now.x, now.y));
    if (answers.tool() === 'pan') return answers.zoom(panned(figure, from, now, answers.spec().flat));
    const whole = flat();
    box.hidden = false;
    box.style.left = `${Math.min(from.x, now.x)}px`;
    box.style.width = `${Math.abs(now.x - from.x)}px`;
    box.style.top = whole ? '0' : `${Math.min(from.y, now.y)}px`;
    box.style.height = whole ? '100%' : `${Math.abs(now.y - from.y)}px`;
  };
  const up = (event: PointerEvent): void => {
    if (!from) return;
    const start = from;
    const now = place(event);
    const whole = flat();
    from = null;
    box.hidden = true;
    const tool = answers.tool();
    if (tool === 'pan' || Math.abs(now.x - start.x) < THRESHOLD) return;
    const a = figure.values(Math.min(start.x, now.x), Math.max(start.y, now.y));
    const b = figure.values(Math.max(start.x, now.x), Math.min(start.y, now.y));
    if (tool === 'zoom') answers.zoom(whole ? { x: [a.x, b.x] } : { x: [a.x, b.x], y: [a.y, b.y] });
    else answers.spec().chosen?.(tool, a.x, b.x);
  };
  const all = (): void => answers.zoom(null);
  area.addEventListener('pointerdown', down);
  area.addEventListener('pointermove', move);
  area.addEventListener('pointerup', up);
  area.addEventListener('dblclick', all);
  return () => {
    area.removeEventListener('pointerdown', down);
    area.removeEventListener('pointermove', move);
    area.removeEventListener('pointerup', up);
    area.removeEventListener('dblclick', all);
    box.remove();
  };
}

function panned(
  figure: Figure,
  from: { x: number; y: number },
  now: { x: number; y: number },
  flat: boolean | undefined,
): Zoom {
  const a = figure.values(from.x, from.y);
  const b = figure.values(now.x, now.y);
  const shown = figure.shown;
  // Values of both places in the view as it is now, so that the point under the pointer stays under it.
  from.x = now.x;
  from.y = now.y;
  const [across, up] = [a.x - b.x, a.y - b.y];
  const x: Range = [shown.x[0] + across, shown.x[1] + across];
  return flat ? { x } : { x, y: [shown.y[0] + up, shown.y[1] + up] };
}
