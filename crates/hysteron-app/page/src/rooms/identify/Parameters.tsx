// Numbers of a model with their errors and 95 % intervals.
import type { ModelDetail, ParameterRow } from '../../api/types';
import { words } from '../../components/schema';
import { TableBox } from '../../components/window';
import { printed, significant, unitText } from '../../format';
import { address } from '../../route';

/** Half the width of a linear bar, as a share of the value. */
const HALF = 0.5;
/** A bar that this does not hold is drawn over decades: a tenth to ten times the value. */
const DECADES = 1;

/** Relative standard error from which a number is called poorly known. */
const POOR = 0.3;

/** What the records leave open of a number; nothing where they determine it. */
function leftOpen(row: ParameterRow): string | null {
  if (row.at_limit) return 'at the end of its range';
  const poor = !row.held && row.std_error != null && row.std_error > POOR * Math.abs(row.value);
  return poor ? 'poorly known' : null;
}

export function Parameters({ model, record }: { model: ModelDetail; record?: string }) {
  const rows = model.parameters;
  const places = rows.some((row) => row.place);
  const open = rows.some((row) => leftOpen(row) !== null);
  return (
    <TableBox label="Parameters">
      <table class="params">
        <caption>
          Parameters{' '}
          <span class="soft s">
            value ± standard error; bar: 95 % interval, full width ± 50 % of the value
          </span>
        </caption>
        <thead>
          <tr>
            {places && <th scope="col">Block</th>}
            <th scope="col">Parameter</th>
            <th scope="col" class="n">
              Value
            </th>
            <th scope="col" class="n">
              ± error
            </th>
            <th scope="col">Unit</th>
            <th scope="col" class="bars">
              95 %
            </th>
            {open && <th scope="col">State</th>}
          </tr>
        </thead>
        <tbody>
          {rows.map((row) => (
            <tr key={`${row.place} ${row.name}`}>
              {places && <td>{row.place}</td>}
              <td>{words(row.name)}</td>
              <td class="n">{printed(row.text)}</td>
              <td class="n soft">{row.held ? 'held' : printed(row.std_error_text)}</td>
              <td class="nw">{unitText(row.unit)}</td>
              <td>
                <IntervalBar row={row} />
              </td>
              {open && (
                <td class="soft">
                  {leftOpen(row)}
                  {leftOpen(row) && record && (
                    <>
                      {' '}
                      <a href={address({ r: record, make: '1', m: null }, 'records')}>measure it…</a>
                    </>
                  )}
                </td>
              )}
            </tr>
          ))}
        </tbody>
      </table>
    </TableBox>
  );
}

function IntervalBar({ row }: { row: ParameterRow }) {
  const { value, interval } = row;
  if (!interval || interval.low == null || interval.high == null || value === 0) return null;
  const ratio = [interval.low / value, interval.high / value].sort((a, b) => a - b) as [number, number];
  const linear = ratio[0] >= 1 - HALF && ratio[1] <= 1 + HALF;
  const positive = ratio[0] > 0;
  const place = (r: number): number => {
    const share = linear || !positive ? (r - 1) / HALF : Math.log10(Math.max(r, 1e-9)) / DECADES;
    return 60 + Math.max(-58, Math.min(58, share * 58));
  };
  const text = `95 % interval: ${significant(interval.low)} to ${significant(interval.high)}`;
  const wide = !linear;
  return (
    <span class="ivw">
      <svg class="iv" viewBox="0 0 120 16" preserveAspectRatio="none" role="img" aria-label={text}>
        <title>{text}</title>
        <line class="t" x1="2" x2="118" y1="8" y2="8" />
        <line class="t" x1="60" x2="60" y1="2" y2="14" />
        <line class={wide ? 'b w' : 'b'} x1={place(ratio[0])} x2={place(ratio[1])} y1="8" y2="8" />
        <rect class="d" x="59" y="4" width="2" height="8" />
      </svg>
      {wide && <small class="soft">{positive ? 'log, 0.1 to 10 times' : 'beyond ± 50 %'}</small>}
    </span>
  );
}
