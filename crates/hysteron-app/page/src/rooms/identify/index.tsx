// Room 2: which model describes these records, and how sure is each number?
import { useEffect, useState } from 'preact/hooks';
import { change, path, query, Refusal, type Complaint } from '../../api/client';
import { useAnswer, useLatest, useResource } from '../../api/resource';
import type { Command, Curve, Job, JobRequest, ModelEntry, Options, RecordEntry } from '../../api/types';
import { act, command, StopButton } from '../../components/dock';
import { Failure, Finding, Head, Lacking, Origin, Waiting } from '../../components/words';
import { DeviceChoice } from '../../components/DeviceChoice';
import { modelName } from '../../components/models';
import { Fold } from '../../components/window';
import { count, fileName } from '../../format';
import { Plot } from '../../plot/Plot';
import { address, go, route } from '../../route';
import { useSignal } from '../../signal';
import { jobs, took } from '../../store';
import { asLine, axisLabel } from '../records/Curves';
import { isFit, ofOneKind } from '../records/roles';
import { About, Done } from './Done';
import { Live } from './Live';
import { Settings } from './Settings';
import { requested } from './task';

const TITLE = 'Identify';
const QUESTION = 'Which model describes these records, and how sure is each number?';

/** The device that is meant: by the URL, by the chosen record, else the first that has a record to fit. */
export function deviceOf(query: URLSearchParams, records: RecordEntry[]): string | undefined {
  const named = query.get('device');
  if (named) return named === '.' ? '' : named;
  const chosen = records.find((record) => record.id === query.get('r'));
  return (chosen ?? records.find(isFit))?.device;
}

export function Identify() {
  const { query: asks } = useSignal(route);
  const list = useSignal(jobs).filter((job) => job.request.kind === 'identify');
  const records = useResource<RecordEntry[]>('records').value;
  const models = useResource<ModelEntry[]>('models').value;
  const offered = useResource<Options>('options').value;
  const [problem, complain] = useState<Complaint | null>(null);

  const active = list.find((job) => job.state === 'running') ?? list.find((job) => job.state === 'waiting');
  const named = list.find((job) => String(job.id) === asks.get('job'));
  const wanted = models?.find((entry) => entry.id === asks.get('m'));
  const device = wanted?.device ?? (records && deviceOf(asks, records));
  const model =
    wanted ?? (asks.get('new') ? undefined : newest(models?.filter((entry) => entry.device === device)));
  const fresh = asks.get('new') !== null;
  const isOwn = (one: Job): boolean =>
    records?.find((record) => one.request.records.includes(record.id))?.device === device;
  const job = named ?? (asks.get('m') || fresh || !active || !isOwn(active) ? undefined : active);

  // The model of a fit that is watched is shown as soon as it is there.
  const finished = job?.state === 'done' ? job.result.models[0] : undefined;
  useEffect(() => {
    if (finished) go({ m: finished, job: null, new: null });
  }, [finished]);

  const fit = records?.filter((record) => record.device === device && isFit(record)) ?? [];
  const own = ofOneKind(fit);
  const unlike = fit.length - own.length;
  const leftOut = new Set(asks.get('out')?.split(',') ?? []);
  const taken = own.filter((record) => !leftOut.has(record.id));
  const request: JobRequest | null =
    offered && taken.length > 0
      ? { kind: 'identify', records: taken.map((record) => record.id), ...requested(offered, taken) }
      : null;
  const planned = useAnswer<Command>(request && !job ? 'commands' : null, request);
  const preview = planned.error ? undefined : planned.value;
  useEffect(() => {
    command.value = job?.command ?? preview ?? null;
  }, [job?.id, preview]);

  const begin = async (): Promise<void> => {
    if (!request) return;
    try {
      const begun = await change<Job>('POST', 'jobs', request);
      complain(null);
      took(begun);
      go({ job: String(begun.id), m: null, new: null, rec: null, 'z.loop': null, 'z.t': null });
    } catch (error) {
      complain(error instanceof Refusal ? error.complaint : { what: String(error) });
    }
  };

  if (!records || !models) return <Loading />;
  if (own.length === 0 && !model && !job) return <Empty />;
  const shownModel = job ? undefined : model;
  const held = records.filter((record) => record.device === device && record.settings.role === 'validate');
  const runs = job?.state === 'running' || job?.state === 'waiting';
  const simulated = taken.length > 0 && taken.every((record) => record.simulated);
  return (
    <>
      <Head title={TITLE} question={QUESTION}>
        <Origin simulated={shownModel ? shownModel.simulated : simulated} />
        {!runs && <DeviceChoice records={records} device={device ?? undefined} />}
        <Tabs models={models} job={job ?? active} shown={job ? undefined : shownModel?.id} />
        {job?.resumable && !runs && (
          <button type="button" class="primary" onClick={() => void act(job, 'resume')}>
            Go on
          </button>
        )}
        {job && runs && <StopButton job={job} primary />}
        {shownModel && (
          <>
            <button type="button" onClick={() => void begin()} disabled={!request || !!planned.error}>
              Identify again
            </button>
            {held.length > 0 ? (
              <a class="btn primary" href={address({ m: shownModel.id }, 'validate')}>
                Validate on {count(held.length, 'record')}
              </a>
            ) : (
              <a class="btn primary" href={address({}, 'records')}>
                Add a record to validate on
              </a>
            )}
          </>
        )}
        {!shownModel && !runs && !job?.resumable && (
          <button
            type="button"
            class="primary"
            onClick={() => void begin()}
            disabled={!request || !!planned.error}
          >
            Identify from {count(taken.length, 'record')}
          </button>
        )}
      </Head>
      <div class="cols g-id">
        <div class="stack">
          <Fold title={`Settings, ${count(taken.length, 'record')}`} folded={shownModel !== undefined}>
            <Settings
              records={taken}
              out={own.filter((record) => leftOut.has(record.id))}
              models={models}
              running={runs}
            />
          </Fold>
          {shownModel && <About id={shownModel.id} />}
        </div>
        <div class="stack">
          {(planned.error ?? problem) && <Failure problem={planned.error?.complaint ?? problem!} />}
          {unlike > 0 && !shownModel && !job && (
            <Finding kind="note">
              {count(unlike, 'record')} of other quantities left out: a fit has one input and one output.
            </Finding>
          )}
          {job ? (
            <Live job={job} records={records} />
          ) : shownModel ? (
            <Done key={shownModel.id} id={shownModel.id} records={records} />
          ) : (
            <Ready records={taken} />
          )}
        </div>
      </div>
    </>
  );
}

function newest(models: ModelEntry[] | undefined): ModelEntry | undefined {
  return models
    ?.filter((model) => !model.interrupted)
    .sort((a, b) => b.modified.localeCompare(a.modified))[0];
}

function Tabs({ models, job, shown }: { models: ModelEntry[]; job?: Job; shown?: string }) {
  const live = job && job.state !== 'done' ? job : undefined;
  if (models.length === 0 && !live) return null;
  const value = shown ?? (live ? `job ${live.id}` : '');
  return (
    <select
      aria-label="Model that is shown"
      value={value}
      onChange={(event) => {
        const name = event.currentTarget.value;
        if (name === '') go({ m: null, job: null, new: '1' });
        else if (name.startsWith('job ')) go({ m: null, job: name.slice(4), new: null });
        else go({ m: name, job: null, new: null, rec: null, 'z.loop': null, 'z.t': null });
      }}
    >
      {live && (
        <option value={`job ${live.id}`}>
          {live.name}, {live.state}
        </option>
      )}
      {models.map((model) => (
        <option key={model.id} value={model.id}>
          {modelName(model)}
        </option>
      ))}
      <option value="">a new model…</option>
    </select>
  );
}

function Ready({ records }: { records: RecordEntry[] }) {
  return (
    <div class="stack">
      <p class="soft">
        {count(records.length, 'record')}: {records.map((record) => fileName(record.id)).join(', ')}. The
        settings are the usual ones, chosen by what the records support; the fit is shown as it happens and
        can be stopped at any time.
      </p>
      <div class="cols g-2">
        {records.slice(0, 4).map((record) => (
          <Glimpse key={record.id} record={record} />
        ))}
      </div>
    </div>
  );
}

/** The loop of a record that will be fitted. */
function Glimpse({ record }: { record: RecordEntry }) {
  const from = query({ x: record.input, y: record.output, pixels: 600 });
  const curve = useLatest<Curve>(`${path('records', record.id)}/curve${from}`).value;
  if (!curve) return <Waiting height={286} />;
  return (
    <Plot
      spec={{
        key: record.id,
        title: `${fileName(record.id)}: ${curve.shown}`,
        height: 260,
        loop: true,
        x: { label: axisLabel('drive', curve.across), unit: curve.across.unit },
        y: { label: axisLabel('output', curve.up), unit: curve.up.unit },
        lines: [asLine(curve, 'measured', 1.5)],
      }}
    />
  );
}

function Loading() {
  return (
    <>
      <Head title={TITLE} question={QUESTION} />
      <div class="cols g-id">
        <Waiting height={360} />
        <div class="stack">
          <Waiting height={78} />
          <div class="cols g-plots">
            <Waiting height={400} />
            <Waiting height={400} />
          </div>
        </div>
      </div>
    </>
  );
}

function Empty() {
  useEffect(() => {
    command.value = null;
  }, []);
  return (
    <>
      <Head title={TITLE} question={QUESTION} />
      <Lacking
        title="No record has the role “fit” yet"
        action={
          <a class="btn primary" href={address({}, 'records')}>
            Choose records
          </a>
        }
      >
        A model needs at least one record with a slow loop. For dynamics it needs a faster one too, such as
        a sweep.
      </Lacking>
    </>
  );
}
