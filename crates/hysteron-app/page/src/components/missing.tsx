// What an address names and the workspace does not have: said, instead of showing something else silently.
import { useResource } from '../api/resource';
import type { ModelEntry, RecordEntry } from '../api/types';
import { route, settle } from '../route';
import { useSignal } from '../signal';
import { jobs } from '../store';
import { Finding } from './words';

export function Missing() {
  const { query } = useSignal(route);
  const records = useResource<RecordEntry[]>('records').value;
  const models = useResource<ModelEntry[]>('models').value;
  const list = useSignal(jobs);
  const [m, r, job] = [query.get('m'), query.get('r'), query.get('job')];
  const missing: [string, string][] = [];
  if (m && models && !models.some((model) => model.id === m)) missing.push(['m', m]);
  if (r && !r.startsWith('!') && records && !records.some((record) => record.id === r))
    missing.push(['r', r]);
  if (job && list.length > 0 && !list.some((one) => String(one.id) === job))
    missing.push(['job', `job ${job}`]);
  if (missing.length === 0) return null;
  return (
    <Finding
      kind="warn"
      actions={
        <button
          type="button"
          onClick={() => settle(Object.fromEntries(missing.map(([key]) => [key, null])))}
        >
          Show what is there
        </button>
      }
    >
      <b>{missing.map(([, name]) => name).join(', ')}</b> {missing.length === 1 ? 'is' : 'are'} not in this
      workspace: renamed, deleted, or of another folder. What is shown below is something else.
    </Finding>
  );
}
