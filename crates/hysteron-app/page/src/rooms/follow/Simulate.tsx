// The output for a drive that a record holds.
import { useState } from 'preact/hooks';
import { path } from '../../api/client';
import type { ModelEntry, RecordEntry } from '../../api/types';
import { Operation } from '../../components/Operation';
import { RecordsChosen } from '../../components/RecordsChosen';

export function Simulate({ model, records }: { model: ModelEntry; records: RecordEntry[] }) {
  const [chosen, choose] = useState<string[]>([]);
  return (
    <Operation
      name="simulate"
      title="Simulate a drive"
      about="The output of the model for the drive of a record, in free run, beside what was measured where the record holds that."
      model={model.id}
      at={`${path('models', model.id)}/simulate`}
      request={chosen.length > 0 ? { records: chosen } : null}
      verb="Simulate"
      save={{ name: 'simulated.csv' }}
    >
      <RecordsChosen
        label="Drive of; several are parts of one run"
        records={records}
        chosen={chosen}
        choose={choose}
      />
    </Operation>
  );
}
