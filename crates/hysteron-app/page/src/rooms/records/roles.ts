// Roles of records and how runs are joined.
import { change, path } from '../../api/client';
import { changed } from '../../api/resource';
import type { RecordEntry, RecordSettings, Role } from '../../api/types';

export const ROLES: [Role, string][] = [
  ['auto', 'fit'],
  ['quasi-static', 'fit, slow loop'],
  ['dynamic', 'fit, dynamics'],
  ['validate', 'validate'],
  ['reference', 'reference'],
  ['unused', 'unused'],
];

export function roleName(role: Role): string {
  return ROLES.find(([name]) => name === role)?.[1] ?? role;
}

/** Roles of records that a fit takes. */
export const FITTED: Role[] = ['auto', 'quasi-static', 'dynamic'];

export function isFit(record: RecordEntry): boolean {
  return !record.error && !record.reading && record.usable && FITTED.includes(record.settings.role);
}

/** Whether a fit of several axes may take it: its columns are named there, and no one of them is the input. */
export function isFitOfAxes(record: RecordEntry): boolean {
  return record.samples > 0 && !record.reading && FITTED.includes(record.settings.role);
}

/** Those whose quantities are the ones of most of them: a fit has one input and one output. */
export function ofOneKind(records: RecordEntry[]): RecordEntry[] {
  const kind = (record: RecordEntry): string => `${record.input_unit} → ${record.output_unit}`;
  const counts = new Map<string, number>();
  for (const record of records) counts.set(kind(record), (counts.get(kind(record)) ?? 0) + 1);
  const [most] = [...counts].sort((a, b) => b[1] - a[1])[0] ?? [];
  return records.filter((record) => kind(record) === most);
}

/** Records of the same device, in whose folder `of` is. */
export function sameDevice(records: RecordEntry[], of: RecordEntry): RecordEntry[] {
  return records.filter((record) => record.device === of.device);
}

/** The records of a device that a fit takes. */
export function forFit(records: RecordEntry[], of: RecordEntry): RecordEntry[] {
  const fit = sameDevice(records, of).filter(isFit);
  const alike = fit.filter(
    (record) => record.input_unit === of.input_unit && record.output_unit === of.output_unit,
  );
  return alike.includes(of) ? alike : ofOneKind(fit);
}

/** Changes what a person says of a record; `null` resets a field. */
export async function settings(id: string, changes: Partial<RecordSettings>): Promise<void> {
  await change('PATCH', path('records', id), changes);
  changed('records');
  changed('prospects');
  changed('models');
}
