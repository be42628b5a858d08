// Places of the numbers on an axis: 1, 2, 5 times a power of ten.
import { fixed, significant } from '../format';
import type { Axis, Range } from './spec';

export interface Tick {
  at: number;
  text: string;
}

export function ticks(axis: Axis, [low, high]: Range, pixels: number, spacing: number): Tick[] {
  if (!(high > low)) return [];
  return axis.log && low > 0 ? logarithmic(low, high) : linear(low, high, Math.max(2, pixels / spacing));
}

function linear(low: number, high: number, wanted: number): Tick[] {
  const raw = (high - low) / wanted;
  const power = 10 ** Math.floor(Math.log10(raw));
  const ratio = raw / power;
  const step = (ratio < 1.5 ? 1 : ratio < 3 ? 2 : ratio < 7 ? 5 : 10) * power;
  const digits = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
  const list: Tick[] = [];
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + step * 1e-9; i++) {
    const at = i * step;
    const text = digits > 5 || Math.abs(at) >= 1e6 ? significant(at, 3) : fixed(at, digits);
    list.push({ at, text });
  }
  return list;
}

function logarithmic(low: number, high: number): Tick[] {
  const list: (Tick & { first: boolean })[] = [];
  for (let power = Math.floor(Math.log10(low)); power <= Math.log10(high) + 1; power++) {
    for (const multiple of [1, 2, 5]) {
      const at = multiple * 10 ** power;
      if (at < low * (1 - 1e-9) || at > high * (1 + 1e-9)) continue;
      const plain = power >= -4 && power < 6;
      list.push({
        at,
        text: plain ? fixed(at, Math.max(0, -power)) : significant(at, 1),
        first: multiple === 1,
      });
    }
  }
  if (list.length < 2) return linear(low, high, 4);
  const decades = list.filter((tick) => tick.first);
  return list.length > 7 && decades.length > 1 ? decades : list;
}

/** The range of the data with some air; a figure without data gets 0 to 1. */
export function extent(columns: ArrayLike<number | null>[], log: boolean | undefined, air: number): Range {
  let low = Infinity;
  let high = -Infinity;
  for (const column of columns) {
    for (let i = 0; i < column.length; i++) {
      const value = column[i];
      if (value == null || !Number.isFinite(value) || (log && value <= 0)) continue;
      if (value < low) low = value;
      if (value > high) high = value;
    }
  }
  if (low > high) return log ? [1, 10] : [0, 1];
  if (log) {
    const factor = high > low ? (high / low) ** air : 2;
    return [low / factor, high * factor];
  }
  const pad = high > low ? (high - low) * air : Math.abs(high) * 0.05 || 1;
  return [low - pad, high + pad];
}
