// Where files are dropped or chosen.
import { useEffect, useRef, useState } from 'preact/hooks';
import { useResource } from '../../api/resource';
import type { Workspace } from '../../api/types';
import { bytes } from '../../format';
import { send } from './uploads';

/** Files dropped anywhere on the page go into the workspace while the room is open. */
export function useDropped(): boolean {
  const [over, set] = useState(false);
  useEffect(() => {
    const carries = (event: DragEvent): boolean => event.dataTransfer?.types.includes('Files') ?? false;
    const enter = (event: DragEvent): void => {
      if (!carries(event)) return;
      event.preventDefault();
      set(true);
    };
    const leave = (event: DragEvent): void => {
      if (!event.relatedTarget) set(false);
    };
    const dropped = (event: DragEvent): void => {
      if (!carries(event)) return;
      event.preventDefault();
      set(false);
      void send(event.dataTransfer?.files ?? []);
    };
    addEventListener('dragover', enter);
    addEventListener('dragleave', leave);
    addEventListener('drop', dropped);
    return () => {
      removeEventListener('dragover', enter);
      removeEventListener('dragleave', leave);
      removeEventListener('drop', dropped);
    };
  }, []);
  return over;
}

function useChooser() {
  const input = useRef<HTMLInputElement>(null);
  const field = (
    <input
      ref={input}
      type="file"
      multiple
      hidden
      onChange={(event) => {
        void send(event.currentTarget.files ?? []);
        event.currentTarget.value = '';
      }}
    />
  );
  return { field, open: () => input.current?.click() };
}

export function DropField({ over, big }: { over: boolean; big?: boolean }) {
  const limit = useResource<Workspace>('workspace').value?.max_upload_bytes;
  const chooser = useChooser();
  const most = limit ? `up to ${bytes(limit)} each` : '';
  if (big) {
    return (
      <div class={`drop big ${over ? 'over' : ''}`}>
        <b>Drop records here</b>
        Every format that hysteron reads, several files at once, {most}. They are copied into this folder
        and nowhere else.
        <p class="gap">
          <button type="button" class="primary" onClick={chooser.open}>
            Choose files
          </button>
        </p>
        {chooser.field}
      </div>
    );
  }
  return (
    <div class={`drop ${over ? 'over' : ''}`}>
      <b>Drop records here</b>
      or{' '}
      <button type="button" class="link" onClick={chooser.open}>
        choose files
      </button>
      , {most}
      {chooser.field}
    </div>
  );
}
