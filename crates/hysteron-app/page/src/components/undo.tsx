// Undo of the last deletion; the file lies in the trash folder until then.
import { change, path } from '../api/client';
import { putBack } from '../api/resource';
import { fileName } from '../format';
import { Signal, useSignal } from '../signal';
import { Icon } from './icon';

interface Deleted {
  token: string;
  id: string;
}

const last = new Signal<Deleted | null>(null);

export function deleted(what: Deleted): void {
  last.value = what;
}

export function Undo() {
  const now = useSignal(last);
  if (!now) return null;
  const restore = async (): Promise<void> => {
    await change('POST', `${path('trash', now.token)}/restore`);
    last.value = null;
    putBack();
  };
  return (
    <div class="undo" role="status">
      <span>
        <b class="mono">{fileName(now.id)}</b> lies in the trash folder.
      </span>
      <button type="button" onClick={() => void restore()}>
        Put it back
      </button>
      <button type="button" class="quiet" aria-label="Close" onClick={() => (last.value = null)}>
        <Icon name="close" />
      </button>
    </div>
  );
}
