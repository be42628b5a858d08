// A figure as an SVG file, with the colours of the theme that is shown.
import { placed } from './labels';
import { ticks } from './ticks';
import type { Line, Spec, View } from './spec';

const [LEFT, RIGHT, TOP, BOTTOM] = [52, 10, 24, 40];

export function svg(spec: Spec, view: View, width: number): string {
  const bottom = spec.x.hide ? 10 : BOTTOM;
  const [w, h] = [width - LEFT - RIGHT, spec.height - TOP - bottom];
  const along = (value: number, [low, high]: [number, number], log?: boolean): number =>
    log ? Math.log(value / low) / Math.log(high / low) : (value - low) / (high - low);
  const x = (value: number): number => round(LEFT + along(value, view.x, spec.x.log) * w);
  const y = (value: number): number => round(TOP + h - along(value, view.y, spec.y.log) * h);
  const parts: string[] = [];
  const tag = (name: string, values: Record<string, string | number>, text?: string): void => {
    const list = Object.entries(values).map(([key, value]) => ` ${key}="${escape(String(value))}"`);
    parts.push(
      text === undefined
        ? `<${name}${list.join('')}/>`
        : `<${name}${list.join('')}>${escape(text)}</${name}>`,
    );
  };

  tag('rect', { width, height: spec.height, fill: token('paper') });
  for (const tick of ticks(spec.x, view.x, w, 78)) {
    tag('path', { d: `M${x(tick.at)} ${TOP}v${h}`, stroke: token('grid') });
    const place = { x: x(tick.at), y: TOP + h + 16, 'text-anchor': 'middle', fill: token('soft') };
    if (!spec.x.hide) tag('text', place, tick.text);
  }
  for (const tick of ticks(spec.y, view.y, h, 38)) {
    tag('path', { d: `M${LEFT} ${y(tick.at)}h${w}`, stroke: token('grid') });
    tag('text', { x: LEFT - 7, y: y(tick.at) + 4, 'text-anchor': 'end', fill: token('soft') }, tick.text);
  }
  parts.push(`<clipPath id="area"><rect x="${LEFT}" y="${TOP}" width="${w}" height="${h}"/></clipPath>`);
  parts.push('<g clip-path="url(#area)">');
  for (const [from, to] of spec.masks ?? []) {
    tag('rect', {
      x: x(from),
      y: TOP,
      width: x(to) - x(from),
      height: h,
      fill: token('ink'),
      opacity: 0.1,
    });
  }
  if (spec.band) {
    const { band } = spec;
    const point = (i: number, side: ArrayLike<number>): string =>
      `${x(band.x[i] as number)} ${y(side[i] as number)}`;
    const indices = Array.from(band.x, (_, i) => i);
    const there = indices.map((i) => point(i, band.high));
    const back = indices.reverse().map((i) => point(i, band.low));
    tag('path', { d: `M${[...there, ...back].join('L')}Z`, fill: token('band'), opacity: 0.16 });
  }
  if (spec.zero)
    tag('path', { d: `M${LEFT} ${y(0)}h${w}`, stroke: token('rule2'), 'stroke-dasharray': '2 3' });
  for (const line of spec.lines) {
    const stroke = token(line.color);
    if (line.points) {
      eachPoint(line, (across, up, i) => {
        const fill = line.filled?.(i) ? stroke : token('paper');
        tag('circle', { cx: x(across), cy: y(up), r: line.points ?? 4, stroke, 'stroke-width': 1.8, fill });
      });
      continue;
    }
    const dash: Record<string, string> = line.dash ? { 'stroke-dasharray': line.dash.join(' ') } : {};
    tag('path', { d: path(line, x, y), fill: 'none', stroke, 'stroke-width': line.width ?? 1.5, ...dash });
  }
  parts.push('</g>');
  const area = { left: LEFT, right: LEFT + w, top: TOP, bottom: TOP + h };
  const words = (spec.marks ?? []).map((mark) => ({ left: x(mark.x), top: y(mark.y), text: mark.text }));
  for (const word of placed(words, area, (text) => text.length * 6.2)) {
    const anchor = word.end ? 'end' : 'start';
    tag('text', { x: word.left, y: word.top, 'text-anchor': anchor, fill: token('ink') }, word.text);
  }
  tag('rect', { x: LEFT, y: TOP, width: w, height: h, fill: 'none', stroke: token('rule2') });
  tag('text', { x: 2, y: 13, fill: token('ink') }, spec.y.label);
  if (!spec.x.hide) {
    tag(
      'text',
      { x: LEFT + w, y: spec.height - 4, 'text-anchor': 'end', fill: token('ink') },
      spec.x.label,
    );
  }
  const size = `width="${width}" height="${spec.height}" viewBox="0 0 ${width} ${spec.height}"`;
  const head = `<svg xmlns="http://www.w3.org/2000/svg" ${size} font-family="sans-serif" font-size="12">`;
  return `${head}<title>${escape(spec.title)}</title>${parts.join('\n')}</svg>\n`;
}

function path(line: Line, x: (v: number) => number, y: (v: number) => number): string {
  const breaks = new Set(line.breaks ?? []);
  let last = -2;
  let text = '';
  eachPoint(line, (across, up, i) => {
    text += `${i === last + 1 && !breaks.has(i) ? 'L' : 'M'}${x(across)} ${y(up)}`;
    last = i;
  });
  return text;
}

function eachPoint(line: Line, visit: (x: number, y: number, index: number) => void): void {
  for (let i = 0; i < line.x.length; i++) {
    const up = line.y[i];
    if (up != null && Number.isFinite(up)) visit(line.x[i] as number, up, i);
  }
}

const round = (value: number): number => Math.round(value * 100) / 100;
const token = (name: string): string =>
  getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
const escape = (text: string): string =>
  text.replace(/&/g, '&amp;').replace(/</g, '&lt;').replace(/>/g, '&gt;').replace(/"/g, '&quot;');
