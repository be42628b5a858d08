// The drive and its predicted error.
import { useMemo } from 'preact/hooks';
import type { Followed } from '../../api/types';
import { Finding, LibraryFinding, Numbers, Prose } from '../../components/words';
import { fileName, integer, quantity, significant } from '../../format';
import { Plot } from '../../plot/Plot';
import type { Spec } from '../../plot/spec';
import { asLine, axisLabel } from '../records/Curves';

export function Result({ followed }: { followed: Followed }) {
  const unit = followed.output_unit;
  const [predicted, predictedUnit] = quantity(followed.predicted_rms_error, unit);
  const shown = followed.shown[0];
  const list = [];
  if (shown) {
    const [value, own] = quantity(shown.rmse, shown.unit);
    list.push({
      label: 'shown by a record, rms',
      value,
      unit: own,
      note: `of the fit, ${fileName(shown.record)}`,
    });
  }
  if (followed.expected_rms_error != null) {
    const [value, own] = quantity(followed.expected_rms_error, unit);
    list.push({ label: 'expected on the device, rms', value, unit: own, note: 'for this reference' });
  }
  const band = followed.band_of_measurement ?? followed.band;
  if (band != null) {
    const [value, own] = quantity(band, unit);
    const measured = followed.band_of_measurement != null;
    list.push({
      label: measured ? '95 % of a new measurement' : '95 % band of the model',
      value: `± ${value}`,
      unit: own,
      note: measured ? 'at its widest' : 'from the errors of the parameters alone',
    });
  }
  list.push({
    label: 'beside it, rms',
    value: predicted,
    unit: predictedUnit,
    note: 'what limits and steps cost, of the model with itself',
  });
  const limited = followed.samples_at_range + followed.samples_at_slew;
  if (followed.preview_samples != null) {
    list.push({
      label: 'known ahead',
      value: integer(followed.preview_samples),
      unit: 'samples',
      note: 'computed sample by sample, as a controller does',
    });
  }
  list.push({
    label: 'drive',
    value: `${significant(followed.drive_low)} to ${significant(followed.drive_high)}`,
    unit: followed.input_unit,
    note:
      limited > 0
        ? `${integer(limited)} of ${integer(followed.samples)} samples at a limit`
        : 'no limit touched',
  });
  return (
    <>
      <Numbers list={list} />
      <div class="finds" hidden={followed.findings.length + followed.remarks.length === 0}>
        {followed.findings.map((finding) => (
          <LibraryFinding key={finding.text} finding={finding} />
        ))}
        {followed.remarks.map((remark) => (
          <Finding key={remark} kind="warn">
            <Prose text={remark} />
          </Finding>
        ))}
      </div>
    </>
  );
}

export function Curves({ followed }: { followed: Followed }) {
  const time = { label: 'time (s)', unit: 's' };
  const specs = useMemo<Spec[]>(() => {
    const { reference, drive, error } = followed;
    const band = followed.band_of_measurement ?? followed.band;
    const x = (curve: typeof drive) => [curve.x[0] ?? 0, curve.x[curve.x.length - 1] ?? 1];
    return [
      {
        key: 'f',
        title: 'Reference',
        height: 150,
        flat: true,
        x: { ...time, hide: true },
        y: { label: axisLabel('reference', { ...reference.up, name: '' }), unit: reference.up.unit },
        lines: [asLine(reference, 'reference', 1.8)],
      },
      {
        key: 'f',
        title: 'Drive',
        height: 150,
        flat: true,
        x: { ...time, hide: true },
        y: { label: axisLabel('drive', { ...drive.up, name: '' }), unit: drive.up.unit },
        lines: [asLine(drive, 'drive', 1.8)],
      },
      {
        key: 'f',
        title: 'Predicted error',
        height: 190,
        flat: true,
        zero: true,
        x: time,
        y: { label: `reference − prediction (${error.up.unit})`, unit: error.up.unit },
        lines: [asLine(error, 'residual', 1.3)],
        band:
          band != null
            ? {
                name:
                  followed.band_of_measurement != null
                    ? '95 % of a new measurement'
                    : '95 % band of the model',
                x: x(error),
                low: [-band, -band],
                high: [band, band],
              }
            : undefined,
      },
    ];
  }, [followed]);
  return (
    <div>
      {specs.map((spec) => (
        <Plot key={spec.title} spec={spec} />
      ))}
    </div>
  );
}
