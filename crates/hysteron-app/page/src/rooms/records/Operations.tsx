// What can be made of records: a prepared one, structures for their frequency response.
import { useState } from 'preact/hooks';
import type { RecordEntry } from '../../api/types';
import { Operation } from '../../components/Operation';
import { RecordsChosen } from '../../components/RecordsChosen';
import { stem } from '../../format';
import { sameDevice } from './roles';

/** The other records of the device that were read. */
function othersOf(record: RecordEntry, records: RecordEntry[]): RecordEntry[] {
  return sameDevice(records, record).filter((other) => other.id !== record.id && !other.error);
}

/** Name of a file beside a record. */
function besideRecord(record: RecordEntry, ending: string): string {
  return `${record.device ? `${record.device}/` : ''}${stem(record.id)}${ending}`;
}

export function PrepareRecords({ record, records }: { record: RecordEntry; records: RecordEntry[] }) {
  const [others, choose] = useState<string[]>([]);
  const joined = othersOf(record, records);
  return (
    <Operation
      name="prepare"
      title="Prepare a new record"
      about="Renames, selects, joins, scales, detrends, resamples; cut and scales that were set above are kept. The record itself is never changed."
      at="prepare"
      request={{ records: [record.id, ...others] }}
      verb="Write the new record"
      save={{ name: besideRecord(record, '-prepared.csv'), always: true }}
    >
      {joined.length > 0 && (
        <RecordsChosen label="Joined behind it" records={joined} chosen={others} choose={choose} />
      )}
    </Operation>
  );
}

export function ResponseFit({ record, records }: { record: RecordEntry; records: RecordEntry[] }) {
  const [others, choose] = useState<string[]>([]);
  const more = othersOf(record, records);
  return (
    <Operation
      name="frequency-response"
      title="Fit structures to a frequency response"
      about="Of a file with a measured response, or of records of periodic multisines: same lines, other phases, which tell noise from distortion."
      at="frequency-response"
      request={{ files: [record.id, ...others] }}
      verb="Fit structures"
      save={{ name: besideRecord(record, '-response.json') }}
    >
      {!record.error && more.length > 0 && (
        <RecordsChosen label="Together with" records={more} chosen={others} choose={choose} />
      )}
    </Operation>
  );
}
