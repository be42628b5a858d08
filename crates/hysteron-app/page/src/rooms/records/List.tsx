// The list of records: device by device, parts of a run beneath what they continue.
import { useState } from 'preact/hooks';
import { Icon } from '../../components/icon';
import { Origin, Tag } from '../../components/words';
import type { RecordEntry, Role } from '../../api/types';
import { fileName, hertz, seconds } from '../../format';
import { address, go } from '../../route';
import { Signal, useSignal } from '../../signal';
import { roleName, ROLES, settings } from './roles';
import { uploads } from './uploads';

export function Glyph({ points, large }: { points: [number, number][]; large?: boolean }) {
  const path = points.map(([u, y]) => `${(1 + u * 30).toFixed(1)} ${(19 - y * 18).toFixed(1)}`).join('L');
  return (
    <svg class={large ? 'g large' : 'g'} viewBox="0 0 32 20" aria-hidden="true">
      <path d={points.length ? `M${path}` : ''} />
    </svg>
  );
}

/** The record that is being dragged. */
const dragged = new Signal<string | null>(null);

export function RecordList({ records, chosen }: { records: RecordEntry[]; chosen: string | null }) {
  const sending = useSignal(uploads);
  const devices = [...new Set(records.map((record) => record.device))];
  const bad = sending.filter((upload) => upload.problem);
  const under = sending.filter((upload) => !upload.problem);
  return (
    <div class="rl" role="group" aria-label="Records in the workspace">
      <RoleTargets />
      {bad.length > 0 && <h2 class="h3">Not read</h2>}
      {bad.map((upload) => (
        <button
          type="button"
          key={upload.name}
          class="chip err"
          data-step
          aria-pressed={chosen === `!${upload.name}`}
          onClick={() => go({ r: `!${upload.name}` })}
        >
          <Icon name="bad" />
          <span class="nm">{upload.name}</span>
          <span class="mt">{upload.problem?.what ?? 'not taken in'}</span>
        </button>
      ))}
      {devices.map((device) => (
        <Device
          key={device}
          name={device}
          records={records.filter((r) => r.device === device)}
          chosen={chosen}
        />
      ))}
      {under.length > 0 && <h2 class="h3">Reading</h2>}
      {under.map((upload) => (
        <div key={upload.name} class="chip now">
          <span class="sk" />
          <span class="nm">{upload.name}</span>
          <span class="mt">
            <progress class="bar" max={1} value={upload.share} aria-label={`${upload.name}: share sent`} />
          </span>
        </div>
      ))}
    </div>
  );
}

/** Where a record that is dragged can be dropped; the select in its head does the same. */
function RoleTargets() {
  const moved = useSignal(dragged);
  const [over, set] = useState<Role | null>(null);
  if (!moved) return null;
  return (
    <div class="targets" aria-hidden="true">
      {ROLES.map(([role, name]) => (
        <span
          key={role}
          class={`tag role ${over === role ? 'over' : ''}`}
          onDragOver={(event) => {
            event.preventDefault();
            set(role);
          }}
          onDragLeave={() => set(null)}
          onDrop={() => {
            dragged.value = null;
            void settings(moved, { role });
          }}
        >
          {name}
        </span>
      ))}
    </div>
  );
}

function Device({
  name,
  records,
  chosen,
}: {
  name: string;
  records: RecordEntry[];
  chosen: string | null;
}) {
  const simulated = records.every((record) => record.simulated);
  return (
    <>
      <h2 class="h3">
        {name || 'Workspace'} <Origin simulated={simulated} />
      </h2>
      {inRuns(records).map(({ record, part }) => (
        <Chip key={record.id} record={record} part={part} chosen={chosen} records={records} />
      ))}
    </>
  );
}

/** Each record, behind it those that continue it. */
function inRuns(records: RecordEntry[]): { record: RecordEntry; part: boolean }[] {
  const known = new Set(records.map((record) => record.id));
  const list: { record: RecordEntry; part: boolean }[] = [];
  const add = (record: RecordEntry, part: boolean): void => {
    if (list.some((other) => other.record === record)) return;
    list.push({ record, part });
    for (const next of records) if (next.settings.continues === record.id) add(next, true);
  };
  for (const record of records) if (!known.has(record.settings.continues ?? '')) add(record, false);
  for (const record of records) add(record, true);
  return list;
}

const DRAGGED = 'application/x-hysteron-record';

function Chip(props: {
  record: RecordEntry;
  part: boolean;
  chosen: string | null;
  records: RecordEntry[];
}) {
  const { record, part } = props;
  const [over, set] = useState(false);
  const facts = record.reading ? (
    <span>reading</span>
  ) : record.error && record.settings.role === 'reference' ? (
    <Tag kind="role">{roleName('reference')}</Tag>
  ) : record.error ? (
    <span title={record.error.what}>{record.error.what}</span>
  ) : (
    <>
      {record.rate_hz ? <span>{hertz(record.rate_hz)}</span> : null}
      {record.segments > 1 ? <Tag kind="warn">{record.segments} stretches</Tag> : null}
      {record.duration_s != null ? <span>{seconds(record.duration_s)}</span> : null}
      <Tag kind="role">{part ? 'continues' : roleName(record.settings.role)}</Tag>
    </>
  );
  return (
    <button
      type="button"
      class={`chip ${part ? 'cont' : ''} ${record.error ? 'err' : ''} ${over ? 'over' : ''}`}
      data-step
      aria-pressed={record.id === props.chosen}
      title={record.id}
      draggable
      onClick={() => go({ r: record.id })}
      onDragStart={(event) => {
        event.dataTransfer?.setData(DRAGGED, record.id);
        // The list may change only when the drag has begun.
        setTimeout(() => (dragged.value = record.id));
      }}
      onDragEnd={() => (dragged.value = null)}
      onDragOver={(event) => {
        if (!event.dataTransfer?.types.includes(DRAGGED)) return;
        event.preventDefault();
        set(true);
      }}
      onDragLeave={() => set(false)}
      onDrop={(event) => {
        set(false);
        const moved = event.dataTransfer?.getData(DRAGGED);
        if (moved && moved !== record.id) void settings(moved, { continues: record.id });
      }}
    >
      {record.reading ? (
        <span class="sk" />
      ) : record.error ? (
        <Icon name="bad" />
      ) : (
        <Glyph points={record.glyph} />
      )}
      <span class="nm">
        {part ? '↳ ' : ''}
        {fileName(record.id)}
      </span>
      <span class="mt">{facts}</span>
    </button>
  );
}

export function recordAddress(id: string): string {
  return address({ r: id }, 'records');
}
