// Settings of a fit: records as chips, four choices, and a drawer with every option of the library.
import { useMemo, useState } from 'preact/hooks';
import { path } from '../../api/client';
import { useResource } from '../../api/resource';
import type { Choice, ModelEntry, Options, RecordDetail, RecordEntry } from '../../api/types';
import { Icon } from '../../components/icon';
import { SchemaForm } from '../../components/SchemaForm';
import { words } from '../../components/schema';
import { capital } from '../../components/words';
import { fileName } from '../../format';
import { route, settle } from '../../route';
import { useSignal } from '../../signal';
import { ask, asked, columns, OF_AXES, optionsOf, usual, type Task } from './task';

const FIRST = ['hysteresis', 'dynamics', 'delay_s', 'degree'];
/** A whole model file as the start of the search: from a program, not from a form. */
const UNOFFERED = ['start'];
const LABELS = { delay_s: 'Delay (s)', degree: 'Degree of the polynomial' };

export function Settings(props: {
  records: RecordEntry[];
  out: RecordEntry[];
  models: ModelEntry[];
  running: boolean;
}) {
  const offered = useResource<Options>('options').value;
  useSignal(route);
  return (
    <form class="set" aria-label="Settings" onSubmit={(event) => event.preventDefault()}>
      <fieldset disabled={props.running} class="set">
        <Chips records={props.records} out={props.out} />
        {offered && <Choices offered={offered} {...props} />}
      </fieldset>
    </form>
  );
}

function Chips({ records, out }: { records: RecordEntry[]; out: RecordEntry[] }) {
  const leave = (list: RecordEntry[]): void =>
    settle({ out: list.map((record) => record.id).join(',') || null });
  return (
    <div class="f">
      <span>Records</span>
      <ul class="chips">
        {records.map((record) => (
          <li key={record.id} class="tag">
            {fileName(record.id)}
            <button
              type="button"
              class="off"
              aria-label={`Take ${fileName(record.id)} out`}
              title="Take out of this fit"
              onClick={() => leave([...out, record])}
            >
              <Icon name="close" />
            </button>
          </li>
        ))}
      </ul>
      {out.length > 0 && (
        <small>
          Left out: {out.map((record) => fileName(record.id)).join(', ')}.{' '}
          <button type="button" class="link" onClick={() => leave([])}>
            Take them in again
          </button>
        </small>
      )}
    </div>
  );
}

/** A model of the same kind whose numbers the search tries first. */
function Start({ models }: { models: ModelEntry[] }) {
  const { query } = useSignal(route);
  if (models.length === 0) return null;
  return (
    <label class="f">
      <span>Start of the search</span>
      <select
        value={query.get('start') ?? ''}
        onChange={(event) => settle({ start: event.currentTarget.value || null })}
      >
        <option value="">from the records</option>
        {models.map((model) => (
          <option key={model.id} value={model.id}>
            {model.name}
          </option>
        ))}
      </select>
    </label>
  );
}

/** Which columns are inputs and outputs of a model of several axes. */
export function Axes({ record }: { record: RecordEntry }) {
  useSignal(route);
  const detail = useResource<RecordDetail>(path('records', record.id)).value;
  const names = detail?.columns.filter((column) => column.kind === 'numbers' && column.used_as !== 'time');
  if (!names) return null;
  const choose = (of: 'inputs' | 'outputs', name: string): void => {
    const before = columns(of);
    const after = before.includes(name) ? before.filter((one) => one !== name) : [...before, name];
    settle({ [of]: after.join(',') || null });
  };
  return (
    <>
      {(['inputs', 'outputs'] as const).map((of) => (
        <fieldset class="f" key={of}>
          <legend>{capital(of)}</legend>
          <div class="row wrap">
            {names.map(({ path: name }) => (
              <label class="row" key={name}>
                <input
                  type="checkbox"
                  checked={columns(of).includes(name)}
                  onChange={() => choose(of, name)}
                />
                {name}
              </label>
            ))}
          </div>
        </fieldset>
      ))}
    </>
  );
}

function Choices(props: { offered: Options; records: RecordEntry[]; models: ModelEntry[] }) {
  const { offered, records, models } = props;
  const { query } = useSignal(route);
  const [wanted, search] = useState('');
  const task = asked(offered, records);
  const schema = useMemo(() => optionsOf(offered.task, task.kind), [offered, task.kind]);
  const choices = useMemo(
    () =>
      Object.fromEntries(offered.choices.map((entry) => [entry.option, entry.choices])) as Record<
        string,
        Choice[]
      >,
    [offered],
  );
  const kinds = offered.defaults as unknown as Task[];
  const first = schema ? FIRST.filter((name) => name in (schema.properties ?? {})) : [];
  const change = (options: Record<string, unknown>): void =>
    ask(offered, records, { kind: task.kind, options });
  return (
    <>
      <label class="f">
        <span>Structure</span>
        <select
          value={task.kind}
          onChange={(event) => ask(offered, records, usual(offered, event.currentTarget.value))}
        >
          {kinds.map((other) => (
            <option key={other.kind} value={other.kind}>
              {capital(words(other.kind))}
            </option>
          ))}
        </select>
      </label>
      {OF_AXES.includes(task.kind) && records[0] && <Axes record={records[0]} />}
      {schema && (
        <>
          <SchemaForm
            schema={schema}
            root={offered.task}
            value={task.options}
            change={change}
            only={first}
            labels={LABELS}
            choices={choices}
            usual={usual(offered, task.kind).options}
          />
          {task.kind === kinds[0]?.kind && (
            <Start models={models.filter((model) => model.kind === task.kind && !model.error)} />
          )}
          <label class="f check">
            <input
              type="checkbox"
              checked={query.get('report') !== null}
              onChange={(event) => settle({ report: event.currentTarget.checked ? '1' : null })}
            />
            <span>Write the report too</span>
          </label>
          <details>
            <summary>All options</summary>
            <div class="set">
              <input
                type="text"
                placeholder="Find an option"
                aria-label="Find an option"
                value={wanted}
                onInput={(event) => search(event.currentTarget.value)}
              />
              <SchemaForm
                schema={schema}
                root={offered.task}
                value={task.options}
                change={change}
                wanted={wanted}
                without={[...first, ...UNOFFERED]}
                choices={choices}
                usual={usual(offered, task.kind).options}
              />
            </div>
          </details>
        </>
      )}
    </>
  );
}
