// Room 7: what would come out, before anything is measured?
import { useEffect, useState } from 'preact/hooks';
import { change, path, query, Refusal, type Complaint } from '../../api/client';
import { changed, useLatest, useResource } from '../../api/resource';
import type { Curve, Options, RecordEntry, Workspace } from '../../api/types';
import { command } from '../../components/dock';
import { Icon } from '../../components/icon';
import { SchemaForm } from '../../components/SchemaForm';
import { Failure, Head, Tag, Waiting } from '../../components/words';
import { count, fixed, significant } from '../../format';
import { Plot } from '../../plot/Plot';
import { address, go } from '../../route';
import { useSignal } from '../../signal';
import { jobs } from '../../store';
import { asLine, axisLabel } from '../records/Curves';
import { Glyph } from '../records/List';
import { chain, makeRecords, run, STEPS, type Chain, type Made } from './chain';
import { changedAt, SLIDERS, valueAt } from './truth';

const TITLE = 'Try without a device';
const QUESTION = 'What would I get, before I measure anything?';
const FOLDER = 'bench';

type Values = Record<string, unknown>;

export function Try() {
  const offered = useResource<Options>('options').value;
  if (!offered) {
    return (
      <>
        <Head title={TITLE} question={QUESTION} />
        <Waiting height={420} />
      </>
    );
  }
  return <Room offered={offered} />;
}

function Room({ offered }: { offered: Options }) {
  const [truth, setTruth] = useState<Values>(offered.truth_default);
  const [plan, setPlan] = useState<Values>(offered.plan_default);
  const [seed, setSeed] = useState(1);
  const [made, keep] = useState<Made | null>(null);
  const [busy, mark] = useState(false);
  const [problem, complain] = useState<Complaint | null>(null);
  const steps = useSignal(chain);
  const shown = steps?.made ?? made;
  useEffect(() => {
    command.value = shown?.command ?? null;
  }, [shown]);

  const work = async (act: () => Promise<void>): Promise<void> => {
    mark(true);
    complain(null);
    await act().catch((error: unknown) => {
      complain(error instanceof Refusal ? error.complaint : { what: String(error) });
    });
    mark(false);
  };
  const request = { folder: FOLDER, truth, plan, seed };
  const make = (): Promise<void> => work(async () => keep(await makeRecords(request)));
  return (
    <>
      <Head title={TITLE} question={QUESTION}>
        <button type="button" disabled={busy} onClick={() => void make()}>
          Make the records
        </button>
        <button type="button" class="primary" disabled={busy} onClick={() => void work(() => run(request))}>
          Run the whole chain
        </button>
      </Head>
      <div class="stack">
        <Examples />
        {problem && <Failure problem={problem} />}
        <div class="cols g-try hr">
          <div>
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
                <Icon name="reset" />
                Default
              </button>
            </div>
            <Sliders truth={truth} change={(next) => setTruth(next as Values)} />
            <details>
              <summary>All of the truth</summary>
              <div class="set twos">
                <SchemaForm schema={offered.truth} root={offered.truth} value={truth} change={setTruth} />
              </div>
            </details>
            <details>
              <summary>Records that are made</summary>
              <div class="set twos">
                <SchemaForm schema={offered.plan} root={offered.plan} value={plan} change={setPlan} />
                <label class="f">
                  <span>seed of the noise</span>
                  <input
                    type="number"
                    min="0"
                    value={seed}
                    onChange={(event) => setSeed(Number(event.currentTarget.value))}
                  />
                </label>
              </div>
            </details>
            <p class="soft s gap">
              The truth lies outside every model class that hysteron fits, so that nothing comes out
              perfect. A change shows when the records are made again.
            </p>
          </div>
          {shown?.records[0] ? (
            <Loop key={shown.command.shell} record={shown.records[0]} />
          ) : (
            <div class="card">
              <h2>No record of the bench yet</h2>
              <p class="soft">
                “Make the records” writes them into the folder {FOLDER}; “Run the whole chain” goes on to
                the model, its scores, a drive and the code.
              </p>
            </div>
          )}
        </div>
        <Steps now={steps} />
      </div>
    </>
  );
}

function Sliders({ truth, change: set }: { truth: unknown; change: (truth: unknown) => void }) {
  return (
    <div>
      {SLIDERS.map((slider) => {
        const value = valueAt(truth, slider.path);
        if (value === null) return null;
        const text = `${fixed(value * (slider.factor ?? 1), slider.digits)} ${slider.unit}`.trim();
        return (
          <label class="slider" key={slider.label}>
            <span>{slider.label}</span>
            <input
              type="range"
              min={slider.low}
              max={slider.high}
              step={slider.step}
              value={value}
              aria-valuetext={text}
              onInput={(event) => set(changedAt(truth, slider.path, Number(event.currentTarget.value)))}
            />
            <span class="n">{text}</span>
          </label>
        );
      })}
    </div>
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
        const [first] = own;
        return (
          <div class="card" key={example.name}>
            <h2>
              {example.name} <Tag>measured</Tag>
            </h2>
            <p class="soft s">{example.title}</p>
            {first ? (
              <a class="btn" href={address({ r: first.id }, 'records')}>
                <Glyph points={first.glyph} />
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

function Loop({ record }: { record: string }) {
  const entry = useLatest<RecordEntry>(path('records', record)).value;
  const from = entry ? query({ x: entry.input, y: entry.output, pixels: 700 }) : '';
  const curve = useLatest<Curve>(entry ? `${path('records', record)}/curve${from}` : null).value;
  if (!curve) return <Waiting height={330} />;
  return (
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
  );
}

const WHAT = [
  'loop, sweep and sines',
  'on the loop and the sweep',
  'on the sines',
  'the first sine',
  'C99, single, inverse',
];

function Steps({ now }: { now: Chain | null }) {
  const list = useSignal(jobs);
  const job = list.find((one) => one.id === now?.job);
  const at = now?.done.length ?? 0;
  const text = (i: number): string => {
    const done = now?.done[i];
    if (done) return done;
    if (!now || i !== at || now.state !== 'running') return now ? 'waits' : '';
    if (i === 1 && job?.cost != null) return `${significant(job.cost)} ${job.unit} so far`;
    return 'works';
  };
  const to = now?.model ? { m: now.model } : {};
  return (
    <div>
      <div class="ph">
        <h2>From excitation to controller</h2>
        <span class="soft s">
          {now?.state === 'running' ? `step ${at + 1} of ${STEPS.length}` : now ? now.state : 'not run yet'}
        </span>
      </div>
      <ol class="steps">
        {STEPS.map((step, i) => (
          <li key={step}>
            <b class="rw">
              <Icon name={i < at ? 'ok' : i === at && now?.state === 'running' ? 'run' : 'dot'} />
              {step}
            </b>
            <small>{WHAT[i]}</small>
            <small class="ink">{text(i)}</small>
          </li>
        ))}
      </ol>
      {now?.problem && <Failure problem={now.problem} />}
      {now?.state === 'done' && (
        <p class="row wrap gap">
          <a class="btn" href={address(to, 'identify')}>
            See the model
          </a>
          <a class="btn" href={address(to, 'home')}>
            Take the code home
          </a>
        </p>
      )}
    </div>
  );
}
