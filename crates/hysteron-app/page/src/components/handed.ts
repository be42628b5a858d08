// A file that the server wrote into the workspace, handed to the browser.
import { href, path } from '../api/client';
import { changed } from '../api/resource';
import { fileName } from '../format';

export function handed(file: string | null): void {
  changed('records');
  if (!file) return;
  const link = document.createElement('a');
  link.href = href(`${path('records', file)}/file`);
  link.download = fileName(file);
  link.click();
}
