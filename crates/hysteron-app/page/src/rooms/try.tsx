// Room 7: what would come out, before anything is measured?
import { useEffect, useState } from 'preact/hooks';
import { change, get, path, query as parameters, Refusal, type Complaint } from '../api/client';
import { changed, useLatest, useResource } from '../api/resource';
import type { Command, Curve, Job, Options, RecordEntry, Workspace } from '../api/types';
import { command } from '../components/dock';
import { SchemaForm } from '../components/SchemaForm';
import { Failure, Head, Tag, Waiting } from '../components/words';
import { count, integer } from '../format';
import { Plot } from '../plot/Plot';
import { address, go } from '../route';
import { took } from '../store';
import { asLine, axisLabel } from './records/Curves';
import { isFit } from './records/roles';

const TITLE = 'Try without a device';
const QUESTION = 'What would I get, before I measure anything?';

interface Made {
  records: string[];
  samples: number;
  command: Command;
}

type Values = Record<string, unknown>;

export function Try() {
  const offered = useResource<Options>('options').value;
  return (
    <>
      <Head title={TITLE} question={QUESTION} />
      <div class="stack">
        <Examples />
        {offered ? <Bench offered={offered} /> : <Waiting height={400} />}
      </div>
    </>
  );
}

function Examples() {
  const examples = useResource<Workspace>('workspace').value?.examples ?? [];
  const records = useResource<RecordEntry[]>('records').value ?? [];
  const open = async (name: string): Promise<void> => {
    const made = await change<{ records: string[] }>('POST', path('examples', name));
    changed('records');
    changed('workspace');
    go({ r: made.records[0] }, 'records');
  };
  return (
    <div class="cols g-3 eq">
      {examples.map((example) => {
        const own = records.filter((record) => record.device === example.name);
        return (
          <div class="card" key={example.name}>
            <h2>
              {example.name} <Tag>measured</Tag>
            </h2>
            <p class="soft s">{example.title}</p>
            {example.open && own[0] ? (
              <a class="btn" href={address({ r: own[0].id }, 'records')}>
                To its {count(own.length, 'record')}
              </a>
            ) : (
              <button type="button" onClick={() => void open(example.name)}>
                Open this example
              </button>
            )}
          </div>
        );
      })}
    </div>
  );
}

/** The bench: truth and plan, its records, and on from them to a fit. */
function Bench({ offered }: { offered: Options }) {
  const [truth, setTruth] = useState<Values>(offered.truth_default);
  const [plan, setPlan] = useState<Values>(offered.plan_default);
  const [seed, setSeed] = useState(1);
  const [made, keep] = useState<Made | null>(null);
  const [busy, mark] = useState(false);
  const [problem, complain] = useState<Complaint | null>(null);
  useEffect(() => {
    command.value = made?.command ?? null;
  }, [made]);

  const make = async (): Promise<Made | null> => {
    mark(true);
    try {
      const answer = await change<Made>('POST', 'bench', { folder: 'bench', truth, plan, seed });
      keep(answer);
      complain(null);
      changed('records');
      return answer;
    } catch (error) {
      complain(error instanceof Refusal ? error.complaint : { what: String(error) });
      return null;
    } finally {
      mark(false);
    }
  };
  const chain = async (): Promise<void> => {
    const answer = await make();
    if (!answer) return;
    try {
      const entries = await get<RecordEntry[]>('records');
      const fit = entries
        .filter((entry) => answer.records.includes(entry.id) && isFit(entry))
        .map((entry) => entry.id);
      const job = await change<Job>('POST', 'jobs', { kind: 'identify', records: fit });
      took(job);
      go({ job: String(job.id), device: 'bench', r: fit[0] }, 'identify');
    } catch (error) {
      complain(error instanceof Refusal ? error.complaint : { what: String(error) });
    }
  };
  return (
    <div class="cols g-try hr">
      <div class="stack">
        <div class="ph">
          <h2>Truth of the bench</h2>
          <Tag kind="sim">simulated</Tag>
          <span class="sp" />
          <button
            type="button"
            class="quiet"
            onClick={() => {
              setTruth(offered.truth_default);
              setPlan(offered.plan_default);
            }}
          >
            Default
          </button>
        </div>
        <div class="set twos">
          <SchemaForm schema={offered.truth} root={offered.truth} value={truth} change={setTruth} />
        </div>
        <details>
          <summary>Records that are made</summary>
          <div class="set twos">
            <SchemaForm schema={offered.plan} root={offered.plan} value={plan} change={setPlan} />
          </div>
        </details>
        <label class="row">
          <span class="soft">Seed of the noise</span>
          <input
            type="number"
            class="short"
            min="0"
            value={seed}
            onChange={(event) => setSeed(Number(event.currentTarget.value))}
          />
        </label>
        <p class="soft s">
          The truth lies outside every model class that hysteron fits, so that nothing comes out perfect.
        </p>
        <div class="row wrap">
          <button type="button" onClick={() => void make()} disabled={busy}>
            Make the records
          </button>
          <button type="button" class="primary" onClick={() => void chain()} disabled={busy}>
            Make them and identify
          </button>
        </div>
      </div>
      <div class="stack">
        {problem && <Failure problem={problem} />}
        {made?.records[0] ? <Seen record={made.records[0]} made={made} /> : <Waiting height={330} />}
      </div>
    </div>
  );
}

function Seen({ record, made }: { record: string; made: Made }) {
  const entry = useLatest<RecordEntry>(path('records', record)).value;
  const curve = useLatest<Curve>(
    entry
      ? `${path('records', record)}/curve${parameters({ x: entry.input, y: entry.output, pixels: 700 })}`
      : null,
  ).value;
  if (!curve) return <Waiting height={330} />;
  return (
    <>
      <Plot
        spec={{
          key: 'loop',
          title: `Loop of the bench: ${curve.shown}`,
          height: 330,
          loop: true,
          x: { label: axisLabel('drive', curve.across), unit: curve.across.unit },
          y: { label: axisLabel('output', curve.up), unit: curve.up.unit },
          lines: [asLine(curve, 'measured', 1.8, 'simulated record')],
          tools: ['zoom', 'pan'],
        }}
      />
      <p class="soft s">
        {count(made.records.length, 'record')}, {integer(made.samples)} samples.{' '}
        <a href={address({ r: record }, 'records')}>See them in Records</a>
      </p>
    </>
  );
}
