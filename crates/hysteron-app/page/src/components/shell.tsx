// Top bar and rail.
import { useEffect, useState } from 'preact/hooks';
import { keysOn } from '../keys';
import { RAIL } from '../rail';
import { useResource } from '../api/resource';
import type { ModelEntry, RecordEntry, Workspace } from '../api/types';
import { count } from '../format';
import { address, route, settle, type Room } from '../route';
import { useSignal } from '../signal';
import { connected, jobs } from '../store';
import { copy } from './dock';
import { Icon } from './icon';
import { useModel } from './models';

export function Top() {
  const workspace = useResource<Workspace>('workspace').value;
  const up = useSignal(connected);
  return (
    <header class="top">
      <a class="brand" href={address({}, 'records')}>
        <svg viewBox="0 0 32 20" aria-hidden="true">
          <path d="M2 18C6 8 18 3 30 2C27 9 17 16 2 18Z" />
        </svg>
        hysteron
      </a>
      <span class="ws">
        <b class="mono" title={workspace?.folder}>
          {workspace?.folder}
        </b>
        <span class="s nw">{isLocal() ? 'on this machine only' : 'on the network'}</span>
      </span>
      <span class="sp" />
      {up === false && (
        <span class="tag bad" role="status">
          no connection, trying again
        </span>
      )}
      <button
        type="button"
        class="quiet"
        title="Copy a link to exactly this view"
        onClick={() => copy(location.href)}
      >
        <Icon name="link" />
        <span class="wide">Copy link</span>
      </button>
      <Theme />
      <Keys />
    </header>
  );
}

function isLocal(): boolean {
  return ['127.0.0.1', 'localhost', '[::1]'].includes(location.hostname);
}

function Theme() {
  const { query } = useSignal(route);
  const system = matchMedia('(prefers-color-scheme: dark)').matches ? 'dark' : 'light';
  const now = query.get('theme') ?? system;
  const other = now === 'dark' ? 'light' : 'dark';
  return (
    <button
      type="button"
      class="quiet"
      title="Light or dark"
      aria-label={`Show the ${other} theme`}
      onClick={() => settle({ theme: other })}
    >
      <Icon name="theme" />
    </button>
  );
}

const KEYS: [string, string][] = [
  ['1 – 7', 'rooms'],
  ['j k', 'next, previous record'],
  ['c', 'copy the command'],
  ['s', 'stop the job'],
  ['← →', 'reading of a figure'],
  ['+ − 0', 'zoom, show all'],
];

function Keys() {
  const [open, show] = useState(false);
  const on = useSignal(keysOn);
  useEffect(() => {
    const escape = (event: KeyboardEvent): void => {
      if (event.key === 'Escape') show(false);
    };
    addEventListener('keydown', escape);
    return () => removeEventListener('keydown', escape);
  }, []);
  return (
    <span class="keys">
      <button
        type="button"
        class="quiet"
        aria-expanded={open}
        aria-label="Keys"
        onClick={() => show(!open)}
      >
        ?
      </button>
      {open && (
        <div class="sheet">
          <dl>
            {KEYS.map(([key, meaning]) => (
              <div key={key}>
                <dt>
                  <kbd>{key}</kbd>
                </dt>
                <dd>{meaning}</dd>
              </div>
            ))}
          </dl>
          <label class="row">
            <input
              type="checkbox"
              checked={on}
              onChange={(event) => (keysOn.value = event.currentTarget.checked)}
            />
            single keys are on
          </label>
        </div>
      )}
    </span>
  );
}

export function Rail() {
  const { room } = useSignal(route);
  const list = useSignal(jobs);
  const records = useResource<RecordEntry[]>('records').value;
  const models = useResource<ModelEntry[]>('models').value;
  const runs = (kind: string): boolean =>
    list.some((job) => job.state === 'running' && job.request.kind === kind);
  const { model } = useModel();
  const isHeld = (record: RecordEntry): boolean =>
    record.settings.role === 'validate' && (!model || record.device === model.device);
  const held = records?.filter(isHeld).length ?? 0;
  const broken = records?.filter((record) => record.error || record.warning).length ?? 0;
  const state: Partial<Record<Room, string>> = {
    records:
      records &&
      (records.length === 0
        ? 'empty'
        : records.length +
          (records.length === 1 ? ' file' : ' files') +
          (broken ? ` · ${count(broken, 'warning')}` : '')),
    identify: runs('identify')
      ? 'fit runs'
      : models && (models.length === 0 ? 'no model' : count(models.length, 'model')),
    compare: runs('compare') ? 'race runs' : 'which structure',
    validate: held ? count(held, 'held-out record') : 'no record held out',
    follow: 'drive for a path',
    home: 'code and report',
    try: 'no device needed',
  };
  return (
    <nav class="rail" aria-label="Rooms">
      {RAIL.map(([name, title], i) => (
        <>
          {name === 'try' && <hr />}
          <a key={name} href={address({}, name)} aria-current={room === name ? 'page' : undefined}>
            <i>{i + 1}</i>
            <span>{title}</span>
            <small>{state[name] ?? ''}</small>
          </a>
        </>
      ))}
    </nav>
  );
}
