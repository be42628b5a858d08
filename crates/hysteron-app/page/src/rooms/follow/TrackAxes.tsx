// Controllers of several axes on the simulated bench.
import { useState } from 'preact/hooks';
import { path } from '../../api/client';
import type { ModelEntry, RecordEntry } from '../../api/types';
import { Operation } from '../../components/Operation';
import { RecordChosen } from '../../components/RecordsChosen';

export function TrackAxes({ model, records }: { model: ModelEntry; records: RecordEntry[] }) {
  const [record, choose] = useState('');
  return (
    <Operation
      name="track-axes"
      title="Controllers of all axes, simulated"
      about="Straight lines, decoupling at rest, the inverse with preview and with known references, and an integral around it, on the bench of several axes: errors of every axis, and how much one moves another."
      model={model.id}
      at={`${path('models', model.id)}/track-axes`}
      request={record ? { references: record } : null}
      verb="Simulate the controllers"
      save={{ name: 'track.csv' }}
    >
      <RecordChosen label="References" none="a record…" records={records} chosen={record} choose={choose} />
    </Operation>
  );
}
