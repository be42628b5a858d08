// What new records do to a model: gain, delay and offset anew, or a drift that is followed.
import { useState } from 'preact/hooks';
import { path } from '../../api/client';
import type { ModelEntry, RecordEntry } from '../../api/types';
import { Operation } from '../../components/Operation';
import { RecordChosen, RecordsChosen } from '../../components/RecordsChosen';

export function Recalibrate({ model, records }: { model: ModelEntry; records: RecordEntry[] }) {
  const [chosen, choose] = useState<string[]>(records.slice(0, 1).map((record) => record.id));
  return (
    <Operation
      name="recalibrate"
      title="Recalibrate on records of today"
      about="Gain, delay and offset anew from short records, the shape of the loop held; the old numbers with their standard errors count as knowledge, and a real change is told from noise."
      model={model.id}
      at={`${path('models', model.id)}/recalibrate`}
      request={chosen.length > 0 ? { records: chosen } : null}
      verb="Recalibrate"
      save={{ name: model.id.replace(/\.json$/, '-recalibrated.json'), always: true }}
    >
      <RecordsChosen label="Records" records={records} chosen={chosen} choose={choose} />
    </Operation>
  );
}

export function Adapt({ model, records }: { model: ModelEntry; records: RecordEntry[] }) {
  const [record, choose] = useState(records[0]?.id ?? '');
  return (
    <Operation
      name="adapt"
      title="Follow a drift over a record"
      about="Corrects the model sample by sample, as a controller would, with a monitor that says where it no longer fits."
      model={model.id}
      at={`${path('models', model.id)}/adapt`}
      request={record ? { record } : null}
      verb="Follow the drift"
      save={{ name: model.id.replace(/\.json$/, '-adapted.json') }}
    >
      <RecordChosen label="Record" records={records} chosen={record} choose={choose} />
    </Operation>
  );
}
