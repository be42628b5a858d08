// A figure on a canvas: uPlot holds canvas, scales and axes; the lines are drawn by paths of draw.ts, so that
// a loop, which is no function of x, is drawn as it runs.
import uPlot from 'uplot';
import { frame, line, under } from './draw';
import { extent, ticks } from './ticks';
import type { Axis, Range, Spec, View, Zoom } from './spec';

const LEFT = 52;

export function whole(spec: Spec): View {
  const x =
    spec.x.range ??
    extent(
      spec.lines.map((l) => l.x),
      spec.x.log,
      spec.loop || points(spec) ? 0.04 : 0,
    );
  const columns = spec.lines.map((l) => l.y);
  for (const { y, errors } of spec.lines) {
    if (!errors) continue;
    for (const side of [-1, 1])
      columns.push(Array.from(y, (v, i) => (v == null ? v : v + side * (errors[i] ?? 0))));
  }
  if (spec.band) columns.push(spec.band.low, spec.band.high);
  return { x, y: spec.y.range ?? extent(columns, spec.y.log, points(spec) ? 0.15 : 0.06) };
}

/** The range upwards of what lies between two places across. */
function fitted(spec: Spec, [low, high]: Range): Range | null {
  const columns = spec.lines.map((line) => {
    const inside = (i: number): boolean => Number(line.x[i]) >= low && Number(line.x[i]) <= high;
    return Array.from(line.y, (y, i) => (inside(i) ? y : null));
  });
  const some = columns.some((column) => column.some((y) => y != null));
  return some ? extent(columns, spec.y.log, 0.06) : null;
}

function points(spec: Spec): boolean {
  return spec.lines.some((l) => l.points);
}

export class Figure {
  private plot: uPlot;
  private full: View;
  private view: View;
  private count: number;

  constructor(
    private holder: HTMLElement,
    private spec: Spec,
    zoomed: Zoom | null,
  ) {
    this.full = whole(spec);
    this.view = this.seen(zoomed);
    this.count = spec.lines.length;
    this.plot = this.make();
  }

  private seen(zoom: Zoom | null): View {
    if (!zoom) return this.full;
    const y = zoom.y ?? this.spec.y.range ?? fitted(this.spec, zoom.x) ?? this.full.y;
    return { x: zoom.x, y };
  }

  get over(): HTMLElement {
    return this.plot.over;
  }

  get shown(): View {
    return this.view;
  }

  get everything(): View {
    return this.full;
  }

  update(spec: Spec, zoomed: Zoom | null): void {
    const other = spec.lines.length !== this.count || axes(spec) !== axes(this.spec);
    if (!spec.hold || spec.hold !== this.spec.hold) this.full = whole(spec);
    this.spec = spec;
    this.view = this.seen(zoomed);
    if (other) {
      this.count = spec.lines.length;
      this.plot.destroy();
      this.plot = this.make();
      return;
    }
    this.plot.batch(() => {
      // A redraw sets the scale across to what it was: the new one has to come after it.
      this.plot.redraw(true, true);
      this.plot.setScale('x', { min: this.view.x[0], max: this.view.x[1] });
      this.plot.setScale('y', { min: this.view.y[0], max: this.view.y[1] });
    });
  }

  resize(): void {
    const width = this.holder.clientWidth;
    if (width > 0 && (width !== this.plot.width || this.spec.height !== this.plot.height)) {
      this.plot.setSize({ width, height: this.spec.height });
    }
  }

  redraw(): void {
    this.plot.redraw(false, true);
  }

  destroy(): void {
    this.plot.destroy();
  }

  canvas(): HTMLCanvasElement {
    return this.plot.ctx.canvas;
  }

  /** Pixels of the plotting area to values. */
  values(left: number, top: number): { x: number; y: number } {
    return { x: this.plot.posToVal(left, 'x'), y: this.plot.posToVal(top, 'y') };
  }

  pixels(x: number, y: number): { left: number; top: number } {
    return { left: this.plot.valToPos(x, 'x'), top: this.plot.valToPos(y, 'y') };
  }

  /** Index of the sample of the leading line nearest to a place: over x, of a loop in the plane. */
  nearest(left: number, top: number): number {
    const leading = this.spec.lines[0];
    if (!leading) return -1;
    let best = Infinity;
    let index = -1;
    for (let i = 0; i < leading.x.length; i++) {
      const y = leading.y[i];
      if (y == null) continue;
      const at = this.pixels(leading.x[i] as number, y);
      const across = at.left - left;
      const up = this.spec.loop ? at.top - top : 0;
      const distance = across * across + up * up;
      if (distance < best) {
        best = distance;
        index = i;
      }
    }
    return index;
  }

  private make(): uPlot {
    const width = this.holder.clientWidth || 300;
    const options: uPlot.Options = {
      mode: 2,
      width,
      height: this.spec.height,
      padding: [24, 10, this.spec.x.hide ? 6 : 0, 0],
      legend: { show: false },
      cursor: { show: false },
      scales: { x: this.scale('x'), y: this.scale('y') },
      axes: [this.axis('x'), this.axis('y')],
      series: [
        {},
        ...this.spec.lines.map((_, i) => ({
          facets: [
            { scale: 'x', auto: false },
            { scale: 'y', auto: false },
          ],
          paths: (plot: uPlot) => {
            const drawn = this.spec.lines[i];
            if (drawn) line(plot, drawn);
            return null;
          },
        })),
      ],
      hooks: {
        drawClear: [(plot) => under(plot, this.spec)],
        draw: [(plot) => frame(plot, this.spec)],
      },
    };
    const nothing = this.spec.lines.map(() => [[0], [0]]);
    return new uPlot(options, [null, ...nothing] as unknown as uPlot.AlignedData, this.holder);
  }

  private scale(which: 'x' | 'y'): uPlot.Scale {
    const axis: Axis = this.spec[which];
    return {
      time: false,
      auto: false,
      distr: axis.log ? 3 : 1,
      range: (): Range => this.view[which],
    };
  }

  private axis(which: 'x' | 'y'): uPlot.Axis {
    const across = which === 'x';
    const hidden = across && this.spec.x.hide;
    const list = (plot: uPlot): ReturnType<typeof ticks> => {
      const length = across ? plot.bbox.width : plot.bbox.height;
      return ticks(this.spec[which], this.view[which], length / uPlot.pxRatio, across ? 78 : 38);
    };
    return {
      scale: which,
      side: across ? 2 : 3,
      size: across ? (hidden ? 4 : 40) : LEFT,
      gap: 4,
      font: '12px sans-serif',
      stroke: () => color('soft'),
      grid: { stroke: () => color('grid'), width: 1 },
      ticks: { stroke: () => color('rule2'), width: 1, size: 4 },
      splits: (plot) => list(plot).map((tick) => tick.at),
      values: (plot) => list(plot).map((tick) => (hidden ? '' : tick.text)),
      filter: (_, splits) => splits,
    };
  }
}

function axes(spec: Spec): string {
  return [spec.x.log, spec.y.log, spec.x.hide].join();
}

/** A colour of the theme as it is now. */
export function color(name: string): string {
  return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
}
