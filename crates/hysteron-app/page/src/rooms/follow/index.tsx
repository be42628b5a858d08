// Room 5: which drive follows a reference within limits, and how well?
import { useEffect, useMemo } from 'preact/hooks';
import { change, path } from '../../api/client';
import { changed, useAnswer, useLatest, useResource } from '../../api/resource';
import type { Followed, ModelDetail, ModelEntry, RecordDetail, RecordEntry } from '../../api/types';
import { command } from '../../components/dock';
import { SaveAs } from '../../components/SaveAs';
import { ModelChoice, NoModel, useModel } from '../../components/models';
import { Failure, Head, Origin, Waiting } from '../../components/words';
import { Working } from '../../components/Working';
import { route } from '../../route';
import { useSignal } from '../../signal';
import { recordsOf } from '../identify/Done';
import { Bench } from './Bench';
import { LimitsForm, ReferenceForm, type Limits, type Specification } from './Reference';
import { DRAWN, read, sampled, written } from './drawn';
import { Decouple } from './Decouple';
import { Curves, Result } from './Result';
import { Simulate } from './Simulate';
import { TrackAxes } from './TrackAxes';

const TITLE = 'Follow';
const SEVERAL_AXES = ['modes', 'branches'];
const QUESTION = 'Which drive follows my reference, within my limits, and how well?';

export function Follow() {
  const { models, model } = useModel();
  if (!models || !model) {
    return (
      <>
        <Head title={TITLE} question={QUESTION} />
        {models ? <NoModel /> : <Waiting height={300} />}
      </>
    );
  }
  return <Room key={model.id} models={models} model={model} />;
}

/** What the model's records reached, without the outer fifths: a reference that can be followed. */
interface Reach {
  low: number;
  high: number;
  /** Highest frequency of the records (Hz). */
  frequency: number;
}

const MARGIN = 0.2;

function reachOf(detail: ModelDetail, record: RecordDetail | undefined): Reach {
  const output = record?.inspection?.output;
  const [low, high] = output ? [output.low, output.high] : [0, 10];
  const inner = (share: number): number => Number((low + (high - low) * share).toPrecision(3));
  const file = detail.file as { valid_range?: { frequency?: { high?: number } } } | null;
  return {
    low: inner(MARGIN),
    high: inner(1 - MARGIN),
    frequency: file?.valid_range?.frequency?.high ?? 1,
  };
}

/** A raster of at most ten lines a second, whose return is within the frequencies of the records. */
function raster(detail: ModelDetail, reach: Reach): Specification {
  return {
    sample_rate_hz: detail.sample_rate_hz ?? 1000,
    low_v: reach.low,
    high_v: reach.high,
    waveform: {
      kind: 'raster',
      line_hz: Math.min(10, Number((reach.frequency / 2).toPrecision(2))),
      lines: 8,
      return_fraction: 0.25,
      turnaround_fraction: 0.1,
    },
  };
}

/** Up and down once, to be changed by hand. */
function triangle(reach: Reach): string {
  const half = 0.5 / Math.min(10, reach.frequency);
  return written([
    [0, reach.low],
    [half, reach.high],
    [2 * half, reach.low],
  ]);
}

function Room({ models, model }: { models: ModelEntry[]; model: ModelEntry }) {
  const detail = useLatest<ModelDetail>(path('models', model.id)).value;
  const records = useResource<RecordEntry[]>('records').value;
  const fitted = detail && records ? recordsOf(model, records)[0] : undefined;
  const record = useLatest<RecordDetail>(fitted ? path('records', fitted.id) : null).value;
  if (records && detail && SEVERAL_AXES.includes(model.kind ?? '')) {
    return (
      <>
        <Head title={TITLE} question={QUESTION}>
          <Origin simulated={model.simulated} />
          <ModelChoice models={models} model={model} />
        </Head>
        <div class="stack">
          <Decouple model={model} records={records} />
          {model.kind === 'modes' && <TrackAxes model={model} records={records} />}
          <Simulate model={model} records={records} />
        </div>
      </>
    );
  }
  if (!detail || !records || (fitted && !record)) {
    return (
      <>
        <Head title={TITLE} question={QUESTION} />
        <Waiting height={300} />
      </>
    );
  }
  return (
    <Ready
      models={models}
      model={model}
      detail={detail}
      records={records}
      reach={reachOf(detail, record)}
    />
  );
}

function Ready(props: {
  models: ModelEntry[];
  model: ModelEntry;
  detail: ModelDetail;
  records: RecordEntry[];
  reach: Reach;
}) {
  const { model, detail, records, reach } = props;
  const { query: asked } = useSignal(route);
  const stated = asked.get('ref');
  const specification = useMemo<Specification>(() => {
    try {
      if (stated?.startsWith('{')) return JSON.parse(stated) as Specification;
    } catch {
      // An address that was cut short shows the usual reference.
    }
    return raster(detail, reach);
  }, [stated, detail, reach.low, reach.high]);
  const points = stated?.startsWith(DRAWN) ? read(stated.slice(DRAWN.length)) : null;
  const file = records.find((record) => record.id === stated);
  const limits: Limits = {
    low: asked.get('low') ?? '',
    high: asked.get('high') ?? '',
    slew: asked.get('slew') ?? '',
    bandwidth: asked.get('bandwidth') ?? '',
    rest: asked.get('rest') ?? '',
    virgin: asked.get('virgin') ?? '',
    preview: asked.get('preview') ?? '',
    predict: asked.get('predict') ?? '',
    learn: asked.get('learn') ?? '',
    periodic: asked.get('periodic') !== null,
    correct: asked.get('correct') !== null && detail.correctable,
  };
  const [from, to] = [limits.low || detail.drive_range?.[0], limits.high || detail.drive_range?.[1]];
  const rate = detail.sample_rate_hz ?? 1000;
  const reference = file
    ? { from: 'record', id: file.id }
    : points
      ? { from: 'samples', sample_rate_hz: rate, values: sampled(points, rate) }
      : { from: 'waveform', specification };
  const number = (text: string): number | null => (text ? Number(text) : null);
  const inverse = {
    range: from != null && to != null && (limits.low || limits.high) ? [Number(from), Number(to)] : null,
    slew_per_s: number(limits.slew),
    bandwidth_hz: number(limits.bandwidth),
    periodic: limits.periodic,
    rest_voltage: limits.periodic ? null : number(limits.rest),
    virgin_voltage: limits.periodic ? null : number(limits.virgin),
    preview: number(limits.preview),
    predict_to_hz: number(limits.predict),
    correct: limits.correct,
  };
  const request = { reference, inverse, learn_from: limits.learn || null };
  const at = path('models', model.id);
  const answer = useAnswer<Followed>(`${at}/follow`, request);
  const followed = answer.value;
  useEffect(() => {
    command.value = followed?.command ?? null;
  }, [followed]);
  return (
    <>
      <Head title={TITLE} question={QUESTION}>
        <Origin simulated={model.simulated} />
        <ModelChoice models={props.models} model={model} />
        <SaveAs
          stem="drive"
          device={model.device}
          what="drive"
          label="Download the drive"
          ready={followed !== undefined}
          primary
          write={async (save) =>
            (await change<Followed>('POST', `${at}/follow`, { ...request, save })).file
          }
        />
      </Head>
      <div class="stack">
        <ReferenceForm
          specification={specification}
          file={file}
          records={records}
          points={points}
          unit={model.unit}
          first={DRAWN + triangle(reach)}
        />
        <LimitsForm
          limits={limits}
          detail={detail}
          runs={records.filter((record) => !record.error && !record.reading)}
        />
        {answer.error && (
          <Failure
            problem={answer.error.complaint}
            actions={
              <button type="button" onClick={() => changed(`${at}/follow`)}>
                Compute again
              </button>
            }
          />
        )}
        <Working at={`${at}/follow`} what="Drive" />
        {!followed && !answer.error && <Waiting height={78} />}
        {followed && <Result followed={followed} />}
        {followed && (
          <div class="cols g-cmp">
            <Curves followed={followed} />
            <Bench
              key={JSON.stringify(reference)}
              at={at}
              reference={reference}
              device={model.device}
              inverse={inverse}
              simulated={model.simulated}
            />
          </div>
        )}
        <Simulate model={model} records={records} />
      </div>
    </>
  );
}
