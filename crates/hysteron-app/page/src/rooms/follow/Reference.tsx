// What is to be followed, and the limits of the drive.
import { useResource } from '../../api/resource';
import type { ModelDetail, Options, RecordEntry } from '../../api/types';
import { RecordChosen } from '../../components/RecordsChosen';
import { SchemaForm } from '../../components/SchemaForm';
import { significant } from '../../format';
import type { Range } from '../../plot/spec';
import { settle } from '../../route';
import { uploadReference } from '../records/uploads';
import { DRAWN, written } from './drawn';
import { DrawnForm } from './DrawnForm';

export type Specification = Record<string, unknown>;

export interface Limits {
  low: string;
  high: string;
  slew: string;
  bandwidth: string;
  rest: string;
  virgin: string;
  preview: string;
  predict: string;
  /** Record of the last run. */
  learn: string;
  periodic: boolean;
  /** The drive is corrected by the predicted misfit. */
  correct: boolean;
}

export function ReferenceForm(props: {
  specification: Specification;
  file?: RecordEntry;
  records: RecordEntry[];
  /** Of a reference drawn by hand. */
  points: Range[] | null;
  unit: string;
  /** What a drawing begins with. */
  first: string;
}) {
  const options = useResource<Options>('options').value;
  const change = (specification: Specification): void => settle({ ref: JSON.stringify(specification) });
  return (
    <div class="row wrap gaps">
      <label class="row">
        <span class="soft">Reference</span>
        <select
          value={props.file?.id ?? (props.points ? props.first : '')}
          onChange={(event) => settle({ ref: event.currentTarget.value || null })}
        >
          <option value="">a waveform</option>
          <option value={props.first}>drawn by hand</option>
          {props.records.filter(canFollow).map((record) => (
            <option key={record.id} value={record.id}>
              {record.settings.role === 'reference' ? record.id : `output of ${record.id}`}
            </option>
          ))}
        </select>
      </label>
      <label class="btn upload">
        Upload a reference…
        <input
          type="file"
          class="vh"
          onChange={(event) => {
            const file = event.currentTarget.files?.[0];
            if (file) void uploadReference(file).then((id) => id && settle({ ref: id }));
            event.currentTarget.value = '';
          }}
        />
      </label>
      {props.points && (
        <DrawnForm
          points={props.points}
          unit={props.unit}
          change={(points) => settle({ ref: DRAWN + written(points) })}
        />
      )}
      {!props.file && !props.points && options && (
        <details class="grow">
          <summary>
            Waveform: {String((props.specification.waveform as { kind?: string })?.kind ?? '')}
          </summary>
          <div class="set threes">
            <SchemaForm
              schema={options.drive}
              root={options.drive}
              value={props.specification}
              change={change}
              without={['name', 'soft_start_s', 'soft_end_s']}
              quiet={['low_v', 'high_v']}
              labels={{
                low_v: 'least value (unit of the output)',
                high_v: 'greatest value (unit of the output)',
              }}
            />
          </div>
        </details>
      )}
    </div>
  );
}

function canFollow(record: RecordEntry): boolean {
  return record.settings.role === 'reference' || (!record.error && !record.reading);
}

export function LimitsForm({
  limits,
  detail,
  runs,
}: {
  limits: Limits;
  detail: ModelDetail;
  /** Records that can be of the last run. */
  runs: RecordEntry[];
}) {
  const field = (
    name: Exclude<keyof Limits, 'periodic' | 'correct' | 'learn'>,
    label: string,
    placeholder: string,
    key: string,
  ) => (
    <input
      type="number"
      step="any"
      class="short"
      aria-label={label}
      placeholder={placeholder}
      value={limits[name]}
      onChange={(event) => settle({ [key]: event.currentTarget.value || null })}
    />
  );
  const [low, high] = detail.drive_range ?? [];
  const unit = detail.input_unit;
  return (
    <div class="row wrap gaps">
      <span class="row">
        <span class="soft">Drive</span>
        {field('low', `Least drive in ${unit}`, low != null ? significant(low) : '', 'low')}
        <span class="soft">to</span>
        {field('high', `Greatest drive in ${unit}`, high != null ? significant(high) : '', 'high')} {unit}
      </span>
      <span class="row">
        <span class="soft">Slew at most</span>
        {field('slew', `Largest slew rate in ${unit} per second`, 'no limit', 'slew')} {unit}/s
      </span>
      <span class="row">
        <span class="soft">Follows up to</span>
        {field('bandwidth', 'Bandwidth in Hz', 'as usual', 'bandwidth')} Hz
      </span>
      <label class="row">
        <input
          type="checkbox"
          checked={limits.periodic}
          onChange={(event) => settle({ periodic: event.currentTarget.checked ? '1' : null, rest: null })}
        />
        repeats, in its steady state
      </label>
      {detail.correctable && (
        <label class="row">
          <input
            type="checkbox"
            checked={limits.correct}
            onChange={(event) => settle({ correct: event.currentTarget.checked ? '1' : null })}
          />
          corrected by what the device does beside the model
        </label>
      )}
      {!limits.periodic && (
        <span class="row">
          <span class="soft">Rests before at</span>
          {field(
            'rest',
            `Drive at which the device rests before, in ${unit}`,
            'the first value',
            'rest',
          )}{' '}
          {unit}
        </span>
      )}
      <details
        class="grow"
        open={Boolean(limits.virgin || limits.preview || limits.predict || limits.learn)}
      >
        <summary>What is known ahead, demagnetisation, learning</summary>
        <div class="row wrap gaps">
          <span class="row">
            <span class="soft">Known ahead</span>
            {field('preview', 'Samples of the reference known ahead', 'all', 'preview')} samples
          </span>
          <span class="row">
            <span class="soft">Predicted up to</span>
            {field(
              'predict',
              'Highest frequency of the reference that is predicted, in Hz',
              'not',
              'predict',
            )}{' '}
            Hz
          </span>
          {!limits.periodic && (
            <span class="row">
              <span class="soft">Demagnetised at</span>
              {field('virgin', `Drive at which it was demagnetised, in ${unit}`, 'as usual', 'virgin')}{' '}
              {unit}
            </span>
          )}
          <RecordChosen
            label="Corrected by the error of the last run"
            records={runs}
            none="no run yet"
            chosen={limits.learn}
            choose={(id) => settle({ learn: id || null })}
          />
        </div>
      </details>
    </div>
  );
}
