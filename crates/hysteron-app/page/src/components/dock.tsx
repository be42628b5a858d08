// The dock: the command that does what the page shows, and the job that runs.
import { useState } from 'preact/hooks';
import { change, path, Refusal } from '../api/client';
import type { Command, Job } from '../api/types';
import { left, seconds } from '../format';
import { address, route, settle } from '../route';
import { Signal, useSignal } from '../signal';
import { forget, jobs, took } from '../store';
import { Icon } from './icon';

/** Command of what the room shows; a room sets it. */
export const command = new Signal<Command | null>(null);
/** What was just done, for screen readers. */
export const said = new Signal('');

export function copy(text: string): void {
  void navigator.clipboard?.writeText(text).then(
    () => (said.value = 'Copied'),
    () => (said.value = 'The browser does not allow to copy'),
  );
}

/** Kind and name of a job, once where they are the same. */
export function titleOf(job: Job): string {
  return job.name === job.request.kind ? job.name : `${job.request.kind} ${job.name}`;
}

export async function act(job: Job, what: 'stop' | 'resume' | 'delete'): Promise<void> {
  const at = path('jobs', String(job.id));
  try {
    if (what === 'delete') {
      await change('DELETE', at);
      forget(job.id);
    } else {
      const answer = await change<Job | undefined>('POST', `${at}/${what}`);
      if (answer?.id) took(answer);
    }
  } catch (error) {
    said.value = error instanceof Refusal ? error.message : String(error);
  }
}

export function Dock() {
  return (
    <footer class="dock" aria-label="Command and job">
      <Echo />
      <JobBar />
    </footer>
  );
}

/** Shell or Python, for every command that the page shows. */
export function Language({ of }: { of: string }) {
  const python = useSignal(route).query.get('lang') === 'python';
  return (
    <span class="seg" role="group" aria-label={`Language of the ${of}`}>
      <button type="button" aria-pressed={!python} onClick={() => settle({ lang: null })}>
        Shell
      </button>
      <button type="button" aria-pressed={python} onClick={() => settle({ lang: 'python' })}>
        Python
      </button>
    </span>
  );
}

function Echo() {
  const now = useSignal(command);
  const { query } = useSignal(route);
  const python = query.get('lang') === 'python';
  const text = now ? (python ? now.python : now.shell) : '';
  return (
    <div class="echo">
      <Language of="command" />
      <code tabIndex={0} role="group" aria-label="The command that does the same">
        {text || '# nothing to run yet'}
      </code>
      <button type="button" class="quiet" data-key="c" disabled={!text} onClick={() => copy(text)}>
        <Icon name="copy" />
        <span>Copy</span>
      </button>
    </div>
  );
}

const ENDED: Partial<Record<Job['state'], string>> = {
  done: 'done',
  stopped: 'stopped, the best so far is kept',
  failed: 'failed',
  interrupted: 'interrupted, the best so far is kept',
};

function ended(job: Job): string {
  const isRace = job.request.kind === 'compare';
  if (isRace && (job.state === 'stopped' || job.state === 'interrupted'))
    return `${job.state}, finished structures are kept`;
  return ENDED[job.state] ?? '';
}

function JobBar() {
  const list = useSignal(jobs);
  const now = list.find((job) => job.state === 'running') ?? list.find((job) => job.state === 'waiting');
  const waiting = list.filter((job) => job.state === 'waiting' && job !== now);
  const last = list.find((job) => job.ended);
  const history = (
    <a class="btn quiet" href={address({}, 'history')}>
      History
    </a>
  );
  if (!now) {
    const state = { failed: 'bad', interrupted: 'int', stopped: 'int' }[String(last?.state)] ?? '';
    return (
      <div class={`job ${state}`} role="status">
        <span class="st" />
        <span class="tx soft">
          {last
            ? `No job runs. Last: ${titleOf(last)}, ${ended(last)}, ${seconds(last.elapsed_s)}`
            : 'No job runs.'}
        </span>
        <span class="sp" />
        {last?.resumable && (
          <button type="button" onClick={() => void act(last, 'resume')}>
            Go on
          </button>
        )}
        {history}
      </div>
    );
  }
  const stage = now.stages[now.stages.length - 1];
  const place = stage ? `${stage.name}, stage ${now.stages.length}` : 'waits';
  return (
    <div class="job run">
      <span class="st" />
      <b class="nw">{now.name}</b>
      <span class="tx">
        {place}
        {now.left_s != null ? ` · ${left(now.left_s)}` : ''}
      </span>
      <progress class="bar" max={1} value={now.fraction} aria-label={`${now.name}: share done`} />
      <span class="sp" />
      {waiting.length > 0 && (
        <span class="soft nw">queue: {waiting.map((job) => job.name).join(', ')}</span>
      )}
      <StopButton job={now} />
      {history}
    </div>
  );
}

/** `keeps`: what a stop keeps; empty: nothing yet. */
export function StopButton({
  job,
  primary,
  keeps = 'the best',
}: {
  job: Job;
  primary?: boolean;
  keeps?: string;
}) {
  const [asked, ask] = useState(-1);
  const stopping = asked === job.id;
  return (
    <button
      type="button"
      class={primary ? 'primary stop' : ''}
      data-key={primary ? 's' : 's2'}
      aria-disabled={stopping}
      onClick={() => {
        if (stopping) return;
        ask(job.id);
        void act(job, 'stop');
      }}
    >
      <Icon name="stop" />
      {stopping ? 'Stopping…' : primary && keeps ? `Stop, keep ${keeps}` : 'Stop'}
    </button>
  );
}
