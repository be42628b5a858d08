// Room 4: how right is the model on records it has not seen?
import type { ComponentChildren } from 'preact';
import { useEffect, useMemo } from 'preact/hooks';
import { change, path, query, Refusal } from '../../api/client';
import { useAll, useAnswer, useLatest, useResource } from '../../api/resource';
import type {
  GainPhase,
  Judged,
  ModelCurves,
  ModelDetail,
  ModelEntry,
  RecordEntry,
  Responses,
  Scored,
} from '../../api/types';
import { command } from '../../components/dock';
import { SaveAs } from '../../components/SaveAs';
import { ModelChoice, NoModel, useModel } from '../../components/models';
import { Failure, Finding, Head, Lacking, Origin, Waiting } from '../../components/words';
import { TableBox } from '../../components/window';
import { fileName, prose, quantity, significant } from '../../format';
import { Plot } from '../../plot/Plot';
import type { Line, Spec } from '../../plot/spec';
import { zoomOf } from '../../plot/zoom';
import { address, go, route, settle } from '../../route';
import { useSignal } from '../../signal';
import { Adapt, Recalibrate } from './Operations';
import { loopOf, originOf, recordsOf, residualOf, timeOf, type Of } from '../identify/Done';

const TITLE = 'Validate';
const QUESTION = 'How right is the model on records it has not seen?';

export function Validate() {
  const { models, model } = useModel();
  const records = useResource<RecordEntry[]>('records').value;
  if (!models || !records) {
    return (
      <>
        <Head title={TITLE} question={QUESTION} />
        <Waiting height={180} />
      </>
    );
  }
  if (!model) {
    return (
      <>
        <Head title={TITLE} question={QUESTION} />
        <NoModel />
      </>
    );
  }
  return <Judgement models={models} model={model} records={records} />;
}

function Judgement({
  models,
  model,
  records,
}: {
  models: ModelEntry[];
  model: ModelEntry;
  records: RecordEntry[];
}) {
  const { query: asked } = useSignal(route);
  const detail = useLatest<ModelDetail>(path('models', model.id)).value;
  const correctable = detail?.correctable ?? false;
  const fitted = recordsOf(model, records);
  const usable = records.filter((record) => record.device === model.device && !record.error);
  const held = usable.filter((record) => record.settings.role === 'validate' && !fitted.includes(record));
  const added = (asked.get('also')?.split(',') ?? []).map((id) =>
    records.find((record) => record.id === id),
  );
  const judged = [
    ...held,
    ...added.filter((record) => record !== undefined && !held.includes(record)),
  ] as RecordEntry[];
  const others = usable.filter((record) => !judged.includes(record));
  const scoring = {
    skip_s: asked.get('skip') ? Number(asked.get('skip')) : null,
    fixed_offset: asked.get('fixed') !== null,
    continued: asked.get('run') !== null,
    correct: asked.get('correct') !== null && asked.get('run') === null && correctable,
    rate: (model.kind === 'force' && asked.get('ratecol')) || null,
  };
  const at = `${path('models', model.id)}/scores`;
  const ids = judged.map((record) => record.id);
  const scored = useAnswer<Scored>(judged.length > 0 ? at : null, { records: ids, ...scoring });
  useEffect(() => {
    command.value = scored.value?.command ?? null;
  }, [scored.value]);
  const chosen = judged.find((record) => record.id === asked.get('rec')) ?? judged[0];
  const add = (id: string): void =>
    settle({
      also: [...judged.filter((record) => !held.includes(record)).map((record) => record.id), id].join(','),
    });
  return (
    <>
      <Head title={TITLE} question={QUESTION}>
        <Origin simulated={model.simulated} />
        <ModelChoice models={models} model={model} />
        <Add records={others} fitted={fitted} add={add} />
        <a class="btn primary" href={address({}, 'follow')}>
          Follow a reference
        </a>
      </Head>
      {judged.length === 0 ? (
        <Lacking
          title="Every record was used for the fit"
          action={
            <a class="btn primary" href={address({}, 'records')}>
              Choose or add a record
            </a>
          }
        >
          Scores on the records of the fit flatter the model. Give one record the role “validate” and
          identify without it, or measure another: another amplitude or frequency says most.
        </Lacking>
      ) : (
        <div class="stack">
          <Scoring model={model} correctable={correctable}>
            {chosen && (
              <SaveAs
                stem="scored"
                device={model.device}
                what="scored samples"
                label={`Download the scored samples${scoring.continued ? '' : ` of ${fileName(chosen.id)}`}`}
                ready={scored.value !== undefined}
                write={async (save) => {
                  const records = scoring.continued ? ids : [chosen.id];
                  const answer = await change<Scored>('POST', at, { records, ...scoring, save });
                  const failed = answer.records.find((row) => row.error)?.error;
                  if (failed) throw new Refusal(0, failed);
                  return save;
                }}
              />
            )}
          </Scoring>
          {scored.error && <Failure problem={scored.error.complaint} />}
          {!scored.value && !scored.error && <Waiting height={180} />}
          {scored.value && (
            <Scores scored={scored.value} chosen={chosen?.id} fitted={fitted} name={model.name} />
          )}
          {chosen && (
            <Curves key={chosen.id} model={model.id} record={chosen.id} origin={originOf(chosen)} />
          )}
          <Response model={model.id} records={judged} />
        </div>
      )}
      {usable.length > 0 && (
        <div class="stack below">
          <Recalibrate key={`r ${model.id}`} model={model} records={usable} />
          <Adapt key={`a ${model.id}`} model={model} records={usable} />
        </div>
      )}
    </>
  );
}

/** How records are scored, and the samples as a file. */
function Scoring({
  model,
  correctable,
  children,
}: {
  model: ModelEntry;
  correctable: boolean;
  children: ComponentChildren;
}) {
  const { query: asked } = useSignal(route);
  const check = (key: string, label: string) => (
    <label class="row">
      <input
        type="checkbox"
        checked={asked.get(key) !== null}
        onChange={(event) => settle({ [key]: event.currentTarget.checked ? '1' : null })}
      />
      {label}
    </label>
  );
  return (
    <details>
      <summary>How they are scored</summary>
      <div class="row wrap gaps">
        <label class="row">
          <span class="soft">Not scored at the start</span>
          <input
            type="number"
            class="short"
            min="0"
            step="any"
            placeholder="as usual"
            value={asked.get('skip') ?? ''}
            onChange={(event) => settle({ skip: event.currentTarget.value || null })}
          />
          s
        </label>
        {check('fixed', 'the sensor’s offset is the model’s')}
        {check('run', 'parts of one run')}
        {correctable &&
          asked.get('run') === null &&
          check('correct', 'corrected by what the device does beside the model')}
        {model.kind === 'force' && (
          <label class="row">
            <span class="soft">Column of the rate</span>
            <input
              type="text"
              class="short"
              placeholder="from the drive"
              value={asked.get('ratecol') ?? ''}
              onChange={(event) => settle({ ratecol: event.currentTarget.value.trim() || null })}
            />
          </label>
        )}
        {children}
      </div>
    </details>
  );
}

function Add({
  records,
  fitted,
  add,
}: {
  records: RecordEntry[];
  fitted: RecordEntry[];
  add: (id: string) => void;
}) {
  if (records.length === 0) return null;
  return (
    <select
      aria-label="Add a record to validate on"
      value=""
      onChange={(event) => {
        if (event.currentTarget.value) add(event.currentTarget.value);
        event.currentTarget.value = '';
      }}
    >
      <option value="">Add a record…</option>
      {records.map((record) => (
        <option key={record.id} value={record.id}>
          {fileName(record.id)}
          {fitted.includes(record) ? ' (of the fit)' : ''}
        </option>
      ))}
    </select>
  );
}

function Scores(props: { scored: Scored; chosen?: string; fitted: RecordEntry[]; name: string }) {
  const { scored } = props;
  const rows = scored.records;
  const units = rows.map((row) => row.score?.unit ?? '');
  const define = (name: string): string | undefined =>
    scored.definitions.find((definition) => definition.name.toLowerCase() === name.toLowerCase())?.text;
  const band = rows.some((row) => row.in_band_percent != null);
  const nanometres = rows.every((row) => !row.score || (row.score.unit === 'µm' && row.score.rmse < 1));
  const unit = nanometres ? 'nm' : units.find(Boolean);
  return (
    <div class="cols g-cmp">
      <div>
        <TableBox label="Scores">
          <table>
            <caption>{props.name}, scores of a simulation from the start of each record</caption>
            <thead>
              <tr>
                <th scope="col">Record</th>
                <Column name="RMSE" unit={unit} text={define('RMSE')} />
                <Column name="% of" unit="stroke" text={define('RMSE / stroke')} />
                <Column name="largest error" unit={unit} text={define('max error')} />
                <Column name="fit" unit="%" text={define('fit')} />
                {band && <Column name="in band" unit="%, 95 expected" text={define('in band')} />}
              </tr>
            </thead>
            <tbody>
              {rows.map((row) => (
                <ScoreRow key={row.record} row={row} band={band} nanometres={nanometres} {...props} />
              ))}
            </tbody>
          </table>
        </TableBox>
        <details>
          <summary>Definitions</summary>
          <dl class="facts">
            {scored.definitions.map((definition) => (
              <>
                <dt>{definition.name}</dt>
                <dd>{prose(definition.text)}</dd>
              </>
            ))}
          </dl>
        </details>
      </div>
      <div class="stack tight">
        <Assumed rows={rows} />
      </div>
    </div>
  );
}

function Column({ name, unit, text }: { name: string; unit?: string; text?: string }) {
  return (
    <th scope="col" class="n">
      {text ? (
        <abbr class="def" title={text}>
          {name}
        </abbr>
      ) : (
        name
      )}
      <small>{unit}</small>
    </th>
  );
}

function ScoreRow(props: {
  row: Judged;
  band: boolean;
  nanometres: boolean;
  chosen?: string;
  fitted: RecordEntry[];
}) {
  const { row } = props;
  const { score } = row;
  const error = (value: number): string =>
    props.nanometres ? significant(value * 1000, 3) : quantity(value, '', 3)[0];
  const percent = (value: number | null | undefined, digits: number): string =>
    value == null ? '–' : value.toFixed(digits);
  const choose = (): void => go({ rec: row.record, 'z.loop': null, 'z.t': null });
  return (
    <tr class={`click ${row.record === props.chosen ? 'sel' : ''}`} onClick={choose}>
      <td>
        <button type="button" class="link" aria-pressed={row.record === props.chosen}>
          {fileName(row.record)}
        </button>
        {row.verdict && <span class="why">{prose(row.verdict)}</span>}
        {props.fitted.some((record) => record.id === row.record) && (
          <span class="tag warn">of the fit</span>
        )}
      </td>
      {score ? (
        <>
          <td class="n">{error(score.rmse)}</td>
          <td class="n">{percent(score.rmse_percent_of_stroke, 2)}</td>
          <td class="n">{error(score.max_abs_error)}</td>
          <td class="n">{percent(score.fit_percent, 2)}</td>
          {props.band && <td class="n">{percent(row.in_band_percent, 1)}</td>}
        </>
      ) : (
        <td colSpan={props.band ? 5 : 4} class="soft">
          {row.error?.what ?? 'not scored'}
        </td>
      )}
    </tr>
  );
}

/** The states that records were taken to begin in, and where the model extrapolates. */
function Assumed({ rows }: { rows: Judged[] }) {
  const known = rows.filter((row) => row.remarks.length > 0);
  if (known.length === 0) return null;
  return (
    <Finding kind="note">
      <b>Assumed, and where the model extrapolates</b>
      <ul class="plain">
        {known.map((row) => (
          <li key={row.record}>
            <span class="mono">{fileName(row.record)}</span>: {row.remarks.map(prose).join(' ')}
          </li>
        ))}
      </ul>
    </Finding>
  );
}

function Curves({ model, record, origin }: { model: string; record: string; origin: Of }) {
  const at = `${path('models', model)}/curves`;
  const zoom = zoomOf('t');
  const window = { from: zoom?.x[0], to: zoom?.x[1], pixels: 1000 };
  const loop = useLatest<ModelCurves>(at + query({ record, view: 'loop', pixels: 700 }));
  const time = useLatest<ModelCurves>(at + query({ record, view: 'time', ...window }));
  const residual = useLatest<ModelCurves>(at + query({ record, view: 'residual', ...window }));
  const titled = (spec: Spec | null): Spec | null =>
    spec && { ...spec, title: spec.title.replace(/^Loop/, `Loop, ${fileName(record)}`) };
  const loopSpec = useMemo(() => titled(loopOf(loop.value, origin)), [loop.value, origin]);
  const timeSpec = useMemo(() => timeOf(time.value, origin), [time.value, origin]);
  const residualSpec = useMemo(() => residualOf(residual.value, origin), [residual.value, origin]);
  const failed = loop.error ?? time.error ?? residual.error;
  if (failed) return <Failure problem={failed.complaint} />;
  return (
    <div class="cols g-plots hr">
      {loopSpec ? <Plot spec={loopSpec} /> : <Waiting height={400} />}
      <div>
        {timeSpec ? <Plot spec={timeSpec} /> : <Waiting height={210} />}
        {residualSpec ? <Plot spec={residualSpec} /> : <Waiting height={222} />}
      </div>
    </div>
  );
}

/** Gain and phase at the frequencies of the records, where they have any. */
function Response({ model, records }: { model: string; records: RecordEntry[] }) {
  const addresses = records.map(
    (record) => `${path('models', model)}/response${query({ record: record.id })}`,
  );
  const answers = useAll<Responses>(addresses);
  const rows = answers.flatMap((answer) => answer.value?.rows ?? []);
  const origin = originOf(records.find((record) => !record.simulated) ?? records[0]);
  if (rows.length === 0) return null;
  const unit = answers.find((answer) => answer.value)?.value?.unit ?? '';
  const sorted = [...rows].sort((a, b) => a.frequency_hz - b.frequency_hz);
  const line = (
    name: string,
    of: (row: (typeof sorted)[0]) => GainPhase,
    what: 'gain' | 'phase_deg',
  ): Line => ({
    name,
    color: name === 'model' ? 'model' : 'measured',
    x: sorted.map((row) => row.frequency_hz),
    y: sorted.map((row) => of(row)[what]),
    errors:
      name === 'model'
        ? undefined
        : sorted.map((row) => (what === 'gain' ? of(row).gain_std_error : of(row).phase_std_error_deg)),
    points: name === 'model' ? 2 : 6,
    filled: name === 'model' ? () => true : undefined,
  });
  const spec = (
    key: string,
    title: string,
    label: string,
    own: string,
    what: 'gain' | 'phase_deg',
  ): Spec => ({
    key,
    title,
    description: 'Record and model at each frequency.',
    height: 206,
    x: { label: 'frequency (Hz)', unit: 'Hz', log: true },
    y: { label, unit: own },
    lines: [line(origin, (row) => row.measured, what), line('model', (row) => row.model, what)],
  });
  return (
    <div class="hr">
      <div class="cols g-2">
        <Plot spec={spec('gain', 'Gain at the records’ frequencies', `gain (${unit})`, unit, 'gain')} />
        <Plot spec={spec('phase', 'Phase', 'phase (°)', '°', 'phase_deg')} />
      </div>
      <p class="soft s">
        First harmonic at the amplitude of each record; hysteresis makes it depend on amplitude, so that it
        is no transfer function.
      </p>
    </div>
  );
}
