// Room 1: which records are there, and what can they determine?
import { useEffect, useRef, useState } from 'preact/hooks';
import { change, path } from '../../api/client';
import { changed, useAnswer, useLatest, useResource } from '../../api/resource';
import type { RecordDetail, RecordEntry, Together, Workspace } from '../../api/types';
import { command } from '../../components/dock';
import { Failure, Finding, Head, Waiting } from '../../components/words';
import { Fold } from '../../components/window';
import { count, fileName, prose } from '../../format';
import { address, go, route } from '../../route';
import { useSignal } from '../../signal';
import { Curves } from './Curves';
import { DeadBand } from './DeadBand';
import { DropField, useDropped } from './Drop';
import { DriveMaker } from './DriveMaker';
import { Determines, Facts, Remarks } from './Facts';
import { RecordHead } from './Head';
import { RecordList } from './List';
import { PrepareRecords, ResponseFit } from './Operations';
import { forFit } from './roles';
import { Stretches } from './Stretches';
import { drop, sendOne, uploads, type Upload } from './uploads';

const TITLE = 'Records';
const QUESTION = 'Which records do I have, and what can they determine?';

export function Records() {
  const { query } = useSignal(route);
  const sending = useSignal(uploads);
  const answer = useResource<RecordEntry[]>('records');
  const over = useDropped();
  const records = answer.value;
  const wanted = query.get('r');
  const refused = wanted?.startsWith('!')
    ? sending.find((upload) => `!${upload.name}` === wanted)
    : undefined;
  const chosen = records?.find((record) => record.id === wanted) ?? (refused ? undefined : records?.[0]);

  if (answer.error) {
    return (
      <>
        <Head title={TITLE} question={QUESTION} />
        <Failure problem={answer.error.complaint} />
      </>
    );
  }
  if (!records) return <Loading />;
  if (records.length === 0 && sending.length === 0) return <Empty over={over} />;
  const fit = chosen ? forFit(records, chosen) : [];
  return (
    <>
      <Head title={TITLE} question={QUESTION}>
        <Example />
        <a
          class="btn primary"
          aria-disabled={fit.length === 0}
          href={
            fit.length > 0 && chosen ? address({ device: chosen.device || '.' }, 'identify') : undefined
          }
        >
          {fit.length > 0 ? `Identify from ${count(fit.length, 'record')}` : 'Identify'}
        </a>
      </Head>
      <div class="cols g-records">
        <div class="side">
          <Fold title={`Records, ${count(records.length, 'file')}`} folded={wanted !== null}>
            <RecordList records={records} chosen={refused ? `!${refused.name}` : (chosen?.id ?? null)} />
            <DropField over={over} />
          </Fold>
        </div>
        {refused ? (
          <Refused upload={refused} others={records.length} />
        ) : (
          chosen && <Detail key={chosen.id} entry={chosen} records={records} fit={fit} />
        )}
      </div>
    </>
  );
}

function Detail({
  entry,
  records,
  fit,
}: {
  entry: RecordEntry;
  records: RecordEntry[];
  fit: RecordEntry[];
}) {
  const answer = useLatest<RecordDetail>(path('records', entry.id));
  const together = fit.length > 1 && fit.includes(entry);
  const joint = useAnswer<Together>(together ? 'prospects' : null, {
    records: fit.map((record) => record.id),
  });
  // While a file is read anew, what was read before stays.
  const read = useRef<RecordDetail | undefined>(undefined);
  if (answer.value && !answer.value.reading) read.current = answer.value;
  const record = read.current;
  // The end of the reading may have been told before this page listened: it asks until it knows.
  const reading = entry.reading === true || answer.value?.reading === true;
  useEffect(() => {
    if (!reading) return;
    const timer = setInterval(() => changed('records'), 700);
    return () => clearInterval(timer);
  }, [reading]);
  useEffect(() => {
    command.value = record?.command ?? null;
  }, [record]);
  if (answer.error) return <Failure problem={answer.error.complaint} />;
  if (!record) return <Boxes entry={entry} />;
  const prospects = together ? joint.value?.prospects : record.prospects;
  return (
    <div class="stack">
      <RecordHead record={record} records={records} />
      {record.error && <Failure problem={record.error} />}
      <Remarks record={record} />
      {!record.error && record.input && record.output && <Curves record={record} />}
      {record.inspection && (
        <div class="cols g-facts hr">
          <div>
            <Facts record={record} />
            <Stretches record={record} />
            {record.inspection && <DeadBand record={record} />}
          </div>
          {prospects ? (
            <Determines prospects={prospects} of={together ? fit.length : 1} />
          ) : (
            <Waiting height={264} />
          )}
        </div>
      )}
      {(prospects?.measure_next || route.value.query.get('make')) && (
        <MeasureNext text={prospects?.measure_next ?? null} record={record} />
      )}
      {!record.error && <PrepareRecords record={record} records={records} />}
      <ResponseFit record={record} records={records} />
    </div>
  );
}

function MeasureNext({ text, record }: { text: string | null; record: RecordDetail }) {
  const [open, show] = useState(route.value.query.get('make') !== null);
  return (
    <>
      <Finding
        kind="next"
        actions={
          <button type="button" aria-expanded={open} onClick={() => show(!open)}>
            Make this drive…
          </button>
        }
      >
        <b class="h">Measure next:</b>{' '}
        {text ? `${prose(text)}.` : 'another amplitude or frequency than these records have.'}
      </Finding>
      {open && <DriveMaker record={record} />}
    </>
  );
}

function Refused({ upload, others }: { upload: Upload; others: number }) {
  const exists = upload.status === 409;
  useEffect(() => {
    command.value = null;
  }, [upload.name]);
  const actions = (
    <>
      {exists && (
        <button type="button" onClick={() => void sendOne(upload.file, true)}>
          Replace the file that is there
        </button>
      )}
      <button
        type="button"
        onClick={() => {
          drop(upload.name);
          go({ r: null });
        }}
      >
        Leave it out
      </button>
    </>
  );
  return (
    <div class="stack">
      <h2 class="mono">{upload.name}</h2>
      {upload.problem && <Failure problem={upload.problem} actions={actions} />}
      <p class="soft">
        Nothing else was touched
        {others > 0 ? `: the other ${count(others, 'record')} stay as they are` : ''}. The file stays where
        it was and is not in the workspace.
      </p>
    </div>
  );
}

function Loading() {
  return (
    <>
      <Head title={TITLE} question={QUESTION} />
      <div class="cols g-records">
        <div class="rl">
          {[0, 1, 2, 3].map((i) => (
            <Waiting key={i} height={44} />
          ))}
        </div>
        <Boxes />
      </div>
    </>
  );
}

/** The curves of a record are there before its inspection. */
function Boxes({ entry }: { entry?: RecordEntry }) {
  return (
    <div class="stack">
      <div class="rhead">
        <h2 class="mono">{entry ? fileName(entry.id) : ' '}</h2>
      </div>
      {entry?.input && entry.output ? (
        <Curves record={entry} />
      ) : (
        <div class="cols g-plots">
          <Waiting height={382} />
          <Waiting height={408} />
        </div>
      )}
      <div class="cols g-facts">
        <Waiting height={264} />
        <Waiting height={264} />
      </div>
    </div>
  );
}

async function openExample(name: string): Promise<void> {
  const { records } = await change<{ records: string[] }>('POST', path('examples', name));
  changed('records');
  changed('workspace');
  go({ r: records[0] }, 'records');
}

/** The examples that are not in the workspace yet. */
function Example() {
  const examples =
    useResource<Workspace>('workspace').value?.examples.filter((example) => !example.open) ?? [];
  if (examples.length === 0) return null;
  return (
    <select
      aria-label="Add an example"
      value=""
      onChange={(event) => {
        if (event.currentTarget.value) void openExample(event.currentTarget.value);
        event.currentTarget.value = '';
      }}
    >
      <option value="">Add example…</option>
      {examples.map((example) => (
        <option key={example.name} value={example.name}>
          {example.title}
        </option>
      ))}
    </select>
  );
}

function Empty({ over }: { over: boolean }) {
  const examples = useResource<Workspace>('workspace').value?.examples ?? [];
  useEffect(() => {
    command.value = null;
  }, []);
  return (
    <>
      <Head title={TITLE} question={QUESTION} />
      <div class="center">
        <DropField over={over} big />
        <p class="soft">
          A record needs the drive (V) and what it moved (µm, or a sensor voltage with its scale), sampled
          together. Column names with units, like <code>u_V</code> and <code>y_um</code>, are read without
          asking.
        </p>
        <div class="cols g-2 eq">
          {examples.map((example) => (
            <div class="card" key={example.name}>
              <h2>{example.name}</h2>
              <p class="soft">{example.title}</p>
              <button type="button" onClick={() => void openExample(example.name)}>
                Open this example
              </button>
            </div>
          ))}
          <div class="card">
            <h2>No device at hand?</h2>
            <p class="soft">A simulated bench makes records with a truth that you set.</p>
            <a class="btn" href={address({}, 'try')}>
              Try without a device
            </a>
          </div>
        </div>
      </div>
    </>
  );
}
