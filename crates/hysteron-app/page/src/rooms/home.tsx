// Room 6: how does the model run on a controller, and how can anyone repeat it?
import { useEffect, useState } from 'preact/hooks';
import { href, path, query } from '../api/client';
import { changed, useLatest, useResource } from '../api/resource';
import type { History, ModelDetail, ModelEntry, Options, Preview, ReportEntry } from '../api/types';
import { command, copy, Language } from '../components/dock';
import { Icon } from '../components/icon';
import { ModelChoice, NoModel, useModel } from '../components/models';
import { Operation } from '../components/Operation';
import { Failure, Head, LibraryFinding, Origin, Waiting } from '../components/words';
import { TableBox } from '../components/window';
import { Working } from '../components/Working';
import { bytes, count, fileName, integer, prose, significant } from '../format';
import { route, settle } from '../route';
import { useSignal } from '../signal';

const TITLE = 'Take it home';
const SEVERAL_AXES = 'modes';
const QUESTION = 'How does this run on my controller, and how can anyone repeat it?';

/** Name, what it is, its files; those of source code come from the server. */
type Form = [name: string, label: string, what: string];
const OTHERS: Form[] = [
  ['json', 'Model file', 'JSON with errors, covariance, valid range, provenance'],
  ['report', 'Report', 'one HTML page, figures as SVG'],
];

export function Home() {
  const { models, model } = useModel();
  if (!models) {
    return (
      <>
        <Head title={TITLE} question={QUESTION} />
        <Waiting height={300} />
      </>
    );
  }
  if (!model) {
    return (
      <>
        <Head title={TITLE} question={QUESTION} />
        <NoModel />
      </>
    );
  }
  return <Forms models={models} model={model} />;
}

function Forms({ models, model }: { models: ModelEntry[]; model: ModelEntry }) {
  const { query: asked } = useSignal(route);
  const sources = useResource<Options>('options').value?.forms ?? [];
  const source = sources.find((one) => one.name === (asked.get('form') ?? 'c'));
  const forms: Form[] = [...sources.map((one): Form => [one.name, one.summary, one.contents]), ...OTHERS];
  const form = forms.find(([name]) => name === asked.get('form'))?.[0] ?? 'c';
  const code = !OTHERS.some(([name]) => name === form);
  const at = path('models', model.id);
  const detail = useLatest<ModelDetail>(at).value;
  const inverse = code && asked.get('plain') === null;
  const given = (of: boolean, key: string): string | undefined => (of && asked.get(key)) || undefined;
  const [low, high] = detail?.drive_range ?? [];
  const axes = model.kind === SEVERAL_AXES;
  const closed = inverse && !axes && source?.has_controllers === true;
  const range = inverse && !axes && (asked.get('low') || asked.get('high'));
  const settings = {
    as: form,
    sample_rate_hz: given(code, 'rate'),
    single: source?.has_single_precision && asked.get('double') === null ? true : undefined,
    name: given(code, 'prefix'),
    accuracy: given(code && !axes, 'accuracy'),
    lowest_frequency_hz: given(code && !axes, 'lowest'),
    inverse: inverse || undefined,
    controller: given(closed, 'controller'),
    ranges: given(inverse && axes, 'ranges'),
    level: given(code && axes, 'level'),
    low: range ? (asked.get('low') ?? low) : undefined,
    high: range ? (asked.get('high') ?? high) : undefined,
    slew_per_s: given(inverse, 'slew'),
    bandwidth_hz: given(inverse, 'bandwidth'),
    preview: given(inverse, 'preview'),
    predict_to_hz: given(inverse && !axes, 'predict'),
  };
  const preview = useLatest<Preview>(source ? `${at}/preview${query(settings)}` : null);
  useEffect(() => {
    command.value = (code && preview.value?.command) || null;
  }, [code, preview.value]);
  const title = forms.find(([name]) => name === form)?.[1] ?? '';
  const files = code ? preview.value?.files : form === 'json' ? modelFile(model, detail) : [];
  const size = files?.reduce((sum, file) => sum + file.bytes, 0);
  return (
    <>
      <Head title={TITLE} question={QUESTION}>
        <Origin simulated={model.simulated} />
        <a
          class="btn primary"
          href={href(`${at}/download${query(settings)}`)}
          download={`${model.name}${code ? `-${form}.zip` : form === 'json' ? '.json' : '.html'}`}
          aria-disabled={code && preview.error !== undefined}
        >
          <Icon name="down" />
          Download {title}
          {size ? `, ${bytes(size)}` : ''}
        </a>
      </Head>
      <div class="cols g-home">
        <div class="stack">
          <Settings models={models} model={model} detail={detail} />
          {closed && <Around />}
          {code && <More detail={detail} inverse={inverse} axes={axes} />}
          <fieldset>
            <TableBox label="Forms">
              <table class="mid">
                <caption>Forms</caption>
                <thead>
                  <tr>
                    <th scope="col">Form</th>
                    <th scope="col">Content</th>
                    <th scope="col">Size</th>
                  </tr>
                </thead>
                <tbody>
                  {forms.map(([name, label, what]) => (
                    <tr
                      key={name}
                      class={`click ${name === form ? 'sel' : ''}`}
                      onClick={() => settle({ form: name })}
                    >
                      <td class="nw">
                        <label class="row">
                          <input
                            type="radio"
                            name="form"
                            checked={name === form}
                            onChange={() => settle({ form: name, file: null })}
                          />
                          <b>{label}</b>
                        </label>
                      </td>
                      <td class="soft">{what}</td>
                      <td class="nw soft">
                        {name === form && files?.length
                          ? `${count(files.length, 'file')}, ${bytes(size ?? 0)}`
                          : 'made on request'}
                      </td>
                    </tr>
                  ))}
                </tbody>
              </table>
            </TableBox>
          </fieldset>
          <Exactness preview={code ? preview.value : undefined} detail={detail} />
          <Operation
            key={model.id}
            name="realise"
            title="Poles for a controller"
            about="The dynamics as a fixed number of real poles and pole pairs, checked against the simulation of a record."
            at={`${path('models', model.id)}/realise`}
            request={{}}
            verb="Realise"
          />
          <Reports />
        </div>
        <div class="stack">
          <Working at={`${at}/preview`} what={title} />
          {preview.error ? (
            <Failure
              problem={preview.error.complaint}
              actions={
                <button type="button" onClick={() => changed(`${at}/preview`)}>
                  Make it again
                </button>
              }
            />
          ) : (
            <Files files={files} />
          )}
          <Repeat />
        </div>
      </div>
    </>
  );
}

function Settings({
  models,
  model,
  detail,
}: {
  models: ModelEntry[];
  model: ModelEntry;
  detail?: ModelDetail;
}) {
  const { query: asked } = useSignal(route);
  const rate = detail?.sample_rate_hz;
  const double = asked.get('double') !== null;
  return (
    <div class="row wrap gaps">
      <span class="row">
        <span class="soft">Model</span>
        <ModelChoice models={models} model={model} />
      </span>
      <label class="row">
        <span class="soft">Controller</span>
        <input
          type="number"
          class="short"
          min="0"
          step="any"
          placeholder={rate ? significant(rate, 4) : ''}
          value={asked.get('rate') ?? ''}
          onChange={(event) => settle({ rate: event.currentTarget.value || null })}
        />
        Hz
      </label>
      <span class="seg" role="group" aria-label="Number type">
        <button type="button" aria-pressed={!double} onClick={() => settle({ double: null })}>
          f32
        </button>
        <button type="button" aria-pressed={double} onClick={() => settle({ double: '1' })}>
          f64
        </button>
      </span>
      <label class="row">
        <input
          type="checkbox"
          checked={asked.get('plain') === null}
          onChange={(event) => settle({ plain: event.currentTarget.checked ? null : '1' })}
        />
        with inverse
      </label>
    </div>
  );
}

/** A controller that runs the inverse: with feedback on the reading, or an observer. */
function Around() {
  const { query: asked } = useSignal(route);
  const offered = useResource<Options>('options').value?.choices ?? [];
  const choices = offered.find((one) => one.option === 'exported_controllers')?.choices ?? [];
  return (
    <label class="row">
      <span class="soft">Feedback around the inverse</span>
      <select
        value={asked.get('controller') ?? ''}
        onChange={(event) => settle({ controller: event.currentTarget.value || null, file: null })}
      >
        <option value="">none</option>
        {choices.map(({ name, summary }) => (
          <option key={name} value={name}>
            {summary}
          </option>
        ))}
      </select>
    </label>
  );
}

/** Name and accuracy of the source, and the limits of the inverse: those of the drive in Follow. */
function More(props: { detail?: ModelDetail; inverse: boolean; axes: boolean }) {
  const { detail, inverse, axes } = props;
  const { query: asked } = useSignal(route);
  const unit = detail?.input_unit ?? '';
  const [low, high] = detail?.drive_range ?? [];
  const given = (key: string, usual: string) => ({
    class: 'short',
    placeholder: usual,
    value: asked.get(key) ?? '',
    onChange: (event: { currentTarget: HTMLInputElement }): void =>
      settle({ [key]: event.currentTarget.value.trim() || null }),
  });
  const field = (key: string, label: string, usual: string, behind: string) => (
    <label class="row">
      <span class="soft">{label}</span>
      <input type="number" step="any" {...given(key, usual)} />
      {behind}
    </label>
  );
  return (
    <details>
      <summary>Name, accuracy{inverse ? ', limits of the inverse' : ''}</summary>
      <div class="row wrap gaps">
        <label class="row">
          <span class="soft">Names begin with</span>
          <input type="text" {...given('prefix', 'the model’s')} />
        </label>
        {axes && field('level', 'Modes at a drive of', 'the highest level', `${unit} rms`)}
        {!axes && field('accuracy', 'Dynamics within', 'as good as the model', 'of the gain')}
        {!axes && field('lowest', 'Creep down to', 'as usual', 'Hz')}
        {inverse && axes && (
          <label class="row">
            <span class="soft">Drives</span>
            <input
              type="text"
              title="LOW:HIGH for all actuators, or one each, separated by commas"
              {...given('ranges', 'as identified, e.g. -1:1,-2:2')}
            />
            {unit}
          </label>
        )}
        {inverse && (
          <>
            {!axes && field('low', 'Drive from', low != null ? significant(low) : '', unit)}
            {!axes && field('high', 'to', high != null ? significant(high) : '', unit)}
            {field('slew', 'Slew at most', 'no limit', `${unit}/s`)}
            {field('bandwidth', 'Follows up to', 'as usual', 'Hz')}
            {field('preview', 'Known ahead', 'as needed', 'samples')}
            {!axes && field('predict', 'Predicted up to', 'not', 'Hz')}
          </>
        )}
      </div>
    </details>
  );
}

function Exactness({ preview, detail }: { preview?: Preview; detail?: ModelDetail }) {
  const facts: [string, string | null | undefined][] = [
    ['States', preview?.states != null ? integer(preview.states) : null],
    [
      'Realised dynamics',
      preview?.error != null ? `within ${significant(preview.error, 2)} of the gain` : null,
    ],
    ['Valid', detail?.valid_range],
  ];
  const known = facts.filter(([, text]) => text);
  if (known.length === 0) return null;
  return (
    <div>
      <div class="ph">
        <h2>What the code costs and how exact it is</h2>
      </div>
      <dl class="facts">
        {known.map(([name, text]) => (
          <>
            <dt>{name}</dt>
            <dd>{prose(text ?? '')}</dd>
          </>
        ))}
      </dl>
      {preview?.findings.map((finding) => (
        <LibraryFinding key={finding.text} finding={finding} />
      ))}
    </div>
  );
}

/** The model file as it lies in the workspace. */
function modelFile(model: ModelEntry, detail: ModelDetail | undefined): Preview['files'] | undefined {
  return (
    detail && [
      { name: `${model.name}.json`, bytes: model.bytes, text: JSON.stringify(detail.file, null, 2) },
    ]
  );
}

function Files({ files }: { files?: Preview['files'] }) {
  const { query: asked } = useSignal(route);
  if (!files) return <Waiting height={280} />;
  const texts = files.filter((file) => file.text != null);
  const shown = texts.find((file) => file.name === asked.get('file')) ?? texts[0];
  if (files.length === 0) return <Waiting height={280} text="The report is made when it is downloaded." />;
  return (
    <div>
      <div class="ph">
        <h2>Preview</h2>
        {texts.length > 0 && (
          <select
            aria-label="File that is shown"
            value={shown?.name}
            onChange={(event) => settle({ file: event.currentTarget.value })}
          >
            {texts.map((file) => (
              <option key={file.name} value={file.name}>
                {file.name}
              </option>
            ))}
          </select>
        )}
      </div>
      <pre class="code" tabIndex={0} aria-label={`Preview of ${shown?.name ?? 'nothing'}`}>
        {shown?.text ?? files.map((file) => `${file.name}, ${bytes(file.bytes)}`).join('\n')}
      </pre>
    </div>
  );
}

/** Everything done in this workspace, as a script. */
export function Repeat() {
  const { query: asked } = useSignal(route);
  const history = useResource<History>('history').value;
  const [copied, mark] = useState(false);
  const python = asked.get('lang') === 'python';
  const text = (python ? history?.python : history?.shell) ?? '';
  return (
    <div>
      <div class="ph">
        <h2>Repeat everything</h2>
        <Language of="script" />
        <span class="sp" />
        <button
          type="button"
          class="quiet"
          onClick={() => {
            copy(text);
            mark(true);
          }}
        >
          <Icon name="copy" />
          {copied ? 'Copied' : 'Copy'}
        </button>
      </div>
      <pre class="code" tabIndex={0} aria-label="Script that repeats everything">
        {text || '# nothing was done yet'}
      </pre>
    </div>
  );
}

function Reports() {
  const reports = useResource<ReportEntry[]>('reports').value ?? [];
  if (reports.length === 0) return null;
  return (
    <div>
      <div class="ph">
        <h2>Reports in the folder</h2>
      </div>
      <ul class="plain">
        {reports.map((report) => (
          <li key={report.id}>
            <a href={href(path('reports', report.id))} target="_blank" rel="noreferrer">
              {fileName(report.id)}
            </a>{' '}
            {bytes(report.bytes)}
          </li>
        ))}
      </ul>
    </div>
  );
}
