// A drive for the next measurement, made by the library and saved into the workspace.
import { useEffect, useState } from 'preact/hooks';
import { change, Refusal, type Complaint } from '../../api/client';
import { changed, useResource } from '../../api/resource';
import type { Curve, Options, RecordDetail } from '../../api/types';
import { Failure, Finding } from '../../components/words';
import { SchemaForm } from '../../components/SchemaForm';
import { Plot } from '../../plot/Plot';
import { asLine, axisLabel } from './Curves';

interface Made {
  drive: Curve;
  file: string | null;
}

/** A sweep over the range and at the rate of the record: the form changes it. */
function first(record: RecordDetail): Record<string, unknown> {
  const input = record.inspection?.input;
  const short = (value: number): number => Number(value.toPrecision(3));
  const low = short(record.inspection?.drive.low_hz ?? 1);
  return {
    sample_rate_hz: record.rate_hz ?? 1000,
    low_v: short(input?.low ?? 0),
    high_v: short(input?.high ?? 10),
    waveform: { kind: 'sweep', law: 'logarithmic', start_hz: low, end_hz: 100, duration_s: 10 },
  };
}

export function DriveMaker({ record }: { record: RecordDetail }) {
  const options = useResource<Options>('options').value;
  const [specification, specify] = useState(() => first(record));
  const [name, rename] = useState('drive.csv');
  const [made, keep] = useState<Made | null>(null);
  const [problem, complain] = useState<Complaint | null>(null);

  const make = async (save: string | null): Promise<void> => {
    try {
      keep(await change<Made>('POST', 'drives', { specification, save, pixels: 1000 }));
      complain(null);
      if (save) changed('records');
    } catch (error) {
      complain(error instanceof Refusal ? error.complaint : { what: String(error) });
    }
  };
  useEffect(() => void make(null), [specification]);

  if (!options) return null;
  return (
    <div class="card stack">
      <h2>A drive for the next measurement</h2>
      <div class="cols g-plots">
        <div class="set twos">
          <SchemaForm
            schema={options.drive}
            root={options.drive}
            value={specification}
            change={specify}
            without={['name']}
          />
        </div>
        <div class="stack">
          {problem && <Failure problem={problem} />}
          {made && (
            <Plot
              spec={{
                key: 'drive',
                title: 'Drive',
                height: 220,
                flat: true,
                x: { label: 'time (s)', unit: 's' },
                y: { label: axisLabel('drive', made.drive.up), unit: made.drive.up.unit },
                lines: [asLine(made.drive, 'drive', 1.3)],
              }}
            />
          )}
          <form
            class="row wrap"
            onSubmit={(event) => {
              event.preventDefault();
              void make(name);
            }}
          >
            <label class="row">
              <span class="soft">File</span>
              <input type="text" value={name} onInput={(event) => rename(event.currentTarget.value)} />
            </label>
            <button type="submit">Write it into the workspace</button>
          </form>
          {made?.file && <Finding kind="good">Written to {made.file}.</Finding>}
        </div>
      </div>
    </div>
  );
}
