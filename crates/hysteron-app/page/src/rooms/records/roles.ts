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

export function isFit(record: RecordEntry): boolean {
  return (
    !record.error && !record.reading && ['auto', 'quasi-static', 'dynamic'].includes(record.settings.role)
  );
}

/** Records of the same device, in whose folder `of` is. */
export function sameDevice(records: RecordEntry[], of: RecordEntry): RecordEntry[] {
  return records.filter((record) => record.device === of.device);
}

/** The records of a device that a fit takes. */
export function forFit(records: RecordEntry[], of: RecordEntry): RecordEntry[] {
  return sameDevice(records, of).filter(isFit);
}

/** Changes what a person says of a record; `null` resets a field. */
export async function settings(id: string, changes: Partial<RecordSettings>): Promise<void> {
  await change('PATCH', path('records', id), changes);
  changed('records');
  changed('prospects');
  changed('models');
}
