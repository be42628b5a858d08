// A table of samples as a file: written into the workspace, where no fit takes it, and handed to the browser.
import { useState } from 'preact/hooks';
import { Refusal, type Complaint } from '../api/client';
import { handed } from './handed';

const ENDINGS = ['csv', 'npz', 'mat'];

export function SaveAs(props: {
  /** Name of the file without its ending. */
  stem: string;
  device: string;
  /** What is in it, for the list of formats. */
  what: string;
  label: string;
  ready: boolean;
  primary?: boolean;
  /** Has the server write the file; the name of what was written. */
  write: (file: string) => Promise<string | null>;
}) {
  const [ending, choose] = useState('csv');
  const [problem, complain] = useState<Complaint | null>(null);
  const save = async (): Promise<void> => {
    try {
      const name = `${props.stem}.${ending}`;
      handed(await props.write(props.device ? `${props.device}/${name}` : name));
      complain(null);
    } catch (error) {
      complain(error instanceof Refusal ? error.complaint : { what: String(error) });
    }
  };
  return (
    <>
      {problem && <span class="tag bad">{problem.what}</span>}
      <select
        aria-label={`Format of the ${props.what}`}
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
        class={props.primary ? 'primary' : ''}
        disabled={!props.ready}
        title="A copy is written into the workspace, as a record that no fit takes"
        onClick={() => void save()}
      >
        {props.label}
      </button>
    </>
  );
}
