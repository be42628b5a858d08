// An operation of the library: its options from the schema, the file it writes, and what it answers.
import { useState } from 'preact/hooks';
import type { ComponentChildren } from 'preact';
import { change, Refusal, type Complaint } from '../api/client';
import { changed, useResource } from '../api/resource';
import type { Choice, Curve, Options, Outcome } from '../api/types';
import { Plot } from '../plot/Plot';
import { settle } from '../route';
import type { Color, Line, Spec } from '../plot/spec';
import { command } from './dock';
import { SchemaForm } from './SchemaForm';
import { TableBox } from './window';
import { Working } from './Working';
import { Failure, Finding, Prose } from './words';

const NAMED: Color[] = ['measured', 'model', 'drive'];
const OTHERS: Color[] = ['model', 'k6', 'k4', 'residual', 'reference'];

interface Saving {
  /** Name of the file that is suggested. */
  name: string;
  /** It is always written; else only where it has a name. */
  always?: boolean;
}

export function Operation(props: {
  /** Name of the operation, as the server offers it. */
  name: string;
  title: string;
  /** What it does, in a sentence or two. */
  about: string;
  at: string;
  /** What is asked beside the options; `null`: something is still to be chosen. */
  request: object | null;
  verb: string;
  save?: Saving;
  /** Model that the room stays with, though a newer one is written. */
  model?: string;
  choices?: Record<string, Choice[]>;
  children?: ComponentChildren;
  /** Unfolded from the beginning. */
  open?: boolean;
}) {
  const offered = useResource<Options>('options').value?.operations.find((one) => one.name === props.name);
  const [asked, ask] = useState<Record<string, unknown>>({});
  const [file, rename] = useState(props.save?.always ? props.save.name : '');
  const [outcome, keep] = useState<Outcome | null>(null);
  const [problem, complain] = useState<Complaint | null>(null);
  const [works, work] = useState(false);
  if (!offered) return null;
  const options = { ...offered.usual, ...asked };
  const lacks = props.request === null || (props.save?.always === true && !file);

  const run = async (): Promise<void> => {
    if (lacks || works) return;
    work(true);
    if (props.model) settle({ m: props.model });
    try {
      const saved = props.save && file ? { save: file } : {};
      const found = await change<Outcome>('POST', props.at, { ...props.request, ...saved, options });
      keep(found);
      complain(null);
      command.value = found.command;
      if (found.files.length > 0) {
        for (const list of ['records', 'models', 'reports']) changed(list);
      }
    } catch (error) {
      keep(null);
      complain(error instanceof Refusal ? error.complaint : { what: String(error) });
    }
    work(false);
  };

  return (
    <details class="operation hr" open={props.open}>
      <summary>{props.title}</summary>
      <div class="stack">
        <p class="soft">{props.about}</p>
        <form
          class="stack"
          onSubmit={(event) => {
            event.preventDefault();
            void run();
          }}
        >
          {props.children}
          <div class="set twos">
            <SchemaForm
              schema={offered.schema}
              root={offered.schema}
              value={options}
              change={ask}
              choices={props.choices}
            />
          </div>
          <div class="row wrap">
            {props.save && (
              <label class="row">
                <span class="soft">File{props.save.always ? '' : ' (not needed)'}</span>
                <input
                  type="text"
                  value={file}
                  placeholder={props.save.name}
                  onInput={(event) => rename(event.currentTarget.value.trim())}
                />
              </label>
            )}
            <button type="submit" class="primary" disabled={lacks || works}>
              {works ? 'Computing…' : props.verb}
            </button>
          </div>
        </form>
        <Working at={props.at} what={props.title} />
        {problem && <Failure problem={problem} />}
        {outcome && <Found outcome={outcome} name={props.name} />}
      </div>
    </details>
  );
}

/** What an operation found: sentences, tables, figures, files. */
function Found({ outcome, name }: { outcome: Outcome; name: string }) {
  return (
    <div class="stack" aria-live="polite">
      {outcome.files.length > 0 && (
        <Finding kind="good">Written into the workspace: {outcome.files.join(', ')}.</Finding>
      )}
      {outcome.sentences.length > 0 && (
        <ul class="plain dots">
          {outcome.sentences.map((sentence) => (
            <li key={sentence}>
              <Prose text={sentence} />
            </li>
          ))}
        </ul>
      )}
      {outcome.figures.map((figure) => (
        <Plot key={figure.title} spec={specOf(figure, name)} />
      ))}
      {outcome.tables.map((table) => (
        <TableBox key={table.title} label={table.title}>
          <table>
            <caption>{table.title}</caption>
            {titled(table) && (
              <thead>
                <tr>
                  {table.columns.map((column, i) => (
                    <Heading key={i} text={column} />
                  ))}
                </tr>
              </thead>
            )}
            <tbody>
              {table.rows.map((row) => (
                <tr key={row.join(' ')}>
                  {row.map((cell, i) => (
                    <td key={i} class={titled(table) && /^[−-]?\d/.test(cell) ? 'n' : undefined}>
                      {cell}
                    </td>
                  ))}
                </tr>
              ))}
            </tbody>
          </table>
        </TableBox>
      ))}
    </div>
  );
}

/** Numbers stand under a heading to the right; in a list of facts beside their names. */
function titled(table: Outcome['tables'][0]): boolean {
  return table.columns.some(Boolean);
}

/** A heading with its unit, `RMSE [µm]`, in two lines. */
function Heading({ text }: { text: string }) {
  const [name, unit] = text.split(/ \[|\]/);
  return (
    <th scope="col">
      {name}
      {unit && <small>{unit}</small>}
    </th>
  );
}

function line({ name, curve }: { name: string; curve: Curve }, color: Color, points: boolean): Line {
  return {
    name,
    color,
    x: curve.x,
    y: curve.y,
    breaks: curve.breaks,
    width: name === 'measured' ? 3 : 1.3,
    points: points && name === 'measured' ? 2 : undefined,
  };
}

/** Colours of series by their names; those of other names have others, in turn. */
function colorsOf(names: string[]): Color[] {
  let turn = 0;
  return names.map(
    (name) => NAMED.find((color) => color === name) ?? OTHERS[turn++ % OTHERS.length] ?? 'model',
  );
}

function specOf(figure: Outcome['figures'][0], name: string): Spec {
  const drawn = figure.series.filter((series) => !series.name.startsWith('band-'));
  const curve = (wanted: string): Curve | undefined =>
    figure.series.find((series) => series.name === wanted)?.curve;
  const [low, high, first] = [curve('band-low'), curve('band-high'), drawn[0]?.curve];
  const label = (axis: Curve['up'] | undefined): string =>
    axis ? (axis.unit ? `${axis.name} (${axis.unit})` : axis.name) : '';
  const colors = colorsOf(drawn.map((series) => series.name));
  const isOne = drawn.every((series) => series.curve.up.name === first?.up.name);
  const up = first && (isOne ? first.up : { ...first.up, name: figure.title });
  const across = first?.across.name === 't' ? 'time (s)' : label(first?.across);
  return {
    key: `${name}-${figure.title}`,
    title: figure.title,
    description: `${figure.title}: ${drawn.map((series) => series.name).join(', ')}.`,
    height: 220,
    flat: !figure.log_across,
    x: { label: across, unit: first?.across.unit ?? '', log: figure.log_across },
    y: { label: label(up), unit: first?.up.unit ?? '', log: figure.log_up },
    lines: drawn.map((series, i) => line(series, colors[i] ?? 'model', figure.log_across)),
    band: low && high && { name: '95 % band', x: low.x, low: low.y, high: high.y },
    tools: ['zoom', 'pan'],
  };
}
