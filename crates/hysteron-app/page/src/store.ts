// What the server tells without being asked: jobs, running fits, lists that changed.
import { changed, listsChanged } from './api/resource';
import { get, path } from './api/client';
import { progressed } from './api/requests';
import type {
  CostPoint,
  Curve,
  Job,
  Live,
  LiveLoop,
  LiveUpdate,
  RequestProgress,
  Stage,
} from './api/types';
import { Signal } from './signal';

/** Jobs, newest first. */
export const jobs = new Signal<Job[]>([]);
/** The server answers; `null` before the first answer. */
export const connected = new Signal<boolean | null>(null);

export interface Running {
  job: number;
  costs: CostPoint[];
  measured: Curve | null;
  latest: LiveLoop | null;
}
/** The fit that is followed. */
export const running = new Signal<Running | null>(null);

const FIRST_WAIT = 500;
const LONGEST_WAIT = 5_000;
const COSTS_KEPT = 4_000;

export function follow(): void {
  let wait = FIRST_WAIT;
  const open = (): void => {
    const source = new EventSource('api/v1/events');
    source.onopen = () => {
      wait = FIRST_WAIT;
      // What was missed while there was no connection is fetched as a whole.
      if (connected.value === null) listsChanged();
      else if (!connected.value) changed('');
      connected.value = true;
      void refresh();
    };
    source.onerror = () => {
      connected.value = false;
      source.close();
      setTimeout(open, wait);
      wait = Math.min(LONGEST_WAIT, wait * 2);
    };
    const listen = <T>(name: string, act: (value: T) => void): void =>
      source.addEventListener(name, (event) => act(JSON.parse((event as MessageEvent<string>).data) as T));
    listen<Job>('job', took);
    listen<LiveUpdate>('live', moved);
    listen<RequestProgress>('progress', progressed);
    listen('jobs', () => void refresh());
    for (const list of ['records', 'models', 'reports']) {
      listen(list, () => {
        changed(list);
        changed('workspace');
      });
    }
  };
  open();
  void refresh();
}

async function refresh(): Promise<void> {
  jobs.value = newestFirst(await get<Job[]>('jobs').catch(() => jobs.value));
  const now = current();
  if (now?.request.kind === 'identify') void watch(now.id);
}

const newestFirst = (list: Job[]): Job[] => [...list].sort((a, b) => b.id - a.id);

/** The job that runs, else the one that ended last. */
export function current(): Job | undefined {
  return (
    jobs.value.find((job) => job.state === 'running') ?? jobs.value.find((job) => job.state === 'waiting')
  );
}

export function took(job: Job): void {
  const others = jobs.value.filter((other) => other.id !== job.id);
  const before = jobs.value.find((other) => other.id === job.id);
  // The answer to a request may come after the news of what became of it.
  if (before && before.revision > job.revision) return;
  jobs.value = newestFirst([job, ...others]);
  if (job.state === 'running' && job.request.kind === 'identify' && running.value?.job !== job.id)
    void watch(job.id);
  if (before && before.state !== job.state) changed('history');
}

export function forget(id: number): void {
  jobs.value = jobs.value.filter((job) => job.id !== id);
}

/** Fetches what a fit has shown so far; events continue it. */
export async function watch(id: number): Promise<void> {
  if (running.value?.job !== id) running.value = { job: id, costs: [], measured: null, latest: null };
  const live = await get<Live>(path('jobs', String(id), 'live')).catch(() => null);
  if (!live || running.value?.job !== id) return;
  const latest = running.value.latest ?? live.latest;
  running.value = { job: id, costs: live.costs, measured: live.measured, latest };
}

/** The stages with the newest cost in the last one. */
function withCost(stages: Stage[], point: CostPoint): Stage[] {
  return stages.map((stage, i) =>
    i === point.stage ? { ...stage, cost: Math.min(stage.cost ?? point.cost, point.cost) } : stage,
  );
}

function moved(update: LiveUpdate): void {
  const now = running.value;
  if (now?.job !== update.job) return void watch(update.job);
  const costs = update.cost ? [...now.costs, update.cost].slice(-COSTS_KEPT) : now.costs;
  running.value = { ...now, costs, latest: update.latest ?? now.latest };
  if (!now.measured && update.latest) void watch(update.job);
  jobs.value = jobs.value.map((job) => {
    if (job.id !== update.job) return job;
    const { fraction, left_s, cost } = update;
    const best = cost ? { cost: cost.cost, stages: withCost(job.stages, cost) } : {};
    return { ...job, fraction, left_s, ...best };
  });
}
