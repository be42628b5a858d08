// The device whose records a room takes: a subfolder of the workspace, or the workspace itself.
import type { RecordEntry } from '../api/types';
import { go } from '../route';
import { isFit } from '../rooms/records/roles';

/** Nothing where all records are of one device. */
export function DeviceChoice({ records, device }: { records: RecordEntry[]; device?: string }) {
  const devices = [...new Set(records.filter(isFit).map((record) => record.device))].sort();
  if (devices.length < 2) return null;
  return (
    <select
      aria-label="Device"
      value={device || '.'}
      onChange={(event) =>
        go({
          device: event.currentTarget.value,
          r: null,
          m: null,
          job: null,
          out: null,
          pick: null,
          new: '1',
        })
      }
    >
      {devices.map((name) => (
        <option key={name} value={name || '.'}>
          {name || 'no device (the folder itself)'}
        </option>
      ))}
    </select>
  );
}
