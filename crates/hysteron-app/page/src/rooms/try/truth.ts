// The numbers of the bench's truth that have a slider; all others are in the form beneath.

export interface Slider {
  label: string;
  path: (string | number)[];
  low: number;
  high: number;
  step: number;
  unit: string;
  /** Factor from the truth's unit to the one that is shown. */
  factor?: number;
  digits: number;
}

export const SLIDERS: Slider[] = [
  {
    label: 'Amplifier corner',
    path: ['plant', 'amplifier_corner_hz'],
    low: 100,
    high: 10_000,
    step: 10,
    unit: 'Hz',
    digits: 0,
  },
  {
    label: 'Linear gain',
    path: ['plant', 'linear_um_per_v'],
    low: 0,
    high: 4,
    step: 0.01,
    unit: 'µm/V',
    digits: 2,
  },
  {
    label: 'First mode',
    path: ['plant', 'modes', 0, 'frequency_hz'],
    low: 50,
    high: 2000,
    step: 1,
    unit: 'Hz',
    digits: 0,
  },
  {
    label: 'Creep strength',
    path: ['plant', 'creep', 'strength'],
    low: 0,
    high: 0.3,
    step: 0.001,
    unit: '',
    digits: 3,
  },
  {
    label: 'Delay',
    path: ['plant', 'delay_s'],
    low: 0,
    high: 1e-3,
    step: 1e-6,
    unit: 'ms',
    factor: 1e3,
    digits: 3,
  },
  {
    label: 'Sensor noise',
    path: ['sensor', 'noise_um'],
    low: 0,
    high: 0.05,
    step: 1e-4,
    unit: 'nm rms',
    factor: 1e3,
    digits: 1,
  },
];

type Value = Record<string | number, unknown>;

export function valueAt(truth: unknown, path: Slider['path']): number | null {
  let now: unknown = truth;
  for (const key of path) now = now != null && typeof now === 'object' ? (now as Value)[key] : undefined;
  return typeof now === 'number' ? now : null;
}

/** The truth with one number changed; nothing of the old one is touched. */
export function changedAt(truth: unknown, [key, ...rest]: Slider['path'], value: number): unknown {
  if (key === undefined) return value;
  const now = truth as Value;
  const next = changedAt(now[key], rest, value);
  return Array.isArray(truth) ? truth.map((one, i) => (i === key ? next : one)) : { ...now, [key]: next };
}
