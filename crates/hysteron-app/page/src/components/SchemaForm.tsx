// A form made from a JSON schema.
import { useState } from 'preact/hooks';
import type { Choice, Schema } from '../api/types';
import { kindOf, optional, plain, start, words, type Option } from './schema';
import { capital } from './words';

interface FieldProps {
  label: string;
  schema: Schema;
  root: Schema;
  value: unknown;
  choices?: Choice[];
  usual?: unknown;
  change: (value: unknown) => void;
}

/** Fields of an object; `wanted` narrows to names that contain it, `without` leaves some out. */
export function SchemaForm(props: {
  schema: Schema;
  root: Schema;
  value: Record<string, unknown>;
  change: (value: Record<string, unknown>) => void;
  wanted?: string;
  without?: string[];
  /** These alone, in this order. */
  only?: string[];
  /** Choices of the library by the name of their field, where it says more of them than the schema. */
  choices?: Record<string, Choice[]>;
  /** Usual values: what is no choice by its name can be gone back to. */
  usual?: Record<string, unknown>;
  /** Fields without their explanation, which is of another use. */
  quiet?: string[];
  /** Labels other than the words of the names. */
  labels?: Record<string, string>;
}) {
  const kind = kindOf(props.schema, props.root);
  if (kind.kind !== 'group') return null;
  const text = props.wanted?.toLowerCase() ?? '';
  const listed = props.only?.map((name) => kind.fields.find((field) => field[0] === name));
  const all = listed?.filter((field) => field !== undefined) ?? kind.fields;
  const fields = all.filter(([name, field]) => {
    if (props.without?.includes(name)) return false;
    return !text || `${words(name)} ${plain(field.description)}`.toLowerCase().includes(text);
  });
  if (fields.length === 0) return <p class="soft s">No option is called so.</p>;
  return (
    <>
      {fields.map(([name, field]) => (
        <Field
          key={name}
          schema={props.quiet?.includes(name) ? { ...field, description: ' ' } : field}
          root={props.root}
          value={props.value[name] ?? field.default}
          choices={props.choices?.[name]}
          usual={props.usual?.[name]}
          label={props.labels?.[name] ?? capital(words(name))}
          change={(value) => props.change({ ...props.value, [name]: value })}
        />
      ))}
    </>
  );
}

function Field({ label, schema, root, value, choices, usual, change }: FieldProps) {
  const { schema: own, nullable } = optional(schema, root);
  const kind = choices
    ? ({ kind: 'choice', options: offered(choices, usual) } as const)
    : kindOf(own, root);
  const help = plain(schema.description ?? own.description);
  switch (kind.kind) {
    case 'switch':
      return (
        <label class="f check">
          <input
            type="checkbox"
            checked={value === true}
            onChange={(e) => change(e.currentTarget.checked)}
          />
          <span>{label}</span>
          <small>{help}</small>
        </label>
      );
    case 'number':
      return (
        <label class="f">
          <span>{label}</span>
          <NumberInput
            value={value}
            nullable={nullable}
            whole={kind.whole}
            schema={kind.schema}
            change={change}
          />
          <small>{help}</small>
        </label>
      );
    case 'numbers':
      return (
        <label class="f">
          <span>{label}</span>
          <Typed
            text={Array.isArray(value) ? value.join(', ') : ''}
            read={(text) => {
              const list = text
                .split(/[,\s]+/)
                .filter(Boolean)
                .map(Number);
              return list.every(Number.isFinite) ? list : undefined;
            }}
            change={change}
          />
          <small>{help}</small>
        </label>
      );
    case 'several': {
      const chosen: unknown[] = Array.isArray(value) ? value : [];
      const toggle = (option: Option): void => {
        const others = chosen.filter((one) => !option.matches(one));
        change(others.length < chosen.length ? others : [...chosen, option.value]);
      };
      return (
        <fieldset class="f whole">
          <legend>{label}</legend>
          <small>{help}</small>
          <div class="row wrap">
            {kind.options.map((option) => (
              <label class="row" key={option.label} title={plain(option.summary)}>
                <input
                  type="checkbox"
                  checked={chosen.some(option.matches)}
                  onChange={() => toggle(option)}
                />
                {option.label}
              </label>
            ))}
          </div>
        </fieldset>
      );
    }
    case 'ranges':
      return (
        <label class="f">
          <span>{label}</span>
          <Typed
            text={Array.isArray(value) ? value.map((pair: number[]) => pair.join(':')).join(', ') : ''}
            read={rangesOf}
            change={change}
          />
          <small>{help} Written as LOW:HIGH, several separated by commas.</small>
        </label>
      );
    case 'texts':
      return (
        <label class="f">
          <span>{label}</span>
          <Typed
            text={Array.isArray(value) ? value.join(', ') : ''}
            read={(text) =>
              text
                .split(',')
                .map((one) => one.trim())
                .filter(Boolean)
            }
            change={change}
          />
          <small>{help} Several are separated by commas.</small>
        </label>
      );
    case 'text':
      return (
        <label class="f">
          <span>{label}</span>
          <input
            type="text"
            value={typeof value === 'string' ? value : ''}
            onInput={(e) => change(e.currentTarget.value || (nullable ? null : ''))}
          />
          <small>{help}</small>
        </label>
      );
    case 'choice':
      return (
        <ChoiceField
          label={label}
          help={help}
          options={kind.options}
          nullable={nullable}
          root={root}
          value={value}
          change={change}
        />
      );
    case 'group':
      return (
        <details class="f group">
          <summary>{label}</summary>
          <small>{help}</small>
          <div class="set">
            <SchemaForm
              schema={own}
              root={root}
              value={(value as Record<string, unknown> | null) ?? {}}
              change={change}
            />
          </div>
        </details>
      );
    case 'json':
      return (
        <label class="f">
          <span>{label}</span>
          <Typed
            text={value == null ? '' : JSON.stringify(value)}
            read={(text) => parsed(text, nullable)}
            change={change}
          />
          <small>{help} Written as JSON.</small>
        </label>
      );
  }
}

/** `LOW:HIGH, LOW:HIGH`; undefined where it is none. */
function rangesOf(text: string): number[][] | undefined {
  const pairs = text
    .split(',')
    .map((one) => one.trim())
    .filter(Boolean)
    .map((one) => one.split(':').map(Number));
  const good = pairs.every((pair) => pair.length === 2 && pair.every(Number.isFinite));
  return good ? pairs : undefined;
}

function offered(choices: Choice[], usual: unknown): Option[] {
  const list = choices.map(({ name, summary, value }) => option(name, value, summary));
  if (usual === undefined || list.some((one) => one.matches(usual))) return list;
  return [option(typeof usual === 'string' ? usual : 'as usual', usual), ...list];
}

function option(label: string, value: unknown, summary?: string): Option {
  return { label, summary, value, matches: (other) => JSON.stringify(other) === JSON.stringify(value) };
}

function ChoiceField(props: {
  label: string;
  help: string;
  options: Option[];
  nullable: boolean;
  root: Schema;
  value: unknown;
  change: (value: unknown) => void;
}) {
  const { options, value, change, root } = props;
  const at = options.findIndex((option) => option.matches(value));
  const chosen = options[at];
  const inner = chosen?.inner && kindOf(chosen.inner, root);
  return (
    <div class="f">
      <label class="f">
        <span>{props.label}</span>
        <select
          value={String(at)}
          onChange={(e) => {
            const option = options[Number(e.currentTarget.value)];
            change(option ? option.value : null);
          }}
        >
          {(props.nullable || at < 0) && <option value="-1">as usual</option>}
          {options.map((option, i) => (
            <option key={option.label} value={String(i)}>
              {option.label}
            </option>
          ))}
        </select>
      </label>
      <small>{plain(chosen?.summary) || props.help}</small>
      {chosen?.inner && inner?.kind === 'number' && (
        <NumberInput
          value={value}
          whole={inner.whole}
          schema={inner.schema}
          change={change}
          label={props.label}
        />
      )}
      {chosen?.inner && inner?.kind === 'group' && inner.fields.length > 0 && (
        <div class="set inner">
          <SchemaForm
            schema={chosen.inner}
            root={root}
            value={value as Record<string, unknown>}
            change={change}
          />
        </div>
      )}
    </div>
  );
}

function NumberInput(props: {
  value: unknown;
  nullable?: boolean;
  whole: boolean;
  schema: Schema;
  change: (value: unknown) => void;
  label?: string;
}) {
  const wrong = outOfRange(props.value, props.whole, props.schema);
  return (
    <>
      <input
        type="number"
        aria-label={props.label}
        aria-invalid={wrong !== null}
        step={props.whole ? 1 : 'any'}
        min={props.schema.minimum}
        max={props.schema.maximum}
        placeholder={props.nullable ? 'as usual' : undefined}
        value={typeof props.value === 'number' ? props.value : ''}
        onChange={(e) => {
          const text = e.currentTarget.value;
          if (text !== '') props.change(Number(text));
          else props.change(props.nullable ? null : start(props.schema, props.schema));
        }}
      />
      {wrong && <small class="wrong">{wrong}</small>}
    </>
  );
}

/** Why a number cannot be taken; `null` where it can. */
function outOfRange(value: unknown, whole: boolean, schema: Schema): string | null {
  if (typeof value !== 'number') return null;
  if (whole && !Number.isSafeInteger(value)) return 'a whole number is expected';
  if (schema.minimum !== undefined && value < schema.minimum)
    return `at least ${schema.minimum} is expected`;
  if (schema.maximum !== undefined && value > schema.maximum)
    return `at most ${schema.maximum} is expected`;
  return null;
}

/** Text that is taken over only where it can be read. */
function Typed(props: { text: string; read: (text: string) => unknown; change: (value: unknown) => void }) {
  const [wrong, mark] = useState(false);
  return (
    <input
      type="text"
      value={props.text}
      aria-invalid={wrong}
      onChange={(e) => {
        const value = props.read(e.currentTarget.value);
        mark(value === undefined);
        if (value !== undefined) props.change(value);
      }}
    />
  );
}

function parsed(text: string, nullable: boolean): unknown {
  if (text.trim() === '') return nullable ? null : undefined;
  try {
    return JSON.parse(text);
  } catch {
    return undefined;
  }
}
