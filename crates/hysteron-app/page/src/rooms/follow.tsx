// Room 5: which drive follows a reference within limits, and how well?
import { useEffect, useMemo, useState } from 'preact/hooks';
import { change, path, Refusal, type Complaint } from '../api/client';
import { changed, useAnswer, useLatest, useResource } from '../api/resource';
import type {
  Followed,
  ModelDetail,
  ModelEntry,
  Options,
  RecordEntry,
  Tracked,
  TrackedController,
} from '../api/types';
import { command } from '../components/dock';
import { ModelChoice, NoModel, useModel } from '../components/models';
import { SchemaForm } from '../components/SchemaForm';
import { Failure, Finding, Head, LibraryFinding, Numbers, Origin, Waiting } from '../components/words';
import { fileName, integer, prose, quantity, quantityText, significant } from '../format';
import { Plot, Swatch } from '../plot/Plot';
import type { Line, Spec } from '../plot/spec';
import { route, settle } from '../route';
import { useSignal } from '../signal';
import { asLine, axisLabel } from './records/Curves';
import { uploadReference } from './records/uploads';

const TITLE = 'Follow';
const QUESTION = 'Which drive follows my reference, within my limits, and how well?';

export function Follow() {
  const { models, model } = useModel();
  if (!models || !model) {
    return (
      <>
        <Head title={TITLE} question={QUESTION} />
        {models ? <NoModel /> : <Waiting height={300} />}
      </>
    );
  }
  return <Room key={model.id} models={models} model={model} />;
}

type Specification = Record<string, unknown>;

interface Limits {
  low: string;
  high: string;
  slew: string;
  bandwidth: string;
}

/** Ten lines a second over the middle of what the model's records reached. */
function raster(detail: ModelDetail, output: [number, number]): Specification {
  const rate = detail.sample_rate_hz ?? 1000;
  return {
    sample_rate_hz: rate,
    low_v: Number(output[0].toPrecision(3)),
    high_v: Number(output[1].toPrecision(3)),
    waveform: { kind: 'raster', line_hz: 10, lines: 12, return_fraction: 0.25, turnaround_fraction: 0.1 },
  };
}

function Room({ models, model }: { models: ModelEntry[]; model: ModelEntry }) {
  const detail = useLatest<ModelDetail>(path('models', model.id)).value;
  const records = useResource<RecordEntry[]>('records').value;
  if (!detail || !records) {
    return (
      <>
        <Head title={TITLE} question={QUESTION} />
        <Waiting height={300} />
      </>
    );
  }
  return <Ready models={models} model={model} detail={detail} records={records} />;
}

function Ready(props: {
  models: ModelEntry[];
  model: ModelEntry;
  detail: ModelDetail;
  records: RecordEntry[];
}) {
  const { model, detail, records } = props;
  const { query: asked } = useSignal(route);
  const stated = asked.get('ref');
  const specification = useMemo<Specification>(() => {
    try {
      return stated?.startsWith('{')
        ? (JSON.parse(stated) as Specification)
        : raster(detail, middle(detail));
    } catch {
      return raster(detail, middle(detail));
    }
  }, [stated, detail]);
  const file = records.find((record) => record.id === stated);
  const limits: Limits = {
    low: asked.get('low') ?? '',
    high: asked.get('high') ?? '',
    slew: asked.get('slew') ?? '',
    bandwidth: asked.get('bandwidth') ?? '',
  };
  const [from, to] = [limits.low || detail.drive_range?.[0], limits.high || detail.drive_range?.[1]];
  const reference = file ? { from: 'record', id: file.id } : { from: 'waveform', specification };
  const request = {
    reference,
    range: from != null && to != null && (limits.low || limits.high) ? [Number(from), Number(to)] : null,
    slew_per_s: limits.slew ? Number(limits.slew) : null,
    bandwidth_hz: limits.bandwidth ? Number(limits.bandwidth) : null,
  };
  const at = path('models', model.id);
  const answer = useAnswer<Followed>(`${at}/follow`, request);
  const followed = answer.value;
  useEffect(() => {
    command.value = followed?.command ?? null;
  }, [followed]);
  return (
    <>
      <Head title={TITLE} question={QUESTION}>
        <Origin simulated={model.simulated} />
        <ModelChoice models={props.models} model={model} />
        <Save at={at} request={request} ready={followed !== undefined} />
      </Head>
      <div class="stack">
        <ReferenceForm specification={specification} file={file} records={records} />
        <LimitsForm limits={limits} detail={detail} />
        {answer.error && <Failure problem={answer.error.complaint} />}
        {!followed && !answer.error && <Waiting height={72} />}
        {followed && <Result followed={followed} />}
        {followed && (
          <div class="cols g-cmp">
            <Curves followed={followed} />
            <Bench
              key={JSON.stringify(reference)}
              at={at}
              reference={reference}
              range={request.range}
              slew={request.slew_per_s}
              bandwidth={request.bandwidth_hz}
            />
          </div>
        )}
      </div>
    </>
  );
}

/** Of the range of the output that the model file states, else 0 to 10. */
function middle(detail: ModelDetail): [number, number] {
  const file = detail.file as { valid_range?: { output?: { low?: number; high?: number } } } | null;
  const low = file?.valid_range?.output?.low;
  const high = file?.valid_range?.output?.high;
  return typeof low === 'number' && typeof high === 'number' ? [low, high] : [0, 10];
}

function ReferenceForm(props: {
  specification: Specification;
  file?: RecordEntry;
  records: RecordEntry[];
}) {
  const options = useResource<Options>('options').value;
  const change = (specification: Specification): void => settle({ ref: JSON.stringify(specification) });
  return (
    <div class="row wrap gaps">
      <label class="row">
        <span class="soft">Reference</span>
        <select
          value={props.file?.id ?? ''}
          onChange={(event) => settle({ ref: event.currentTarget.value || null })}
        >
          <option value="">a waveform</option>
          {props.records.map((record) => (
            <option key={record.id} value={record.id}>
              {record.settings.role === 'reference'
                ? fileName(record.id)
                : `output of ${fileName(record.id)}`}
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
      {!props.file && options && (
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

function LimitsForm({ limits, detail }: { limits: Limits; detail: ModelDetail }) {
  const field = (name: keyof Limits, label: string, placeholder: string, key: string) => (
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
    </div>
  );
}

function Result({ followed }: { followed: Followed }) {
  const unit = followed.output_unit;
  const [predicted, predictedUnit] = quantity(followed.predicted_rms_error, unit);
  const shown = followed.shown[0];
  const list = [
    {
      label: 'predicted, rms',
      value: predicted,
      unit: predictedUnit,
      note: 'of the model with itself; what it does not know is not in it',
    },
  ];
  if (shown) {
    const [value, own] = quantity(shown.rmse, shown.unit);
    list.push({
      label: 'shown by a record, rms',
      value,
      unit: own,
      note: `of the fit, ${fileName(shown.record)}`,
    });
  }
  if (followed.band != null) {
    const [value, own] = quantity(followed.band, unit);
    list.push({
      label: '95 % band',
      value: `± ${value}`,
      unit: own,
      note: 'from the errors of the parameters',
    });
  }
  const limited = followed.samples_at_range + followed.samples_at_slew;
  list.push({
    label: 'drive',
    value: `${significant(followed.drive_low)} to ${significant(followed.drive_high)}`,
    unit: followed.input_unit,
    note:
      limited > 0
        ? `${integer(limited)} of ${integer(followed.samples)} samples at a limit`
        : 'no limit touched',
  });
  return (
    <>
      <Numbers list={list} />
      <div class="finds">
        {followed.findings.map((finding) => (
          <LibraryFinding key={finding.text} finding={finding} />
        ))}
        {followed.remarks.map((remark) => (
          <Finding key={remark} kind="warn">
            {prose(remark)}
          </Finding>
        ))}
      </div>
    </>
  );
}

function Curves({ followed }: { followed: Followed }) {
  const time = { label: 'time (s)', unit: 's' };
  const specs = useMemo<Spec[]>(() => {
    const { reference, drive, error, band } = followed;
    const x = (curve: typeof drive) => [curve.x[0] ?? 0, curve.x[curve.x.length - 1] ?? 1];
    return [
      {
        key: 'f',
        title: 'Reference',
        height: 150,
        flat: true,
        x: { ...time, hide: true },
        y: { label: axisLabel('reference', { ...reference.up, name: '' }), unit: reference.up.unit },
        lines: [asLine(reference, 'reference', 1.8)],
      },
      {
        key: 'f',
        title: 'Drive',
        height: 150,
        flat: true,
        x: { ...time, hide: true },
        y: { label: axisLabel('drive', { ...drive.up, name: '' }), unit: drive.up.unit },
        lines: [asLine(drive, 'drive', 1.8)],
      },
      {
        key: 'f',
        title: 'Predicted error',
        height: 190,
        flat: true,
        zero: true,
        x: time,
        y: { label: `reference − prediction (${error.up.unit})`, unit: error.up.unit },
        lines: [asLine(error, 'residual', 1.3)],
        band:
          band != null
            ? { name: '95 % band of the prediction', x: x(error), low: [-band, -band], high: [band, band] }
            : undefined,
      },
    ];
  }, [followed]);
  return (
    <div>
      {specs.map((spec) => (
        <Plot key={spec.title} spec={spec} />
      ))}
    </div>
  );
}

function Bench(props: {
  at: string;
  reference: unknown;
  range: number[] | null;
  slew: number | null;
  bandwidth: number | null;
}) {
  const [tracked, keep] = useState<Tracked | null>(null);
  const [problem, complain] = useState<Complaint | null>(null);
  const [busy, mark] = useState(false);
  const [chosen, choose] = useState<string[]>([]);
  const simulate = async (): Promise<void> => {
    mark(true);
    const options: Record<string, unknown> = {};
    if (props.range) options.range = props.range;
    if (props.slew) options.slew_per_s = props.slew;
    if (props.bandwidth) options.bandwidth_hz = props.bandwidth;
    try {
      const answer = await change<Tracked>('POST', `${props.at}/track`, {
        reference: props.reference,
        options,
      });
      const ranked = [...answer.controllers].sort((a, b) => (a.rms ?? Infinity) - (b.rms ?? Infinity));
      keep({ ...answer, controllers: ranked });
      choose(ranked.slice(0, 1).map((controller) => controller.name));
      complain(null);
    } catch (error) {
      complain(error instanceof Refusal ? error.complaint : { what: String(error) });
    }
    mark(false);
  };
  if (!tracked) {
    return (
      <div class="card">
        <h2>Controllers on the simulated bench</h2>
        <p class="soft gap">
          The prediction is of the model with itself. On the bench, whose truth lies outside every model
          class, the controllers show what a device may add.
        </p>
        <button type="button" onClick={() => void simulate()} aria-disabled={busy}>
          {busy ? 'Simulating all controllers…' : 'Simulate the controllers'}
        </button>
        {problem && <Failure problem={problem} />}
      </div>
    );
  }
  const toggle = (name: string): void =>
    choose(chosen.includes(name) ? chosen.filter((other) => other !== name) : [...chosen.slice(-2), name]);
  return <Controllers tracked={tracked} chosen={chosen} toggle={toggle} />;
}

const STROKES: Pick<Line, 'color' | 'dash' | 'width'>[] = [
  { color: 'band', width: 1.8 },
  { color: 'residual', dash: [6, 2], width: 1.6 },
  { color: 'k6', dash: [2, 2], width: 1.8 },
];

function Controllers(props: { tracked: Tracked; chosen: string[]; toggle: (name: string) => void }) {
  const { tracked, chosen } = props;
  const shown = chosen
    .map((name) => tracked.controllers.find((controller) => controller.name === name))
    .filter((controller): controller is TrackedController => controller !== undefined);
  const unit = tracked.output_unit;
  const spec: Spec = {
    key: 'bench',
    title: 'Error on the bench',
    description: 'Reference minus displacement of the chosen controllers.',
    height: 216,
    flat: true,
    zero: true,
    x: { label: 'time (s)', unit: 's' },
    y: { label: `reference − y (${unit})`, unit },
    lines: shown.map((controller, i) => ({
      ...asLine(controller.curves.error, 'band', 1.5, controller.name),
      ...STROKES[i % STROKES.length],
    })),
  };
  return (
    <div class="stack">
      {shown.length > 0 && <Plot spec={spec} />}
      <div class="tw">
        <table class="mid">
          <caption>
            Controllers on the simulated bench <span class="tag sim">simulated</span>
          </caption>
          <thead>
            <tr>
              <th scope="col">Controller</th>
              <th scope="col" class="n">
                Error rms
              </th>
              <th scope="col" class="n">
                largest
              </th>
              <th scope="col" class="n">
                Gain <small>margin</small>
              </th>
            </tr>
          </thead>
          <tbody>
            {tracked.controllers.map((controller) => {
              const at = chosen.indexOf(controller.name);
              return (
                <tr key={controller.name} class={at >= 0 ? 'sel' : ''}>
                  <td title={controller.summary}>
                    <label class="row">
                      <input
                        type="checkbox"
                        checked={at >= 0}
                        onChange={() => props.toggle(controller.name)}
                      />
                      {controller.name}
                      {at >= 0 && (
                        <span class="lg">
                          <Swatch line={STROKES[at % STROKES.length] as Line} />
                        </span>
                      )}
                      {controller.samples_held_back > 0 && <span class="tag warn">at limit</span>}
                    </label>
                  </td>
                  {controller.runs_away ? (
                    <td colSpan={2} class="soft">
                      fails to follow
                    </td>
                  ) : (
                    <>
                      <td class="n">{controller.rms != null ? quantityText(controller.rms, unit) : '–'}</td>
                      <td class="n">{controller.max != null ? quantityText(controller.max, unit) : '–'}</td>
                    </>
                  )}
                  <td class="n">
                    {controller.gain_margin != null ? significant(controller.gain_margin, 2) : 'none'}
                  </td>
                </tr>
              );
            })}
          </tbody>
        </table>
        <p class="soft s">
          {prose(tracked.plant)} Scored from {significant(tracked.scored_s[0])} to{' '}
          {significant(tracked.scored_s[1])} s.
          {tracked.left_out.length > 0 ? ` Left out: ${tracked.left_out.join('; ')}.` : ''}
        </p>
      </div>
    </div>
  );
}

const ENDINGS = ['csv', 'npz', 'mat'];

/** Writes the drive into the workspace and hands it to the browser. */
function Save({ at, request, ready }: { at: string; request: object; ready: boolean }) {
  const [ending, choose] = useState('csv');
  const [problem, complain] = useState<Complaint | null>(null);
  const save = async (): Promise<void> => {
    try {
      const name = `drive.${ending}`;
      const written = await change<Followed>('POST', `${at}/follow`, { ...request, save: name });
      changed('records');
      if (written.file) {
        const link = document.createElement('a');
        link.href = `api/v1/${path('records', written.file)}/file`;
        link.download = name;
        link.click();
      }
      complain(null);
    } catch (error) {
      complain(error instanceof Refusal ? error.complaint : { what: String(error) });
    }
  };
  return (
    <>
      {problem && <span class="tag bad">{problem.what}</span>}
      <select
        aria-label="Format of the drive"
        value={ending}
        onChange={(event) => choose(event.currentTarget.value)}
      >
        {ENDINGS.map((name) => (
          <option key={name} value={name}>
            {name.toUpperCase()}
          </option>
        ))}
      </select>
      <button type="button" class="primary" disabled={!ready} onClick={() => void save()}>
        Download the drive
      </button>
    </>
  );
}
