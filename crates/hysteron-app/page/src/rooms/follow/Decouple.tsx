// The drives of all actuators for the references of several axes.
import { useState } from 'preact/hooks';
import { path } from '../../api/client';
import type { ModelEntry, RecordEntry } from '../../api/types';
import { Operation } from '../../components/Operation';
import { RecordChosen } from '../../components/RecordsChosen';

export function Decouple({ model, records }: { model: ModelEntry; records: RecordEntry[] }) {
  const [record, choose] = useState('');
  return (
    <Operation
      name="decouple"
      title="Follow the references of all axes"
      about="The drives of all actuators, decoupled, for a record with one column for every axis, named as the model’s outputs."
      model={model.id}
      at={`${path('models', model.id)}/decouple`}
      request={record ? { references: record } : null}
      verb="Compute the drives"
      save={{ name: 'drives.csv' }}
      open
    >
      <RecordChosen label="References" none="a record…" records={records} chosen={record} choose={choose} />
    </Operation>
  );
}
