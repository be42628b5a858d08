// Jobs of this workspace with their commands.
import { useEffect } from 'preact/hooks';
import type { Job } from '../api/types';
import { act, command, titleOf } from '../components/dock';
import { Failure, Head } from '../components/words';
import { seconds } from '../format';
import { address } from '../route';
import { useSignal } from '../signal';
import { jobs } from '../store';
import { Repeat } from './home';

export function History() {
  const list = useSignal(jobs);
  useEffect(() => {
    command.value = list[0]?.command ?? null;
  }, [list[0]?.id]);
  return (
    <>
      <Head title="History" question="What was computed here, and with which command?" />
      <div class="cols g-cmp">
        <ul class="jobs">
          {list.map((job) => (
            <Entry key={job.id} job={job} />
          ))}
          {list.length === 0 && <li class="soft">No job has run in this workspace.</li>}
        </ul>
        <Repeat />
      </div>
    </>
  );
}

function Entry({ job }: { job: Job }) {
  const { models, reports } = job.result;
  const [model] = models;
  const place =
    job.request.kind === 'identify'
      ? address(model && job.state === 'done' ? { m: model } : { job: String(job.id) }, 'identify')
      : address({ job: String(job.id) }, 'compare');
  const active = job.state === 'running' || job.state === 'waiting';
  return (
    <li class="card">
      <div class="row">
        <a href={place}>
          <b>{titleOf(job)}</b>
        </a>
        <span class={`tag ${job.state === 'failed' ? 'bad' : job.state === 'done' ? 'good' : ''}`}>
          {job.state}
        </span>
        <span class="soft s">
          {job.created.replace('T', ' ').slice(0, 16)} · {seconds(job.elapsed_s)}
          {models.length + reports.length > 0 ? ` · ${[...models, ...reports].join(', ')}` : ''}
        </span>
        <span class="sp" />
        {active && (
          <button type="button" onClick={() => void act(job, 'stop')}>
            Stop
          </button>
        )}
        {job.resumable && !active && (
          <button type="button" onClick={() => void act(job, 'resume')}>
            Go on
          </button>
        )}
        {!active && (
          <button type="button" class="quiet" onClick={() => void act(job, 'delete')}>
            Delete
          </button>
        )}
      </div>
      <code class="cmd" tabIndex={0} role="group" aria-label="Command of the job">
        {job.command.shell}
      </code>
      {job.error && <Failure problem={job.error} />}
    </li>
  );
}
