// Files on their way into the workspace.
import { change, path, query, Refusal, upload, type Complaint } from '../../api/client';
import { changed } from '../../api/resource';
import type { RecordEntry } from '../../api/types';
import { go } from '../../route';
import { said } from '../../components/dock';
import { Signal } from '../../signal';

export interface Upload {
  name: string;
  share: number;
  file: File;
  status?: number;
  problem?: Complaint;
}

export const uploads = new Signal<Upload[]>([]);

/** Sends files one after the other; the first one that arrives is shown, else the last that was refused. */
export async function send(files: Iterable<File>): Promise<void> {
  const list = [...files];
  for (const file of list) put({ name: nameOf(file), share: 0, file });
  let shown = false;
  for (const file of list) {
    const entry = await sendOne(file, false);
    if (entry && !shown) {
      go({ r: entry.id }, 'records');
      shown = true;
    }
  }
  const bad = uploads.value.filter((upload) => upload.problem && list.includes(upload.file));
  if (bad.length > 0) said.value = `${bad.length} of ${list.length} files were not taken`;
  const refused = uploads.value.findLast((upload) => upload.problem && list.includes(upload.file));
  if (!shown && refused) go({ r: `!${refused.name}` }, 'records');
}

export async function sendOne(file: File, replace: boolean): Promise<RecordEntry | null> {
  const name = nameOf(file);
  put({ name, share: 0, file });
  try {
    const address = 'records' + query({ name, replace: replace ? 1 : undefined });
    const entry = await upload<RecordEntry>(address, file, (share) => put({ name, share, file }));
    drop(name);
    changed('records');
    changed(path('records', entry.id));
    return entry;
  } catch (error) {
    const [status, problem] =
      error instanceof Refusal ? [error.status, error.complaint] : [0, { what: String(error) }];
    put({ name, share: 1, file, status, problem });
    return null;
  }
}

export function drop(name: string): void {
  uploads.value = uploads.value.filter((upload) => upload.name !== name);
}

function put(upload: Upload): void {
  const others = uploads.value.filter((other) => other.name !== upload.name);
  uploads.value = [...others, upload];
}

/** Name with the folders of a dropped folder, each a device. */
function nameOf(file: File): string {
  return file.webkitRelativePath || file.name;
}

/** Sends a reference; its identifier, or null where it was refused: then Records says why. */
export async function uploadReference(file: File): Promise<string | null> {
  const entry = await sendOne(file, false);
  if (!entry) {
    go({ r: `!${nameOf(file)}` }, 'records');
    return null;
  }
  await change('PATCH', path('records', entry.id), { role: 'reference' });
  changed('records');
  return entry.id;
}
