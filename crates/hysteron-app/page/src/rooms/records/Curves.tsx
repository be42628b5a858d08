// Loop, output and drive of a record; the server thins them to what the width can show.
import { useMemo } from 'preact/hooks';
import { path, query } from '../../api/client';
import { useLatest } from '../../api/resource';
import type { Curve, CurveAxis, RecordDetail, RecordEntry } from '../../api/types';
import { Failure, Waiting } from '../../components/words';
import { hertz } from '../../format';
import { Plot } from '../../plot/Plot';
import type { Line, Spec } from '../../plot/spec';
import { setZoom, zoomOf } from '../../plot/zoom';
import { route } from '../../route';
import { useSignal } from '../../signal';
import { settings } from './roles';

const PIXELS = 1000;

export function axisLabel(quantity: string, axis: CurveAxis): string {
  const named = axis.name && axis.name !== quantity ? `${quantity} ${axis.name}` : quantity;
  return axis.unit ? `${named} (${axis.unit})` : named;
}

export function asLine(curve: Curve | undefined, color: Line['color'], width: number, name?: string): Line {
  return { x: curve?.x ?? [], y: curve?.y ?? [], breaks: curve?.breaks, color, width, name };
}

/** A record as its curves need it; before its inspection without the rest. */
export type Drawn = RecordEntry & { inspection?: RecordDetail['inspection'] };

export function Curves({ record }: { record: Drawn }) {
  useSignal(route);
  const zoom = zoomOf('t');
  const at = path('records', record.id) + '/curve';
  const window = { from: zoom?.x[0], to: zoom?.x[1], pixels: PIXELS };
  const loop = useLatest<Curve>(at + query({ x: record.input, y: record.output, pixels: 700 }));
  const time = useLatest<Curve>(at + query({ x: 't', y: record.output, ...window }));
  const drive = useLatest<Curve>(at + query({ x: 't', y: record.input, ...window }));
  const failed = loop.error ?? time.error ?? drive.error;

  const loopSpec = useMemo<Spec | null>(
    () => (loop.value ? of(loop.value, 'loop', record) : null),
    [loop.value, record],
  );
  const timeSpec = useMemo<Spec | null>(
    () => (time.value ? over(time.value, record, true) : null),
    [time.value, record],
  );
  const driveSpec = useMemo<Spec | null>(
    () => (drive.value ? over(drive.value, record, false) : null),
    [drive.value, record],
  );
  if (failed) return <Failure problem={failed.complaint} />;
  return (
    <div class="cols g-plots">
      {loopSpec ? <Plot spec={loopSpec} /> : <Waiting height={382} />}
      <div>
        {timeSpec ? <Plot spec={timeSpec} /> : <Waiting height={230} />}
        {driveSpec ? <Plot spec={driveSpec} /> : <Waiting height={178} />}
      </div>
    </div>
  );
}

function of(curve: Curve, key: string, record: Drawn): Spec {
  const opening = record.inspection?.loop;
  return {
    key,
    title: `Loop, ${curve.shown}`,
    description: opening
      ? `Opens by ${opening.opening.toPrecision(3)} ${curve.up.unit}, ${opening.sense}.`
      : '',
    height: 356,
    loop: true,
    x: { label: axisLabel('drive', curve.across), unit: curve.across.unit },
    y: { label: axisLabel('output', curve.up), unit: curve.up.unit },
    lines: [asLine(curve, 'measured', 1.5)],
    tools: ['zoom', 'pan'],
  };
}

function over(curve: Curve, record: Drawn, output: boolean): Spec {
  const segments = record.inspection?.segments ?? [];
  return {
    key: 't',
    title: output ? 'Time' : 'Drive',
    description: `${output ? 'Output' : 'Drive'} over time.`,
    height: output ? 204 : 152,
    flat: true,
    x: { label: 'time (s)', unit: 's', range: [curve.across.low, curve.across.high], hide: output },
    y: {
      label: axisLabel(output ? 'output' : 'drive', curve.up),
      unit: curve.up.unit,
    },
    lines: [asLine(curve, output ? 'measured' : 'drive', 1.3)],
    stretches: segments.map((segment) => ({
      from: segment.start_s,
      to: segment.start_s + segment.duration_s,
      label: output ? hertz(segment.sample_rate_hz) : undefined,
    })),
    masks: record.settings.masks,
    tools: output ? ['zoom', 'pan', 'mask', 'cut'] : [],
    chosen: (tool, from, to) => {
      if (tool === 'mask') void settings(record.id, { masks: [...record.settings.masks, [from, to]] });
      else void settings(record.id, { from_s: from, to_s: to }).then(() => setZoom('t', null));
    },
  };
}
