// Strokes on the canvas of a figure. Places are in pixels of the device: `pxRatio` to one of the page.
import uPlot from 'uplot';
import { placed } from './labels';
import type { Line, Spec } from './spec';

const style = (): CSSStyleDeclaration => getComputedStyle(document.documentElement);
const token = (name: string): string => style().getPropertyValue(`--${name}`).trim();

function clipped(plot: uPlot, strokes: (ctx: CanvasRenderingContext2D, ratio: number) => void): void {
  const { ctx, bbox } = plot;
  ctx.save();
  ctx.beginPath();
  ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
  ctx.clip();
  strokes(ctx, uPlot.pxRatio);
  ctx.restore();
}

export function line(plot: uPlot, drawn: Line): void {
  clipped(plot, (ctx, ratio) => {
    ctx.strokeStyle = token(drawn.color);
    ctx.lineJoin = 'round';
    ctx.lineCap = drawn.dash ? 'butt' : 'round';
    if (drawn.points) return dots(plot, drawn, ctx, ratio);
    ctx.lineWidth = (drawn.width ?? 1.5) * ratio;
    ctx.setLineDash((drawn.dash ?? []).map((length) => length * ratio));
    ctx.stroke(path(plot, drawn));
  });
}

/** The line in the order of its samples, interrupted at breaks and where there is no value. */
function path(plot: uPlot, drawn: Line): Path2D {
  const result = new Path2D();
  const breaks = new Set(drawn.breaks ?? []);
  let joined = false;
  for (let i = 0; i < drawn.x.length; i++) {
    const y = drawn.y[i];
    if (y == null || !Number.isFinite(y)) {
      joined = false;
      continue;
    }
    const left = plot.valToPos(drawn.x[i] as number, 'x', true);
    const top = plot.valToPos(y, 'y', true);
    if (joined && !breaks.has(i)) result.lineTo(left, top);
    else {
      result.moveTo(left, top);
      // A sample between two breaks is a point.
      result.lineTo(left, top);
    }
    joined = true;
  }
  return result;
}

function dots(plot: uPlot, drawn: Line, ctx: CanvasRenderingContext2D, ratio: number): void {
  for (let i = 0; i < drawn.x.length; i++) {
    const y = drawn.y[i];
    if (y == null) continue;
    const left = plot.valToPos(drawn.x[i] as number, 'x', true);
    const top = plot.valToPos(y, 'y', true);
    const error = drawn.errors?.[i];
    if (error) {
      ctx.lineWidth = 1.3 * ratio;
      ctx.beginPath();
      ctx.moveTo(left, plot.valToPos(y - error, 'y', true));
      ctx.lineTo(left, plot.valToPos(y + error, 'y', true));
      ctx.stroke();
    }
    ctx.lineWidth = 1.8 * ratio;
    ctx.fillStyle = drawn.filled?.(i) ? token(drawn.color) : token('paper');
    ctx.beginPath();
    ctx.arc(left, top, (drawn.points ?? 4) * ratio, 0, 7);
    ctx.fill();
    ctx.stroke();
  }
}

/** What lies beneath the lines: stretches, masks, band, zero line, levels. */
export function under(plot: uPlot, spec: Spec): void {
  clipped(plot, (ctx, ratio) => {
    const { bbox } = plot;
    const x = (value: number): number => plot.valToPos(value, 'x', true);
    const y = (value: number): number => plot.valToPos(value, 'y', true);
    const column = (from: number, to: number): void =>
      ctx.fillRect(x(from), bbox.top, x(to) - x(from), bbox.height);
    ctx.font = `${12 * ratio}px ${token('sans')}`;
    ctx.textAlign = 'center';
    spec.stretches?.forEach(({ from, to, label }, i) => {
      ctx.fillStyle = token('tint2');
      if (i % 2 === 0) column(from, to);
      ctx.fillStyle = token('soft');
      const fits = label && ctx.measureText(label).width + 8 * ratio < x(to) - x(from);
      if (fits) ctx.fillText(label, (x(from) + x(to)) / 2, bbox.top + bbox.height - 8 * ratio);
    });
    ctx.fillStyle = token('ink');
    ctx.globalAlpha = 0.1;
    for (const [from, to] of spec.masks ?? []) column(from, to);
    if (spec.band) {
      const { band } = spec;
      ctx.fillStyle = token('band');
      ctx.globalAlpha = 0.16;
      ctx.beginPath();
      for (let i = 0; i < band.x.length; i++) ctx.lineTo(x(band.x[i] as number), y(band.high[i] as number));
      for (let i = band.x.length - 1; i >= 0; i--)
        ctx.lineTo(x(band.x[i] as number), y(band.low[i] as number));
      ctx.fill();
    }
    ctx.globalAlpha = 1;
    ctx.strokeStyle = token('rule2');
    ctx.setLineDash([2 * ratio, 3 * ratio]);
    ctx.lineWidth = ratio;
    const levels = [...(spec.levels ?? []), ...(spec.zero ? [{ y: 0, label: undefined }] : [])];
    for (const level of levels) {
      ctx.beginPath();
      ctx.moveTo(bbox.left, y(level.y));
      ctx.lineTo(bbox.left + bbox.width, y(level.y));
      ctx.stroke();
      ctx.textAlign = 'right';
      ctx.fillStyle = token('soft');
      if (level.label)
        ctx.fillText(level.label, bbox.left + bbox.width - 5 * ratio, y(level.y) - 5 * ratio);
    }
  });
}

/** Frame, labels of the axes, words beside points. */
export function frame(plot: uPlot, spec: Spec): void {
  const { ctx, bbox } = plot;
  const ratio = uPlot.pxRatio;
  ctx.save();
  ctx.strokeStyle = token('rule2');
  ctx.lineWidth = ratio;
  ctx.strokeRect(bbox.left, bbox.top, bbox.width, bbox.height);
  ctx.font = `${12 * ratio}px ${token('sans')}`;
  ctx.fillStyle = token('ink');
  ctx.textBaseline = 'alphabetic';
  const points = (spec.marks ?? []).map(({ x, y, text }) => ({
    left: plot.valToPos(x, 'x', true) / ratio,
    top: plot.valToPos(y, 'y', true) / ratio,
    text,
  }));
  const area = {
    left: bbox.left / ratio,
    right: (bbox.left + bbox.width) / ratio,
    top: bbox.top / ratio,
    bottom: (bbox.top + bbox.height) / ratio,
  };
  for (const word of placed(points, area, (text) => ctx.measureText(text).width / ratio)) {
    ctx.textAlign = word.end ? 'right' : 'left';
    ctx.fillText(word.text, word.left * ratio, word.top * ratio);
  }
  ctx.textAlign = 'left';
  ctx.fillText(spec.y.label, 2 * ratio, 13 * ratio);
  ctx.textAlign = 'right';
  if (!spec.x.hide) ctx.fillText(spec.x.label, bbox.left + bbox.width, ctx.canvas.height - 4 * ratio);
  ctx.restore();
}
