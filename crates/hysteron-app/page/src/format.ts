// Numbers and units as text: digits that the error allows, − for minus, thin spaces in thousands.

const MINUS = '−';
const THIN = ' ';

/** `value` with `digits` decimals. */
export function fixed(value: number, digits: number): string {
  if (!Number.isFinite(value)) return '–';
  const text = Math.abs(value).toFixed(digits);
  const sign = value < 0 && Number(text) !== 0 ? MINUS : '';
  const [whole = '', part] = text.split('.');
  const grouped = whole.length > 4 ? whole.replace(/\B(?=(\d{3})+$)/g, THIN) : whole;
  return sign + grouped + (part ? `.${part}` : '');
}

/** `value` with `digits` significant digits; powers of ten outside 0.0001 to 10⁶. */
export function significant(value: number, digits = 3): string {
  if (!Number.isFinite(value)) return '–';
  if (value === 0) return '0';
  const exponent = Number(value.toExponential(digits - 1).split('e')[1]);
  if (exponent >= 6 || exponent < -4) {
    const mantissa = Number(value.toExponential(digits - 1).split('e')[0]);
    return `${fixed(mantissa, digits - 1)} × 10${superscript(exponent)}`;
  }
  return fixed(value, Math.max(0, digits - 1 - exponent));
}

/** `value` with at most `digits` significant digits and no zeros at the end. */
export function short(value: number, digits = 3): string {
  const text = significant(value, digits);
  return text.includes('.') && !text.includes('×') ? text.replace(/\.?0+$/, '') : text;
}

/** A value and its standard error to the place of the error's second digit. */
export function withError(value: number, error: number | null | undefined): [string, string | null] {
  if (!error || !Number.isFinite(error)) return [significant(value, 4), null];
  const place = 1 - Number(error.toExponential(1).split('e')[1]);
  if (place > 7 || place < -4) return [significant(value, 4), significant(error, 2)];
  return [fixed(value, Math.max(0, place)), fixed(error, Math.max(0, place))];
}

function superscript(exponent: number): string {
  const digits = '⁰¹²³⁴⁵⁶⁷⁸⁹';
  const text = [...String(Math.abs(exponent))].map((digit) => digits[Number(digit)]).join('');
  return (exponent < 0 ? '⁻' : '') + text;
}

export function integer(value: number): string {
  return fixed(Math.round(value), 0);
}

export function count(number: number, noun: string): string {
  return `${integer(number)} ${noun}${number === 1 ? '' : 's'}`;
}

/** Units in the library's ASCII as they are printed. */
export function unitText(unit: string | null | undefined): string {
  return (unit ?? '')
    .replace(/\bum\b/g, 'µm')
    .replace(/\bdeg\b/g, '°')
    .replace(/\^?-1\b/g, '⁻¹')
    .replace(/\^2/g, '²');
}

/** Factor and unit to print in: micrometres below one as nm, seconds below a tenth as ms. */
export function scale(value: number, unit: string): { factor: number; unit: string } {
  const size = Math.abs(value);
  const small: Record<string, [number, number, string]> = {
    um: [1, 1e3, 'nm'],
    s: [0.1, 1e3, 'ms'],
    V: [0.01, 1e3, 'mV'],
  };
  const rule = small[unit === 'µm' ? 'um' : unit];
  if (rule && size > 0 && size < rule[0]) return { factor: rule[1], unit: rule[2] };
  return { factor: 1, unit: unitText(unit) };
}

/** A quantity as number and unit apart, nanometres below 1 µm. */
export function quantity(value: number, unit: string, digits = 3): [string, string] {
  const as = scale(value, unit);
  return [significant(value * as.factor, digits), as.unit];
}

export function quantityText(value: number, unit: string, digits = 3): string {
  return quantity(value, unit, digits).join(' ').trim();
}

export function hertz(rate: number): string {
  if (rate >= 1e6) return `${short(rate / 1e6)} MHz`;
  return rate >= 1e3 ? `${short(rate / 1e3)} kHz` : `${short(rate)} Hz`;
}

export function seconds(time: number): string {
  if (time >= 7200) return `${short(time / 3600)} h`;
  if (time >= 120) return `${short(time / 60)} min`;
  return time < 0.1 && time > 0 ? `${significant(time * 1e3)} ms` : `${significant(time)} s`;
}

/** How long something still takes; never more exact than it is known. */
export function left(time: number): string {
  if (time < 1) return 'less than 1 s left';
  if (time < 90) return `about ${Math.round(time)} s left`;
  return time < 5400 ? `about ${Math.round(time / 60)} min left` : `about ${short(time / 3600, 2)} h left`;
}

export function bytes(size: number): string {
  if (size >= 1e9) return `${short(size / 1e9)} GB`;
  if (size >= 1e6) return `${short(size / 1e6)} MB`;
  return size >= 1e3 ? `${short(size / 1e3)} kB` : `${size} B`;
}

/** The library's sentences with the symbols that a page can print. */
export function prose(text: string): string {
  return text.replace(/\bum\b/g, 'µm').replace(/(^|[\s(])-(?=\d)/g, `$1${MINUS}`);
}

export function fileName(id: string): string {
  return id.slice(id.lastIndexOf('/') + 1);
}

export function stem(id: string): string {
  return fileName(id).replace(/\.[^.]+$/, '');
}

/** A number that the library has printed. */
export function printed(text: string | null): string {
  return (text ?? '').replace(/-(?=\d)/g, MINUS).replace(/e(−?\d+)$/, (_, power: string) => {
    return ` × 10${superscript(Number(power.replace(MINUS, '-')))}`;
  });
}
