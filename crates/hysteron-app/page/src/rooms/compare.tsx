// Room 3: which structure do the records support, and what does it cost the controller?
import { useEffect, useMemo, useRef, useState } from 'preact/hooks';
import { change, Refusal, type Complaint } from '../api/client';
import { useAnswer, useResource } from '../api/resource';
import type { Candidate, Command, Comparison, Job, JobRequest, RecordEntry } from '../api/types';
import { DeviceChoice } from '../components/DeviceChoice';
import { act, command, StopButton } from '../components/dock';
import { Failure, Finding, Head, Lacking, Origin, Waiting } from '../components/words';
import { TableBox } from '../components/window';
import { count, fileName, left, prose, quantityText, significant } from '../format';
import { Plot } from '../plot/Plot';
import type { Spec } from '../plot/spec';
import { address, go, route, settle } from '../route';
import { useSignal } from '../signal';
import { jobs, took } from '../store';
import { PickRow, spaced } from '../components/Pick';
import { AxesRanking } from './AxesRanking';
import { deviceOf } from './identify';
import { Axes } from './identify/Settings';
import { columns } from './identify/task';
import { isFit, isFitOfAxes, ofOneKind } from './records/roles';

const TITLE = 'Compare';
const QUESTION = 'Which structure do these records support, and what does it cost the controller?';

export function Compare() {
  const { query } = useSignal(route);
  const list = useSignal(jobs).filter((job) => job.request.kind === 'compare');
  const records = useResource<RecordEntry[]>('records').value;
  const [problem, complain] = useState<Complaint | null>(null);
  const named = query.get('device');
  const isOwn = (one: Job): boolean => {
    const own = records?.find((record) => one.request.records.includes(record.id))?.device;
    return !named || own === undefined || own === (named === '.' ? '' : named);
  };
  const job = list.find((one) => String(one.id) === query.get('job')) ?? list.find(isOwn);
  const compared = records?.find((record) => record.id === job?.request.records[0]);
  const device = named || !compared ? records && deviceOf(query, records) : compared.device;
  const axes = query.get('axes') !== null;
  const own = records?.filter((r) => r.device === (device ?? r.device)) ?? [];
  const usable = axes ? own.filter(isFitOfAxes) : ofOneKind(own.filter(isFit));
  const quick = query.get('search') === null;
  const names = (query.get('structures') ?? '').split(/[\s,]+/).filter(Boolean);
  const limit = Number(query.get('limit')) || null;
  const [inputs, outputs] = [columns('inputs'), columns('outputs')];
  const ready = !axes || (inputs.length > 0 && outputs.length > 0);
  const request: JobRequest = {
    kind: 'compare',
    records: usable.map((record) => record.id),
    candidates: names,
    ...(axes ? { inputs, outputs } : { quick: quick && names.length === 0, time_limit_s: limit }),
  };
  const planned = useAnswer<Command>(usable.length > 0 && ready ? 'commands' : null, request);
  const preview = planned.value;
  useEffect(() => {
    command.value = job?.command ?? preview ?? null;
  }, [job?.id, preview]);

  const partial = useFinished(job);

  const begin = async (): Promise<void> => {
    try {
      const begun = await change<Job>('POST', 'jobs', request);
      complain(null);
      took(begun);
      go({ job: String(begun.id), pick: null });
    } catch (error) {
      complain(error instanceof Refusal ? error.complaint : { what: String(error) });
    }
  };
  const take = async (name: string): Promise<void> => {
    const of = job?.request.records ?? usable.map((record) => record.id);
    try {
      const asked = job?.request as { inputs?: string[]; outputs?: string[] } | undefined;
      const begun = await change<Job>('POST', 'jobs', {
        kind: 'identify',
        records: of,
        structure: name,
        inputs: asked?.inputs,
        outputs: asked?.outputs,
      });
      took(begun);
      go({ job: String(begun.id) }, 'identify');
    } catch (error) {
      complain(error instanceof Refusal ? error.complaint : { what: String(error) });
    }
  };

  if (!records) {
    return (
      <>
        <Head title={TITLE} question={QUESTION} />
        <Waiting height={320} />
      </>
    );
  }
  if (!job && usable.length < 2) {
    return <Empty usable={usable} several={!axes && own.filter(isFitOfAxes).length > 1} />;
  }
  const comparison = job?.result.comparison ?? null;
  const runs = job?.state === 'running' || job?.state === 'waiting';
  const ofAxes = job?.result.axes_comparison ?? null;
  const ranked = comparison ?? ofAxes;
  const pick =
    ranked && (ranked.candidates.find((c) => c.name === query.get('pick'))?.name ?? ranked.preferred);
  const of = job ? records.filter((record) => job.request.records.includes(record.id)) : usable;
  return (
    <>
      <Head title={TITLE} question={QUESTION}>
        <Origin simulated={of.length > 0 && of.every((record) => record.simulated)} />
        {!runs && <DeviceChoice records={records} device={device ?? undefined} />}
        {!runs && (
          <label class="row">
            <input
              type="checkbox"
              checked={axes}
              onChange={(event) => settle({ axes: event.currentTarget.checked ? '1' : null })}
            />
            several axes
          </label>
        )}
        {!runs && !axes && (
          <label class="row">
            <input
              type="checkbox"
              checked={!quick}
              onChange={(event) => settle({ search: event.currentTarget.checked ? '1' : null })}
            />
            search further
          </label>
        )}
        {runs && job && (
          <StopButton
            job={job}
            primary
            keeps={(job.result.candidates?.length ?? 0) > 0 ? 'what is finished' : ''}
          />
        )}
        {!runs && job?.resumable && (
          <button type="button" onClick={() => void act(job, 'resume')}>
            Go on
          </button>
        )}
        {!runs && (
          <button
            type="button"
            class={pick ? '' : 'primary'}
            onClick={() => void begin()}
            disabled={usable.length < 2 || !ready}
          >
            {job ? 'Compare again' : `Compare on ${count(usable.length, 'record')}`}
          </button>
        )}
        {!runs && pick && (
          <button type="button" class="primary" onClick={() => void take(pick)}>
            Take {spaced(pick)}
          </button>
        )}
      </Head>
      <div class="stack">
        {(planned.error ?? problem) && <Failure problem={planned.error?.complaint ?? problem!} />}
        {job?.error && <Failure problem={job.error} />}
        {job && runs && <Race job={job} />}
        {!runs && axes && usable[0] && <Axes record={usable[0]} />}
        {!runs && (
          <details>
            <summary>Which structures, for how long</summary>
            <div class="row wrap gaps">
              <label class="row">
                <span class="soft">Structures</span>
                <input
                  placeholder="all usual ones"
                  size={40}
                  title="As the ranking names them, e.g. none, fractional+creep, integer2+degree2, separated by commas"
                  value={query.get('structures') ?? ''}
                  onChange={(event) => settle({ structures: event.currentTarget.value || null })}
                />
              </label>
              <label class="row" hidden={axes}>
                <span class="soft">End after</span>
                <input
                  type="number"
                  class="short"
                  min="1"
                  step="any"
                  placeholder="no limit"
                  value={query.get('limit') ?? ''}
                  onChange={(event) => settle({ limit: event.currentTarget.value || null })}
                />
                s
              </label>
            </div>
          </details>
        )}
        {!job && (
          <p class="soft">
            Each record is left out in turn and every structure is fitted to the others:{' '}
            {usable.map((r) => fileName(r.id)).join(', ')}.
          </p>
        )}
        {ofAxes && <AxesRanking comparison={ofAxes} pick={pick} />}
        {comparison ? (
          <Ranking comparison={comparison} pick={pick} runs={runs} />
        ) : (
          partial && <Ranking comparison={partial} pick={null} runs />
        )}
        {job && !runs && !ranked && !job.error && (
          <Finding
            kind="warn"
            actions={
              <button type="button" onClick={() => void act(job, 'delete')}>
                Delete
              </button>
            }
          >
            {partial ? (
              <>
                <b>
                  The comparison was {job.state}; {count(partial.candidates.length, 'structure')} finished.
                </b>{' '}
                {job.resumable
                  ? 'Going on fits the others, and the one that ran anew; the result is that of a comparison without a break.'
                  : ''}
              </>
            ) : (
              <b>The comparison was {job.state} before a structure was finished.</b>
            )}
          </Finding>
        )}
      </div>
    </>
  );
}

/** What a race has finished so far, in the order in which it came: no row moves while it runs. */
function useFinished(job: Job | undefined): Comparison | null {
  const order = useRef<{ job?: number; names: string[] }>({ names: [] });
  const finished = job?.result.candidates ?? [];
  if (!job || finished.length === 0) return null;
  if (order.current.job !== job.id) order.current = { job: job.id, names: [] };
  const { names } = order.current;
  for (const { name } of finished) if (!names.includes(name)) names.push(name);
  const candidates = [...finished].sort((a, b) => names.indexOf(a.name) - names.indexOf(b.name));
  return {
    records: job.request.records,
    output_unit: job.unit,
    preferred: null,
    best: null,
    noise_floor: 0,
    folds: [],
    candidates,
    notes: [],
    interrupted: false,
  };
}

function Race({ job }: { job: Job }) {
  const stage = job.stages[job.stages.length - 1];
  const time = job.left_s != null ? `, ${left(job.left_s)}` : '';
  return (
    <Finding kind="note">
      <b>
        {stage ? `In the race: ${spaced(stage.name)}` : 'Waits in the queue'}
        {time}.
      </b>{' '}
      Order and error may still change; nothing is preferred yet. Finished structures are kept: a comparison
      that is stopped, or whose server ends, goes on with the others, and fits the one that ran anew.
    </Finding>
  );
}

function Ranking({
  comparison,
  pick,
  runs,
}: {
  comparison: Comparison;
  pick: string | null;
  runs: boolean;
}) {
  const unit = comparison.output_unit;
  const finished = comparison.candidates.filter((candidate) => candidate.error != null);
  const spec = useMemo(() => picture(finished, unit, pick), [comparison, pick]);
  return (
    <>
      {comparison.notes.length > 0 && (
        <Finding kind={comparison.preferred ? 'good' : 'note'}>
          {comparison.notes.map((note, i) => (
            <p key={note}>{i === 0 ? <b>{prose(note)}</b> : prose(note)}</p>
          ))}
        </Finding>
      )}
      <div class="cols g-cmp">
        <Table comparison={comparison} pick={pick} runs={runs} />
        {finished.some((one) => one.nanoseconds_per_sample != null) && <Plot spec={spec} />}
      </div>
    </>
  );
}

/** Places of errors on a logarithmic strip of 180 by 16. */
function strip(comparison: Comparison): (value: number) => number {
  const all = comparison.candidates
    .flatMap((candidate) => candidate.fold_errors)
    .filter((e): e is number => !!e && e > 0);
  const low = Math.log(Math.min(comparison.noise_floor || Infinity, ...all) * 0.8);
  const high = Math.log(Math.max(...all) * 1.2);
  return (value) => 4 + ((Math.log(value) - low) / (high - low || 1)) * 172;
}

function Table({ comparison, pick, runs }: { comparison: Comparison; pick: string | null; runs: boolean }) {
  const unit = comparison.output_unit;
  const place = strip(comparison);
  const least = Math.min(...comparison.candidates.map((candidate) => candidate.error ?? Infinity));
  const scale = unit === 'µm' && least < 1 ? 1000 : 1;
  const inverse = comparison.candidates.some((candidate) => candidate.invertible);
  return (
    <TableBox label="Ranking">
      <table class="mid">
        <caption>
          {comparison.folds.length > 0
            ? `Left out in turn: ${count(comparison.folds.length, 'fold')} `
            : 'So far '}
          <span class="soft s">simulation, not prediction</span>
        </caption>
        <thead>
          <tr>
            <th scope="col">Structure</th>
            <th scope="col" class="n">
              Parameters
            </th>
            <th scope="col" class="n">
              Error <small>± s.e.</small>
            </th>
            <th scope="col">
              Folds ○ and mean ▮<small>log scale; ┆ noise floor</small>
            </th>
            <th scope="col" class="n">
              Cost <small>ns/sample</small>
            </th>
            {inverse && <th scope="col">Inverse</th>}
          </tr>
        </thead>
        <tbody>
          {comparison.candidates.map((candidate) => (
            <PickRow key={candidate.name} name={candidate.name} pick={pick} disabled={runs}>
              <td class="n">{candidate.parameters}</td>
              {candidate.error == null ? (
                <td class="soft" colSpan={inverse ? 4 : 3}>
                  {candidate.failures[0] ??
                    (candidate.hopeless ? 'left out after its first fit: too far behind' : 'waits')}
                </td>
              ) : (
                <Errors
                  candidate={candidate}
                  unit={unit}
                  place={place}
                  floor={comparison.noise_floor}
                  inverse={inverse}
                  scale={scale}
                  runs={runs}
                />
              )}
            </PickRow>
          ))}
        </tbody>
      </table>
      <p class="soft s" hidden={runs}>
        Blue bar: as good as the best within one standard error of the difference.
      </p>
    </TableBox>
  );
}

function Errors(props: {
  candidate: Candidate;
  unit: string;
  place: (value: number) => number;
  floor: number;
  inverse: boolean;
  /** 1000: in nm. */
  scale: number;
  runs: boolean;
}) {
  const { candidate, place } = props;
  const error = candidate.error ?? 0;
  const { scale } = props;
  const folds = candidate.fold_errors.filter((e): e is number => e != null && e > 0);
  const [least, most] = [Math.min(...folds), Math.max(...folds)].map((e) => quantityText(e, props.unit));
  const range = `${folds.length} folds between ${least} and ${most}`;
  const own = scale === 1000 ? 'nm' : props.unit;
  const spread = candidate.error_std_error;
  const cost = candidate.nanoseconds_per_sample;
  return (
    <>
      <td class="n">
        {significant(error * scale, 3)}{' '}
        {spread != null && <span class="soft">± {significant(spread * scale, 2)}</span>} {own}
      </td>
      <td>
        <svg class="iv folds" viewBox="0 0 180 16" role="img" aria-label={range}>
          {props.floor > 0 && (
            <line class="floor" x1={place(props.floor)} x2={place(props.floor)} y1="0" y2="16" />
          )}
          {folds.map((fold, i) => (
            <circle key={i} cx={place(fold)} cy="8" r="2.6" />
          ))}
          <rect
            class={candidate.as_good_as_best && !props.runs ? 'best' : 'd'}
            x={place(error) - 1.5}
            y="1"
            width="3"
            height="14"
          />
        </svg>
      </td>
      <td class="n">{cost == null ? '–' : cost.toFixed(0)}</td>
      {props.inverse && <td>{candidate.invertible ?? '–'}</td>}
    </>
  );
}

function picture(finished: Candidate[], unit: string, pick: string | null): Spec {
  const list = finished.filter((candidate) => candidate.nanoseconds_per_sample != null);
  const x = list.map((candidate) => candidate.nanoseconds_per_sample ?? 0);
  const right = Math.max(...x, 1);
  return {
    key: 'cost',
    title: 'Error against cost',
    description: 'Lower left is better.',
    height: 350,
    x: { label: 'time per sample on this machine (ns)', unit: 'ns', range: [0, right * 1.8] },
    y: { label: `error on held-out data (${unit})`, unit, log: true },
    lines: [
      {
        name: 'structure ± one standard error',
        color: 'band',
        x,
        y: list.map((candidate) => candidate.error),
        errors: list.map((candidate) => candidate.error_std_error),
        points: 4.5,
        filled: (i) => list[i]?.name === pick,
      },
    ],
    marks: list.map((candidate) => ({
      x: candidate.nanoseconds_per_sample ?? 0,
      y: candidate.error ?? 0,
      text: spaced(candidate.name),
    })),
    loop: true,
  };
}

function Empty({ usable, several }: { usable: RecordEntry[]; several: boolean }) {
  useEffect(() => {
    command.value = null;
  }, []);
  const [only] = usable;
  return (
    <>
      <Head title={TITLE} question={QUESTION} />
      <Lacking
        title="Compare needs records of different content"
        action={
          <>
            <a class="btn primary" href={address({}, 'records')}>
              See what to measure
            </a>
            {several && (
              <button type="button" onClick={() => settle({ axes: '1' })}>
                Compare structures of several axes
              </button>
            )}
          </>
        }
      >
        Each record is left out in turn, so at least two must differ in amplitude or frequency.{' '}
        {only ? `${fileName(only.id)} alone cannot rank structures.` : ''}
      </Lacking>
    </>
  );
}
