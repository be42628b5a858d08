// From excitation to controller on the bench, step by step; it goes on while other rooms are looked at.
import { change, get, path, query, Refusal, type Complaint } from '../../api/client';
import { changed } from '../../api/resource';
import type { Command, Followed, Job, ModelDetail, Preview, RecordEntry, Scored } from '../../api/types';
import { bytes, count, integer, quantityText } from '../../format';
import { Signal } from '../../signal';
import { jobs, took } from '../../store';
import { FITTED } from '../records/roles';

export const STEPS = ['Excite', 'Identify', 'Validate', 'Follow', 'Export'] as const;

export interface Made {
  records: string[];
  samples: number;
  command: Command;
}

export interface Chain {
  /** Steps that are done, in words. */
  done: string[];
  state: 'running' | 'done' | 'failed';
  made: Made;
  job?: number;
  model?: string;
  problem?: Complaint;
}

export const chain = new Signal<Chain | null>(null);

export interface Request {
  folder: string;
  truth: Record<string, unknown>;
  plan: Record<string, unknown>;
  seed: number;
}

export async function makeRecords(request: Request): Promise<Made> {
  const made = await change<Made>('POST', 'bench', request);
  changed('records');
  return made;
}

export async function run(request: Request): Promise<void> {
  const made = await makeRecords(request);
  let now: Chain = { done: [], state: 'running', made };
  const say = (changes: Partial<Chain>): void => {
    now = { ...now, ...changes };
    chain.value = now;
  };
  const did = (text: string): void => say({ done: [...now.done, text] });
  try {
    did(`${count(made.records.length, 'record')}, ${integer(made.samples)} samples`);
    const entries = (await get<RecordEntry[]>('records')).filter((entry) =>
      made.records.includes(entry.id),
    );
    // They may still be being read for the list; a fit reads them itself.
    const fit = entries.filter((entry) => FITTED.includes(entry.settings.role)).map((entry) => entry.id);
    const job = await change<Job>('POST', 'jobs', { kind: 'identify', records: fit });
    took(job);
    say({ job: job.id });
    const model = await modelOf(job.id);
    say({ model });
    const detail = await get<ModelDetail>(path('models', model));
    const errors = (list: { rmse: number; unit: string }[]): string =>
      list.map((score) => quantityText(score.rmse, score.unit)).join(', ') + ' rms';
    did(errors(detail.scores));

    const held = entries.filter((entry) => entry.settings.role === 'validate').map((entry) => entry.id);
    if (held.length > 0) {
      const scored = await change<Scored>('POST', `${path('models', model)}/scores`, { records: held });
      did(errors(scored.records.flatMap((row) => row.score ?? [])));
    } else did('no record was held out');

    const followed = await change<Followed>('POST', `${path('models', model)}/follow`, {
      reference: { from: 'record', id: held[0] ?? fit[0] },
    });
    did(`${quantityText(followed.predicted_rms_error, followed.output_unit)} rms predicted`);

    const settings = query({ as: 'c', single: true, inverse: true });
    const preview = await get<Preview>(`${path('models', model)}/preview${settings}`);
    const size = preview.files.reduce((sum, file) => sum + file.bytes, 0);
    did(`${count(preview.files.length, 'file')}, ${bytes(size)}`);
    say({ state: 'done' });
  } catch (error) {
    say({ state: 'failed', problem: error instanceof Refusal ? error.complaint : { what: String(error) } });
  }
}

/** Waits for the end of a fit; its model. */
function modelOf(id: number): Promise<string> {
  return new Promise((resolve, reject) => {
    const look = (): void => {
      const job = jobs.value.find((one) => one.id === id);
      if (!job || job.state === 'running' || job.state === 'waiting') return;
      stop();
      const model = job.result.models[0];
      if (job.state === 'done' && model) resolve(model);
      else reject(new Refusal(0, job.error ?? { what: `The fit was ${job.state}.` }));
    };
    const stop = jobs.subscribe(look);
    look();
  });
}
