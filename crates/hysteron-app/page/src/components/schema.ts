// JSON schemas as kinds of fields, so that a form is made from what the library offers and not typed twice.
import type { Schema } from '../api/types';

export interface Option {
  /** How it is called. */
  label: string;
  summary?: string;
  /** Value of the field when it is chosen, or where its own fields begin. */
  value: unknown;
  /** Fields that the option has itself. */
  inner?: Schema;
  matches: (value: unknown) => boolean;
}

export type Kind =
  | { kind: 'switch' }
  | { kind: 'number'; whole: boolean; schema: Schema }
  | { kind: 'text' }
  | { kind: 'numbers' }
  | { kind: 'texts' }
  | { kind: 'ranges' }
  | { kind: 'several'; options: Option[] }
  | { kind: 'choice'; options: Option[] }
  | { kind: 'group'; fields: [string, Schema][] }
  | { kind: 'json' };

export function resolved(schema: Schema, root: Schema): Schema {
  let now = schema;
  for (let depth = 0; depth < 20; depth++) {
    if (now.$ref) {
      const name = now.$ref.split('/').pop() ?? '';
      const { $ref: _, ...rest } = now;
      now = { ...root.$defs?.[name], ...rest };
    } else if (now.allOf?.length === 1 && now.allOf[0]) {
      const { allOf, ...rest } = now;
      now = { ...allOf[0], ...rest };
    } else break;
  }
  return now;
}

const isNull = (schema: Schema): boolean => schema.type === 'null';

/** The schema without `null`, and whether `null` was allowed. */
export function optional(schema: Schema, root: Schema): { schema: Schema; nullable: boolean } {
  const now = resolved(schema, root);
  const variants = now.anyOf ?? now.oneOf;
  if (variants?.some(isNull)) {
    const rest = variants.filter((variant) => !isNull(variant));
    const only = rest.length === 1 && rest[0] ? resolved(rest[0], root) : { oneOf: rest };
    return { schema: { ...only, description: now.description ?? only.description }, nullable: true };
  }
  if (Array.isArray(now.type) && now.type.includes('null')) {
    const types = now.type.filter((type) => type !== 'null');
    return { schema: { ...now, type: types.length === 1 ? types[0] : types }, nullable: true };
  }
  return { schema: now, nullable: false };
}

export function kindOf(given: Schema, root: Schema): Kind {
  const schema = resolved(given, root);
  const variants = schema.oneOf ?? schema.anyOf;
  if (schema.enum) return { kind: 'choice', options: schema.enum.map((value) => constant(value)) };
  if (variants) return { kind: 'choice', options: variants.flatMap((variant) => variantOf(variant, root)) };
  switch (schema.type) {
    case 'boolean':
      return { kind: 'switch' };
    case 'integer':
    case 'number':
      return { kind: 'number', whole: schema.type === 'integer', schema };
    case 'string':
      return { kind: 'text' };
    case 'array': {
      const item = schema.items && resolved(schema.items, root);
      if (item?.type === 'number' || item?.type === 'integer') return { kind: 'numbers' };
      if (item?.type === 'array' && item.maxItems === 2) return { kind: 'ranges' };
      if (item?.type === 'string' && !item.enum) return { kind: 'texts' };
      const choice = item && kindOf(item, root);
      const plain = choice?.kind === 'choice' && choice.options.every((option) => !option.inner);
      return plain ? { kind: 'several', options: choice.options } : { kind: 'json' };
    }
    default:
      return schema.properties
        ? { kind: 'group', fields: Object.entries(schema.properties) }
        : { kind: 'json' };
  }
}

function constant(value: unknown, summary?: string): Option {
  const same = (other: unknown): boolean => JSON.stringify(other) === JSON.stringify(value);
  return { label: words(String(value)), summary, value, matches: same };
}

function variantOf(given: Schema, root: Schema): Option[] {
  const schema = resolved(given, root);
  const summary = schema.description;
  if (schema.const !== undefined) return [constant(schema.const, summary)];
  if (schema.enum)
    return schema.enum.map((value) => constant(value, schema.enum?.length === 1 ? summary : undefined));
  const nested = schema.oneOf ?? schema.anyOf;
  if (nested) return nested.flatMap((variant) => variantOf(variant, root));
  const isObject = (value: unknown): value is Record<string, unknown> =>
    typeof value === 'object' && value !== null;
  const properties = Object.entries(schema.properties ?? {});
  const tag = properties.find(([, property]) => resolved(property, root).const !== undefined);
  if (tag) {
    const [name, property] = tag;
    const value = resolved(property, root).const;
    const inner = { ...schema, properties: Object.fromEntries(properties.filter(([key]) => key !== name)) };
    const initial = { [name]: value, ...(start(inner, root) as object) };
    const matches = (other: unknown): boolean => isObject(other) && other[name] === value;
    return [{ label: words(String(value)), summary, value: initial, inner, matches }];
  }
  if (properties.length === 1 && properties[0]) {
    const [name, property] = properties[0];
    const matches = (other: unknown): boolean => isObject(other) && name in other;
    const initial = { [name]: start(property, root) };
    return [{ label: words(name), summary, value: initial, inner: schema, matches }];
  }
  const types = Array.isArray(schema.type) ? schema.type : [schema.type];
  const label = types.includes('number') || types.includes('integer') ? 'given' : (schema.title ?? 'given');
  const matches = (other: unknown): boolean =>
    types.includes('number') || types.includes('integer') ? typeof other === 'number' : isObject(other);
  return [{ label, summary, value: start(schema, root), inner: schema, matches }];
}

/** A value to begin with: the default, else the least that the schema takes. */
export function start(given: Schema, root: Schema): unknown {
  const { schema, nullable } = optional(given, root);
  if (given.default !== undefined) return given.default;
  if (schema.default !== undefined) return schema.default;
  if (nullable) return null;
  const kind = kindOf(schema, root);
  switch (kind.kind) {
    case 'switch':
      return false;
    case 'number':
      return Math.max(1, schema.minimum ?? 1);
    case 'numbers':
      return [1];
    case 'texts':
    case 'ranges':
    case 'several':
      return [];
    case 'text':
      return '';
    case 'choice':
      return kind.options[0]?.value ?? null;
    case 'group':
      return Object.fromEntries(kind.fields.map(([name, field]) => [name, start(field, root)]));
    case 'json':
      return schema.type === 'array' ? [] : {};
  }
}

const UNITS: [RegExp, string][] = [
  [/_um_per_v$/, ' (µm/V)'],
  [/_um_per_s$/, ' (µm/s)'],
  [/_per_um2$/, ' (1/µm²)'],
  [/_per_um$/, ' (1/µm)'],
  [/_per_s$/, ' (per s)'],
  [/_hz$/, ' (Hz)'],
  [/_ms$/, ' (ms)'],
  [/_percent$/, ' (%)'],
  [/_um$/, ' (µm)'],
  [/_s$/, ' (s)'],
  [/_v$/, ' (V)'],
];

/** `sample_rate_hz` as `sample rate (Hz)`. */
export function words(name: string): string {
  for (const [ending, unit] of UNITS) {
    if (ending.test(name)) return name.replace(ending, '').replace(/_/g, ' ') + unit;
  }
  return name.replace(/_/g, ' ');
}

/** Documentation of the library as a sentence to read: without marks of the source. */
export function plain(text: string | undefined): string {
  return (text ?? '')
    .replace(/\[`?([^\]`]*)`?\]\([^)]*\)/g, '$1')
    .replace(/\[`([^`]*)`\]/g, '$1')
    .replace(/\\([[\]])/g, '$1')
    .replace(/`/g, '')
    .replace(/\bNone\b/g, 'as usual')
    .replace(/ \(\w*[a-z][A-Z]\w*\)/g, '')
    .replace(/\b[A-Z]\w+::([A-Z]\w+)/g, (_, name: string) => name.toLowerCase())
    .replace(/\s+/g, ' ')
    .trim();
}
