// A computation that the page waits for: how far it is, the time left, a way to end it.
import { open } from '../api/requests';
import { left } from '../format';
import { useSignal } from '../signal';
import { Icon } from './icon';

/** The open requests of an address, e.g. `models/stage.json/track`; nothing for one that answers at once. */
export function Working({ at, what }: { at: string; what: string }) {
  const requests = useSignal(open).filter((request) => request.resource.startsWith(at));
  return (
    <>
      {requests.map(({ name, progress, stop }) => (
        <div class="working" key={name} role="group" aria-label={what}>
          <span class="tx">
            {what}
            {progress ? `: ${progress.stage}` : ''}
            {progress?.left_s != null ? ` · ${left(progress.left_s)}` : ''}
          </span>
          <progress
            class="bar"
            max={1}
            value={progress?.fraction ?? 0}
            aria-label={`${what}: share done`}
          />
          <button type="button" onClick={stop}>
            <Icon name="stop" />
            Stop
          </button>
        </div>
      ))}
    </>
  );
}
