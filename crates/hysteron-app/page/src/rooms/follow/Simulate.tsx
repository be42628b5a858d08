// The output for a drive that a record holds.
import { useState } from 'preact/hooks';
import { path } from '../../api/client';
import type { ModelEntry, RecordEntry } from '../../api/types';
import { Operation } from '../../components/Operation';
import { RecordChosen } from '../../components/RecordsChosen';

export function Simulate({ model, records }: { model: ModelEntry; records: RecordEntry[] }) {
  const [record, choose] = useState<string>('');
  return (
    <Operation
      name="simulate"
      title="Simulate a drive"
      about="The output of the model for the drive of a record, in free run, beside what was measured where the record holds that."
      model={model.id}
      at={`${path('models', model.id)}/simulate`}
      request={record ? { record } : null}
      verb="Simulate"
      save={{ name: 'simulated.csv' }}
    >
      <RecordChosen label="Drive of" none="a record…" records={records} chosen={record} choose={choose} />
    </Operation>
  );
}
