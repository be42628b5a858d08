// Head of a record: what it is, its role, its columns; deleting with undo.
import { change, path } from '../../api/client';
import { changed, deletedAt } from '../../api/resource';
import type { RecordDetail, RecordEntry, RecordSettings, Role } from '../../api/types';
import { Icon } from '../../components/icon';
import { Origin } from '../../components/words';
import { fileName, hertz, integer, seconds } from '../../format';
import { deleted } from '../../components/undo';
import { go } from '../../route';
import { ROLES, sameDevice, settings } from './roles';

type Use = 'input' | 'output' | 'time' | 'rate';
const USES: Use[] = ['time', 'input', 'output'];
/** Columns that a record has before one can be the rate of the drive. */
const WITHOUT_RATE = 3;

export function RecordHead({ record, records }: { record: RecordDetail; records: RecordEntry[] }) {
  const others = sameDevice(records, record).filter((other) => other.id !== record.id);
  const rate = record.rate_hz ? ` at ${hertz(record.rate_hz)}` : '';
  const duration = record.duration_s != null ? `, ${seconds(record.duration_s)}` : '';
  return (
    <div class="rhead">
      <h2 class="mono">{fileName(record.id)}</h2>
      <Origin simulated={record.simulated} />
      <span class="soft s nw">
        {integer(record.samples)} samples{rate}
        {duration}
      </span>
      <button
        type="button"
        class="quiet"
        title="Delete: to the trash folder, can be undone"
        onClick={() => void remove(record)}
      >
        <Icon name="trash" />
        <span class="vh">Delete {fileName(record.id)}</span>
      </button>
      <span class="sp" />
      <span class="cmap" role="group" aria-label="Role and columns">
        <label>
          <span class="soft">role</span>
          <select
            value={record.settings.role}
            onChange={(event) => void settings(record.id, { role: event.currentTarget.value as Role })}
          >
            {ROLES.map(([role, name]) => (
              <option key={role} value={role}>
                {name}
              </option>
            ))}
          </select>
        </label>
        {others.length > 0 && (
          <label>
            <span class="soft">continues</span>
            <select
              value={record.settings.continues ?? ''}
              onChange={(event) =>
                void settings(record.id, { continues: event.currentTarget.value || null })
              }
            >
              <option value="">nothing</option>
              {others.map((other) => (
                <option key={other.id} value={other.id}>
                  {fileName(other.id)}
                </option>
              ))}
            </select>
          </label>
        )}
        <Columns record={record} />
      </span>
    </div>
  );
}

/** Which column is what: a choice for each use, so that a file of many channels stays small. */
function Columns({ record }: { record: RecordDetail }) {
  const numbers = record.columns.filter((column) => column.kind === 'numbers');
  // The rate of the drive, measured beside it, is for the force of a damper.
  const uses: Use[] = numbers.length > WITHOUT_RATE ? [...USES, 'rate'] : USES;
  const used = (use: Use): string => record.columns.find((column) => column.used_as === use)?.path ?? '';
  return (
    <>
      {uses.map((use) => (
        <label key={use}>
          <span class="soft">{use}</span>
          <select
            value={record.settings[use] ?? used(use)}
            onChange={(event) =>
              void settings(record.id, {
                [use]: event.currentTarget.value || null,
              } as Partial<RecordSettings>)
            }
          >
            {(use === 'time' || use === 'rate') && <option value="">none</option>}
            {numbers.map((column) => (
              <option key={column.path} value={column.path}>
                {column.path}
              </option>
            ))}
          </select>
        </label>
      ))}
    </>
  );
}

async function remove(record: RecordEntry): Promise<void> {
  deletedAt(path('records', record.id));
  const { token } = await change<{ token: string }>('DELETE', path('records', record.id));
  deleted({ token, id: record.id });
  go({ r: null });
  changed('records');
}
