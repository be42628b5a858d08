// Room 5: which drive follows a reference within limits, and how well?
import { useEffect, useMemo } from 'preact/hooks';
import { path } from '../../api/client';
import { useAnswer, useLatest, useResource } from '../../api/resource';
import type { Followed, ModelDetail, ModelEntry, RecordEntry } from '../../api/types';
import { command } from '../../components/dock';
import { ModelChoice, NoModel, useModel } from '../../components/models';
import { Failure, Head, Origin, Waiting } from '../../components/words';
import { route } from '../../route';
import { useSignal } from '../../signal';
import { Bench } from './Bench';
import { LimitsForm, ReferenceForm, type Limits, type Specification } from './Reference';
import { Curves, Result } from './Result';
import { Save } from './Save';

const TITLE = 'Follow';
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

/** Ten lines a second over the middle of what the model's records reached. */
function raster(detail: ModelDetail, output: [number, number]): Specification {
  const rate = detail.sample_rate_hz ?? 1000;
  return {
    sample_rate_hz: rate,
    low_v: Number(output[0].toPrecision(3)),
    high_v: Number(output[1].toPrecision(3)),
    waveform: { kind: 'raster', line_hz: 10, lines: 12, return_fraction: 0.25, turnaround_fraction: 0.1 },
  };
}

function Room({ models, model }: { models: ModelEntry[]; model: ModelEntry }) {
  const detail = useLatest<ModelDetail>(path('models', model.id)).value;
  const records = useResource<RecordEntry[]>('records').value;
  if (!detail || !records) {
    return (
      <>
        <Head title={TITLE} question={QUESTION} />
        <Waiting height={300} />
      </>
    );
  }
  return <Ready models={models} model={model} detail={detail} records={records} />;
}

function Ready(props: {
  models: ModelEntry[];
  model: ModelEntry;
  detail: ModelDetail;
  records: RecordEntry[];
}) {
  const { model, detail, records } = props;
  const { query: asked } = useSignal(route);
  const stated = asked.get('ref');
  const specification = useMemo<Specification>(() => {
    try {
      return stated?.startsWith('{')
        ? (JSON.parse(stated) as Specification)
        : raster(detail, middle(detail));
    } catch {
      return raster(detail, middle(detail));
    }
  }, [stated, detail]);
  const file = records.find((record) => record.id === stated);
  const limits: Limits = {
    low: asked.get('low') ?? '',
    high: asked.get('high') ?? '',
    slew: asked.get('slew') ?? '',
    bandwidth: asked.get('bandwidth') ?? '',
  };
  const [from, to] = [limits.low || detail.drive_range?.[0], limits.high || detail.drive_range?.[1]];
  const reference = file ? { from: 'record', id: file.id } : { from: 'waveform', specification };
  const request = {
    reference,
    range: from != null && to != null && (limits.low || limits.high) ? [Number(from), Number(to)] : null,
    slew_per_s: limits.slew ? Number(limits.slew) : null,
    bandwidth_hz: limits.bandwidth ? Number(limits.bandwidth) : null,
  };
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
        <Save at={at} request={request} ready={followed !== undefined} />
      </Head>
      <div class="stack">
        <ReferenceForm specification={specification} file={file} records={records} />
        <LimitsForm limits={limits} detail={detail} />
        {answer.error && <Failure problem={answer.error.complaint} />}
        {!followed && !answer.error && <Waiting height={72} />}
        {followed && <Result followed={followed} />}
        {followed && (
          <div class="cols g-cmp">
            <Curves followed={followed} />
            <Bench
              key={JSON.stringify(reference)}
              at={at}
              reference={reference}
              range={request.range}
              slew={request.slew_per_s}
              bandwidth={request.bandwidth_hz}
            />
          </div>
        )}
      </div>
    </>
  );
}

/** Of the range of the output that the model file states, else 0 to 10. */
function middle(detail: ModelDetail): [number, number] {
  const file = detail.file as { valid_range?: { output?: { low?: number; high?: number } } } | null;
  const low = file?.valid_range?.output?.low;
  const high = file?.valid_range?.output?.high;
  return typeof low === 'number' && typeof high === 'number' ? [low, high] : [0, 10];
}
