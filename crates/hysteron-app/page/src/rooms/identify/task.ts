// What is asked of a fit: a kind of model with its options, kept in the URL where it differs from the usual.
import type { Options, RecordEntry, Schema } from '../../api/types';
import { kindOf, resolved } from '../../components/schema';
import { route, settle } from '../../route';

export interface Task {
  kind: string;
  options: Record<string, unknown>;
}

/** A kind with its usual options. */
export function usual(offered: Options, kind?: string): Task {
  const list = offered.defaults as unknown as Task[];
  return list.find((task) => task.kind === kind) ?? list[0] ?? { kind: 'hammerstein', options: {} };
}

/** The kind that all of the records call for, else the first. */
function kindFor(offered: Options, records: RecordEntry[]): string {
  const kind = records[0]?.usual_kind ?? undefined;
  return usual(offered, records.every((record) => record.usual_kind === kind) ? kind : undefined).kind;
}

/** The usual task of the chosen kind, by the URL or else by the records, with the options of the URL. */
export function asked(offered: Options, records: RecordEntry[]): Task {
  const base = usual(offered, route.value.query.get('kind') ?? kindFor(offered, records));
  try {
    const changes = JSON.parse(route.value.query.get('o') ?? '{}') as Record<string, unknown>;
    return { kind: base.kind, options: { ...base.options, ...changes } };
  } catch {
    return base;
  }
}

/** Kinds of several axes, whose inputs and outputs are named. */
export const OF_AXES = ['modes', 'branches'];

/** Names of columns in the URL. */
export function columns(of: 'inputs' | 'outputs'): string[] {
  return (route.value.query.get(of) ?? '').split(',').filter(Boolean);
}

/** What the settings ask of a fit beside its records. */
export function requested(offered: Options, records: RecordEntry[]) {
  const task = asked(offered, records);
  const axes = OF_AXES.includes(task.kind);
  const start = route.value.query.get('start');
  return {
    task,
    ...(start && task.kind === usual(offered).kind ? { start } : {}),
    ...(axes ? { inputs: columns('inputs'), outputs: columns('outputs') } : {}),
    ...(route.value.query.get('report') ? { report: true } : {}),
  };
}

export function ask(offered: Options, records: RecordEntry[], task: Task): void {
  const base = usual(offered, task.kind);
  const changes = Object.entries(task.options).filter(
    ([name, value]) => JSON.stringify(value) !== JSON.stringify(base.options[name]),
  );
  settle({
    kind: task.kind === kindFor(offered, records) ? null : task.kind,
    o: changes.length > 0 ? JSON.stringify(Object.fromEntries(changes)) : null,
  });
}

/** Schema of the options of a kind. */
export function optionsOf(schema: Schema, kind: string): Schema | null {
  for (const variant of schema.oneOf ?? schema.anyOf ?? []) {
    const own = resolved(variant, schema);
    const name = own.properties?.kind && resolved(own.properties.kind, schema);
    const is =
      name?.const === kind || (kindOf(name ?? {}, schema).kind === 'choice' && name?.enum?.[0] === kind);
    if (is && own.properties?.options) return resolved(own.properties.options, schema);
  }
  return null;
}
