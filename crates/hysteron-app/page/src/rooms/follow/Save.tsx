// The drive as a file: written into the workspace and handed to the browser.
import { useState } from 'preact/hooks';
import { change, href, path, Refusal, type Complaint } from '../../api/client';
import { changed } from '../../api/resource';
import type { Followed } from '../../api/types';

const ENDINGS = ['csv', 'npz', 'mat'];

export function Save(props: { at: string; device: string; request: object; ready: boolean }) {
  const { at, request, ready } = props;
  const [ending, choose] = useState('csv');
  const [problem, complain] = useState<Complaint | null>(null);
  const save = async (): Promise<void> => {
    try {
      const name = `drive.${ending}`;
      const save = props.device ? `${props.device}/${name}` : name;
      const written = await change<Followed>('POST', `${at}/follow`, { ...request, save });
      changed('records');
      if (written.file) {
        const link = document.createElement('a');
        link.href = href(`${path('records', written.file)}/file`);
        link.download = name;
        link.click();
      }
      complain(null);
    } catch (error) {
      complain(error instanceof Refusal ? error.complaint : { what: String(error) });
    }
  };
  return (
    <>
      {problem && <span class="tag bad">{problem.what}</span>}
      <select
        aria-label="Format of the drive"
        value={ending}
        onChange={(event) => choose(event.currentTarget.value)}
      >
        {ENDINGS.map((name) => (
          <option key={name} value={name}>
            {name.toUpperCase()}
          </option>
        ))}
      </select>
      <button
        type="button"
        class="primary"
        disabled={!ready}
        title="A copy is written into the workspace, as a record that no fit takes"
        onClick={() => void save()}
      >
        Download the drive
      </button>
    </>
  );
}
