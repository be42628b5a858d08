// A fit while it runs, or what it had when it was stopped.
import { useEffect, useMemo } from 'preact/hooks';
import { path } from '../../api/client';
import { useLatest } from '../../api/resource';
import type { Job, RecordDetail, RecordEntry } from '../../api/types';
import { act } from '../../components/dock';
import { Icon } from '../../components/icon';
import { Failure, Finding, Numbers, Waiting, type Quantity, Prose } from '../../components/words';
import { fileName, left, quantity, seconds, significant } from '../../format';
import { Plot } from '../../plot/Plot';
import type { Line, Range, Spec } from '../../plot/spec';
import { useSignal } from '../../signal';
import { running, watch, type Running } from '../../store';
import { asLine, axisLabel } from '../records/Curves';
import { floorNote } from './Done';
import { Done } from './Done';

export function Live({ job, records }: { job: Job; records: RecordEntry[] }) {
  const now = useSignal(running);
  const shown = now?.job === job.id ? now : null;
  useEffect(() => {
    if (running.value?.job !== job.id) void watch(job.id);
  }, [job.id]);
  const runs = job.state === 'running' || job.state === 'waiting';
  const kept = runs ? undefined : job.result.models[0];
  return (
    <div class="stack">
      {job.state !== 'running' && <Ended job={job} />}
      {runs && job.warning && (
        <Finding kind="warn">
          <Prose text={job.warning} />.
        </Finding>
      )}
      {kept ? (
        <Done id={kept} records={records} />
      ) : (
        <>
          <Now job={job} shown={shown} />
          <div class="cols g-plots">
            <LoopSoFar shown={shown} runs={runs} />
            <div>
              <ResidualSoFar shown={shown} />
              <Cost job={job} shown={shown} />
            </div>
          </div>
        </>
      )}
      <div class="cols g-2 hr">
        <Stages job={job} />
        <div>
          <div class="ph">
            <h2>{runs ? 'While it runs' : 'To go on'}</h2>
          </div>
          <p class="soft">
            {runs
              ? 'Other rooms can be used; this fit goes on, also if the page is closed. Stop keeps the ' +
                'best model so far, from which the fit can go on later.'
              : 'Go on starts from the searches that are kept and ends in the same model as an ' +
                'uninterrupted fit. A changed setting begins a new fit; this one stays in History.'}
          </p>
        </div>
      </div>
    </div>
  );
}

function Ended({ job }: { job: Job }) {
  const stage = job.stages[job.stages.length - 1]?.name ?? 'the queue';
  if (job.state === 'failed') return job.error && <Failure problem={job.error} />;
  if (job.state === 'waiting') return <Finding kind="note">{`Waits: ${job.ahead} before it.`}</Finding>;
  const model = job.result.models[0];
  const why = job.state === 'interrupted' ? 'Interrupted, the program ended' : 'Stopped';
  return (
    <Finding
      kind="warn"
      actions={
        <>
          {model && (
            <a class="btn" href={`#/identify?m=${encodeURIComponent(model)}`}>
              Use as it is
            </a>
          )}
          <button type="button" onClick={() => void act(job, 'delete')}>
            Delete
          </button>
        </>
      }
    >
      <b>
        {why} after {seconds(job.elapsed_s)} in “{stage}”;{' '}
        {model
          ? 'the best so far is kept.'
          : job.resumable
            ? 'there is no model yet, the searches are kept.'
            : 'there is no model yet, and nothing to go on from.'}
      </b>
      {job.cost != null &&
        ` Its cost is ${significant(job.cost, 4)} ${job.unit}; later stages were still to come.`}
    </Finding>
  );
}

function Now({ job, shown }: { job: Job; shown: Running | null }) {
  const latest = shown?.latest;
  const record = useLatest<RecordDetail>(latest ? path('records', latest.record) : null).value;
  const floor = record?.inspection?.noise_floor_rms;
  const unit = latest?.residual.up.unit ?? job.unit;
  const list: Quantity[] = [];
  const add = (label: string, value: number | null | undefined, own: string, note: string): void => {
    const [number, symbol] = value == null ? ['–', ''] : quantity(value, own);
    list.push({ label, value: number, unit: symbol, note });
  };
  add('RMSE so far', latest?.rmse, unit, latest ? 'of the loop that is drawn' : 'comes with the joint fit');
  add('best cost', job.cost, job.unit, 'weighted, of this stage');
  add('noise floor', floor, unit, floor == null ? '' : floorNote(floor, latest?.rmse));
  const elapsed = Math.max(job.elapsed_s, shown?.costs[shown.costs.length - 1]?.time_s ?? 0);
  const [time, symbol] = seconds(elapsed).split(' ');
  const runs = job.state === 'running';
  list.push({
    label: 'elapsed',
    value: time ?? '',
    unit: symbol,
    note: runs ? (job.left_s != null ? left(job.left_s) : 'time left not known yet') : job.state,
  });
  return <Numbers list={list} />;
}

function LoopSoFar({ shown, runs }: { shown: Running | null; runs: boolean }) {
  const { measured, latest } = shown ?? {};
  const spec = useMemo<Spec | null>(() => {
    if (!measured) return null;
    const name = latest ? `, ${fileName(latest.record)}` : '';
    return {
      key: 'loop',
      title: `Loop${name}: ${measured.shown}`,
      description: 'Record and best model so far.',
      height: 356,
      loop: true,
      hold: `${shown?.job} ${latest?.record}`,
      x: { label: axisLabel('drive', measured.across), unit: measured.across.unit },
      y: { label: axisLabel('output', measured.up), unit: measured.up.unit },
      lines: [
        asLine(measured, 'measured', 4, 'record'),
        ...(latest
          ? [asLine(latest.model, 'model', 1.3, runs ? 'model so far' : 'best model so far')]
          : []),
      ],
      tools: ['zoom', 'pan'],
    };
  }, [measured, latest, runs]);
  return spec ? <Plot spec={spec} /> : <Waiting height={400} text="The record is read." />;
}

function ResidualSoFar({ shown }: { shown: Running | null }) {
  const latest = shown?.latest;
  const spec = useMemo<Spec | null>(() => {
    if (!latest) return null;
    const { residual, residual_axis: axis } = latest;
    return {
      key: 'residual',
      title: 'Residual so far',
      description: 'Record minus model over time.',
      height: 178,
      flat: true,
      zero: true,
      hold: `${shown?.job} ${latest.record} ${latest.stage}`,
      x: { label: 'time (s)', unit: 's' },
      y: { label: `record − model (${axis.unit})`, unit: axis.unit, range: [axis.low, axis.high] },
      lines: [asLine(residual, 'residual', 1.2)],
    };
  }, [latest]);
  return spec ? (
    <Plot spec={spec} />
  ) : (
    <Waiting height={204} text="The residual is drawn with the first whole model: stage “joint fit”." />
  );
}

/** Outwards to 1, 2, 5 times a power of ten: an axis that grows seldom, and by a step. */
function outwards(value: number, up: boolean): number {
  const power = 10 ** Math.floor(Math.log10(value));
  const steps = up ? [1, 2, 5, 10] : [10, 5, 2, 1];
  const step = steps.find((s) => (up ? s * power >= value : s * power <= value)) ?? 1;
  return step * power;
}

function Cost({ job, shown }: { job: Job; shown: Running | null }) {
  const costs = shown?.costs ?? [];
  const spec = useMemo<Spec | null>(() => {
    if (costs.length === 0) return null;
    const stages = [...new Set(costs.map((point) => point.stage))];
    const last = stages[stages.length - 1];
    const values = costs.map((point) => point.cost).filter((cost) => cost > 0);
    const end = costs[costs.length - 1]?.time_s ?? 1;
    const range: Range = [outwards(Math.min(...values), false), outwards(Math.max(...values), true)];
    const lines = stages.map((stage): Line => {
      const own = costs.filter((point) => point.stage === stage);
      return {
        x: own.map((point) => point.time_s),
        y: own.map((point) => point.cost),
        color: stage === last ? 'band' : 'rule2',
        width: stage === last ? 2 : 1.4,
      };
    });
    return {
      key: 'cost',
      title: 'Cost, best so far',
      description: 'Best cost over time, stage by stage; early stages use thinned data.',
      height: 178,
      x: { label: 'time (s)', unit: 's', range: [0, outwards(Math.max(end, 1), true)] },
      y: { label: `weighted cost${job.unit ? ` (${job.unit})` : ''}`, unit: job.unit, log: true, range },
      lines: lines.reverse(),
    };
  }, [costs.length, job.unit]);
  return spec ? (
    <Plot spec={spec} />
  ) : (
    <Waiting height={204} text="The cost is drawn from the first evaluation on." />
  );
}

/** Stages whose names go on once they are entered. */
const PLANNED: Record<string, string> = {
  'start of': 'start of each record',
  families: 'families of hysteresis, compared',
};

/** Stages that are still to come; one may be left out. */
function toCome(job: Job): string[] {
  const planned = job.planned ?? [];
  const entered = job.stages.map((stage) => {
    const matches = planned.filter((name) => stage.name.startsWith(name));
    const longest = matches.sort((a, b) => b.length - a.length)[0];
    return longest === undefined ? -1 : planned.indexOf(longest);
  });
  return planned.slice(Math.max(-1, ...entered) + 1);
}

function Stages({ job }: { job: Job }) {
  const runs = job.state === 'running';
  return (
    <div>
      <div class="ph">
        <h2>Stages</h2>
        <span class="soft s">
          best cost each; early stages use thinned data, so that costs of stages differ
        </span>
      </div>
      <ol class="stages">
        {job.stages.map((stage, i) => {
          const now = i === job.stages.length - 1;
          return (
            <li key={`${i} ${stage.name}`} class={now && runs ? 'now' : ''}>
              <Icon name={now ? (runs ? 'run' : 'half') : 'ok'} />
              <span>{stage.name}</span>
              <span class="soft">
                {stage.cost != null ? `${significant(stage.cost, 4)} ${job.unit}` : ''}
              </span>
            </li>
          );
        })}
        {runs &&
          toCome(job).map((name) => (
            <li key={`planned ${name}`} class="todo">
              <Icon name="dot" />
              <span>{PLANNED[name] ?? name}</span>
            </li>
          ))}
      </ol>
    </div>
  );
}
