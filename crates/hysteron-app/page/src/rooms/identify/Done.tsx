// A model: how well it describes its records, and how sure each number is.
import { useEffect, useMemo, useState } from 'preact/hooks';
import { change, path, query, Refusal, type Complaint } from '../../api/client';
import { changed, deletedAt, useLatest } from '../../api/resource';
import type { ModelCurves, ModelDetail, RecordDetail, RecordEntry } from '../../api/types';
import { deleted } from '../../components/undo';
import { Failure, Finding, LibraryFinding, Numbers, Waiting } from '../../components/words';
import { fileName, prose, quantity, significant } from '../../format';
import { Plot } from '../../plot/Plot';
import type { Spec } from '../../plot/spec';
import { zoomOf } from '../../plot/zoom';
import { go, route } from '../../route';
import { useSignal } from '../../signal';
import { asLine, axisLabel } from '../records/Curves';
import { NextDrive } from './NextDrive';
import { Parameters } from './Parameters';

export function curveOf(curves: ModelCurves | undefined, name: string) {
  return curves?.series.find((series) => series.name === name)?.curve;
}

/** Identifiers of the records of a model that lie in the workspace. */
export function recordsOf(
  model: { records: string[]; device: string },
  records: RecordEntry[],
): RecordEntry[] {
  const found = model.records.map(
    (name) =>
      records.find((record) => record.id === name) ??
      records.find((record) => record.device === model.device && fileName(record.id) === fileName(name)) ??
      records.find((record) => fileName(record.id) === fileName(name)),
  );
  return [...new Set(found.filter((record) => record !== undefined))];
}

export function Done({ id, records }: { id: string; records: RecordEntry[] }) {
  const { query: asked } = useSignal(route);
  const answer = useLatest<ModelDetail>(path('models', id));
  const model = answer.value;
  const own = model ? recordsOf(model, records) : [];
  const chosen = own.find((record) => record.id === asked.get('rec')) ?? own[0];
  if (answer.error) return <Failure problem={answer.error.complaint} />;
  if (!model) return <Boxes />;
  if (model.error) return <Failure problem={model.error} />;
  return (
    <div class="stack">
      {own.length > 1 && (
        <div class="seg wrap" role="group" aria-label="Record that is shown">
          {own.map((record) => (
            <button
              type="button"
              key={record.id}
              aria-pressed={record === chosen}
              onClick={() => go({ rec: record.id, 'z.loop': null, 'z.residual': null })}
            >
              {fileName(record.id)}
            </button>
          ))}
        </div>
      )}
      {chosen ? (
        <Fit id={id} record={chosen.id} origin={originOf(chosen)} />
      ) : (
        <Finding kind="note">
          The records of this model are not in the workspace, so that only its numbers are shown:{' '}
          {model.records.join(', ')}.
        </Finding>
      )}
      <div class="finds">
        {model.interrupted && (
          <Finding kind="warn">
            <b>Best so far of an interrupted fit.</b> The fit can go on from the history.
          </Finding>
        )}
        {model.findings.map((finding) => (
          <LibraryFinding key={finding.text} finding={finding} />
        ))}
      </div>
      <Parameters model={model} record={chosen?.id} />
      {model.kind === 'hammerstein' && <NextDrive model={id} device={model.device} />}
    </div>
  );
}

function Boxes() {
  return (
    <div class="stack">
      <Waiting height={78} />
      <div class="cols g-plots">
        <Waiting height={400} />
        <Waiting height={400} />
      </div>
      <Waiting height={300} />
    </div>
  );
}

function Fit({ id, record, origin }: { id: string; record: string; origin: Of }) {
  const at = `${path('models', id)}/curves`;
  const zoom = zoomOf('t');
  const window = { from: zoom?.x[0], to: zoom?.x[1], pixels: 1000 };
  const loop = useLatest<ModelCurves>(at + query({ record, view: 'loop', pixels: 700 }));
  const across = useLatest<ModelCurves>(at + query({ record, view: 'residual-loop', pixels: 700 }));
  const residual = useLatest<ModelCurves>(at + query({ record, view: 'residual', ...window }));
  const detail = useLatest<RecordDetail>(path('records', record)).value;
  const loopSpec = useMemo(() => loopOf(loop.value, origin), [loop.value, origin]);
  const acrossSpec = useMemo(() => acrossOf(across.value, origin), [across.value, origin]);
  const residualSpec = useMemo(() => residualOf(residual.value, origin), [residual.value, origin]);
  const failed = loop.error ?? residual.error ?? across.error;
  if (failed) return <Failure problem={failed.complaint} />;
  return (
    <>
      {loop.value ? (
        <Scores curves={loop.value} floor={detail?.inspection?.noise_floor_rms ?? null} />
      ) : (
        <Waiting height={78} />
      )}
      <div class="cols g-plots">
        {loopSpec ? <Plot spec={loopSpec} /> : <Waiting height={400} />}
        <div>
          {residualSpec ? <Plot spec={residualSpec} /> : <Waiting height={222} />}
          {acrossSpec ? <Plot spec={acrossSpec} /> : <Waiting height={204} />}
        </div>
      </div>
      {loop.value && loop.value.remarks.length > 0 && (
        <p class="soft s">{loop.value.remarks.map(prose).join(' ')}</p>
      )}
    </>
  );
}

function Scores({ curves, floor }: { curves: ModelCurves; floor: number | null }) {
  const { scores } = curves;
  const percent = (value: number | null): string =>
    value == null ? '' : `${significant(value, 3)} % of stroke`;
  const [rmse, unit] = quantity(scores.rmse, scores.unit);
  const [most, mostUnit] = quantity(scores.max_abs_error, scores.unit);
  const list = [
    { label: 'RMSE', value: rmse, unit, note: percent(scores.rmse_percent_of_stroke) },
    { label: 'largest error', value: most, unit: mostUnit, note: percent(scores.max_percent_of_stroke) },
  ];
  if (scores.fit_percent != null) {
    const value = scores.fit_percent.toFixed(2);
    list.push({ label: 'fit', value, unit: '%', note: '100 is perfect, 0 as good as a constant' });
  }
  if (floor != null) {
    const [value, own] = quantity(floor, scores.unit);
    list.push({ label: 'noise floor', value, unit: own, note: floorNote(floor, scores.rmse) });
  }
  return <Numbers list={list} />;
}

/** Where a record comes from, as legends name its curve. */
export type Of = 'measured' | 'simulated';

export const originOf = (record: { simulated: boolean } | undefined): Of =>
  record?.simulated ? 'simulated' : 'measured';

/** An estimate of the noise: fourth differences also count what the drive itself makes quickly. */
export const floorNote = (floor: number, rmse: number | undefined): string =>
  rmse !== undefined && floor > rmse
    ? 'an upper bound: the RMSE shows less'
    : 'rms of the sensor, estimated';

export function loopOf(curves: ModelCurves | undefined, origin: Of): Spec | null {
  const measured = curveOf(curves, 'measured');
  if (!curves || !measured) return null;
  return {
    key: 'loop',
    title: `Loop: ${measured.shown}`,
    description: `Loop of the record (${origin}) and model.`,
    height: 356,
    loop: true,
    x: { label: axisLabel('drive', measured.across), unit: measured.across.unit },
    y: { label: axisLabel('output', measured.up), unit: measured.up.unit },
    lines: [
      asLine(measured, 'measured', 4, origin),
      asLine(curveOf(curves, 'model'), 'model', 1.3, 'model'),
    ],
    tools: ['zoom', 'pan'],
  };
}

function bandOf(curves: ModelCurves): Spec['band'] {
  const low = curveOf(curves, 'band-low');
  const high = curveOf(curves, 'band-high');
  return low && high && { name: '95 % of a new measurement', x: low.x, low: low.y, high: high.y };
}

export function timeOf(curves: ModelCurves | undefined, origin: Of): Spec | null {
  const measured = curveOf(curves, 'measured');
  if (!curves || !measured) return null;
  return {
    key: 't',
    title: 'Time',
    description: `Output of the record (${origin}) and model over time.`,
    height: 166,
    flat: true,
    x: { label: 'time (s)', unit: 's', range: [measured.across.low, measured.across.high], hide: true },
    y: { label: axisLabel('output', measured.up), unit: measured.up.unit },
    lines: [
      asLine(measured, 'measured', 3, origin),
      asLine(curveOf(curves, 'model'), 'model', 1.1, 'model'),
    ],
    band: bandOf(curves),
    tools: ['zoom', 'pan'],
  };
}

export function residualOf(curves: ModelCurves | undefined, origin: Of): Spec | null {
  const residual = curveOf(curves, 'residual');
  if (!curves || !residual) return null;
  const most = Math.max(Math.abs(residual.up.low), Math.abs(residual.up.high)) * 1.05 || 1;
  return {
    key: 't',
    title: 'Residual over time',
    description: 'Record minus model over time.',
    height: 178,
    flat: true,
    zero: true,
    x: { label: 'time (s)', unit: 's', range: [residual.across.low, residual.across.high] },
    y: { label: `${origin} − model (${residual.up.unit})`, unit: residual.up.unit, range: [-most, most] },
    lines: [asLine(residual, 'residual', 1)],
    band: bandOf(curves),
    tools: ['zoom', 'pan'],
  };
}

function acrossOf(curves: ModelCurves | undefined, origin: Of): Spec | null {
  const residual = curveOf(curves, 'residual');
  if (!residual) return null;
  const most = Math.max(Math.abs(residual.up.low), Math.abs(residual.up.high)) * 1.05 || 1;
  return {
    key: 'across',
    title: 'Residual over the drive',
    description: 'Record minus model over the drive: what the shape of the loop misses.',
    height: 178,
    loop: true,
    zero: true,
    x: { label: axisLabel('drive', residual.across), unit: residual.across.unit },
    y: { label: `${origin} − model (${residual.up.unit})`, unit: residual.up.unit, range: [-most, most] },
    lines: [asLine(residual, 'residual', 0.9)],
  };
}

/** What is to be known of a model beside its numbers, its name and its end. */
export function About({ id }: { id: string }) {
  const model = useLatest<ModelDetail>(path('models', id)).value;
  const [name, rename] = useState<string | null>(null);
  const [problem, complain] = useState<Complaint | null>(null);
  useEffect(() => rename(null), [id]);
  if (!model) return null;
  const facts: [string, string | null][] = [
    ['Hysteresis', model.hysteresis],
    ['Dynamics', model.dynamics],
    ['Valid', model.valid_range],
    ['Made', model.made && model.made.replace('T', ' ').replace(/:\d\d(\.\d+)?Z$/, ' UTC')],
  ];
  const act = async (work: Promise<unknown>): Promise<void> => {
    complain(null);
    await work.catch((error: unknown) => {
      complain(error instanceof Refusal ? error.complaint : { what: String(error) });
    });
    changed('models');
  };
  const keep = async (): Promise<void> => {
    const renamed = await change<{ id: string }>('PATCH', path('models', id), { name });
    if (!renamed?.id) return;
    deletedAt(path('models', id));
    go({ m: renamed.id });
  };
  const remove = async (): Promise<void> => {
    deletedAt(path('models', id));
    const { token } = await change<{ token: string }>('DELETE', path('models', id));
    deleted({ token, id });
    go({ m: null });
  };
  return (
    <div class="hr stack tight">
      <h2>About this model</h2>
      <dl class="facts">
        {facts.map(
          ([key, text]) =>
            text && (
              <>
                <dt>{key}</dt>
                <dd>{prose(text)}</dd>
              </>
            ),
        )}
      </dl>
      {model.treatment.length > 0 && (
        <details>
          <summary>How the data were treated</summary>
          <ul class="plain dots">
            {model.treatment.map((text) => (
              <li key={text}>{prose(text)}</li>
            ))}
          </ul>
        </details>
      )}
      <form
        class="row wrap"
        onSubmit={(event) => {
          event.preventDefault();
          if (name) void act(keep());
        }}
      >
        <input
          type="text"
          aria-label="Name of the model"
          value={name ?? model.name}
          onInput={(event) => rename(event.currentTarget.value)}
        />
        <button type="submit" disabled={!name || name === model.name}>
          Rename
        </button>
        <button type="button" title="To the trash folder, can be undone" onClick={() => void act(remove())}>
          Delete
        </button>
      </form>
      {problem && <Failure problem={problem} />}
    </div>
  );
}
