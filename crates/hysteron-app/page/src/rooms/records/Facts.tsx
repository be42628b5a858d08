// What is in a record, and what it or its device's records determine.
import { Finding, LibraryFinding } from '../../components/words';
import type { Inspection, Prospects, RecordDetail } from '../../api/types';
import { capital } from '../../components/words';
import { TableBox } from '../../components/window';
import { hertz, integer, prose, quantityText, seconds, significant, unitText } from '../../format';

function drive(inspection: Inspection): string {
  const { kind, low_hz: low, high_hz: high } = inspection.drive;
  if (!low || !high) return kind;
  return `${kind}, ${low === high ? hertz(low) : `${significant(low)} to ${hertz(high)}`}`;
}

const range = (channel: Inspection['input']): string =>
  `${significant(channel.low, 4)} to ${significant(channel.high, 4)} ${unitText(channel.unit)}`;

const METHODS: Record<string, string> = {
  'period-repeats': 'from repeated periods',
  'fourth-differences': 'from fourth differences, at most',
};

function facts(record: RecordDetail, seen: Inspection): [string, string][] {
  const { input, output, loop } = seen;
  const method = METHODS[seen.noise_floor_method ?? ''] ?? 'method unknown';
  const held = [input, output].filter((c) => c.saturated_low_samples + c.saturated_high_samples > 0);
  const list: [string, string | null][] = [
    ['Drive', `${drive(seen)}; ${range(input)}`],
    ['Output', range(output)],
    [
      'Stroke of the loop',
      loop && quantityText(loop.stroke, output.unit, 4) + (seen.periods?.settling ? ', settled' : ''),
    ],
    [
      'Loop opening',
      loop &&
        `${quantityText(loop.opening, output.unit)}, ` +
          `${significant(loop.opening_percent_of_stroke)} % of that stroke` +
          `, ${loop.butterfly ? 'crosses itself' : loop.sense}`,
    ],
    [
      'Noise floor',
      seen.noise_floor_rms != null
        ? `${quantityText(seen.noise_floor_rms, output.unit)} rms (${method})`
        : null,
    ],
    [
      'Periods',
      seen.periods &&
        `${integer(seen.periods.count)} whole; settled after ${integer(seen.periods.settling)}`,
    ],
    [
      'Saturation',
      held.length === 0
        ? 'none'
        : held
            .map((c) => `${c.name}: ${integer(c.saturated_low_samples + c.saturated_high_samples)} samples`)
            .join(', '),
    ],
    ['Stretches', seen.segments?.length ? `${seen.segments.length} of even sampling` : null],
    ['Gaps', record.gaps.length ? gapsOf(record.gaps) : null],
    ['Continues', record.settings.continues],
    [
      'Masked',
      seen.masked_samples ? `${integer(seen.masked_samples)} samples: simulated, not scored` : null,
    ],
  ];
  return list.filter((fact): fact is [string, string] => fact[1] != null);
}

export function Facts({ record }: { record: RecordDetail }) {
  if (!record.inspection) return null;
  const seen = record.inspection.findings.filter((finding) => !finding.warning);
  return (
    <div>
      <div class="ph">
        <h2>What is in it</h2>
      </div>
      <dl class="facts">
        {facts(record, record.inspection).map(([name, text]) => (
          <>
            <dt>{name}</dt>
            <dd>{text}</dd>
          </>
        ))}
      </dl>
      {seen.length > 0 && (
        <details>
          <summary>What else was seen</summary>
          <ul class="plain dots">
            {seen.map((finding) => (
              <li key={finding.text}>{prose(finding.text)}</li>
            ))}
          </ul>
        </details>
      )}
    </div>
  );
}

const YES: Record<string, [string, string]> = {
  true: ['y', 'yes'],
  false: ['x', 'no'],
  null: ['p', 'in part'],
};

export function Determines({ prospects, of }: { prospects: Prospects; of: number }) {
  const title = of === 1 ? 'What this record determines' : `What these ${of} records determine together`;
  return (
    <TableBox label="What is determined">
      <table>
        <caption>{title}</caption>
        <thead>
          <tr>
            <th scope="col">Of the device</th>
            <th scope="col">
              <span class="vh">Determined</span>
            </th>
            <th scope="col">because</th>
          </tr>
        </thead>
        <tbody>
          {prospects.statements.map((statement) => {
            const [mark, word] = YES[String(statement.determined)] ?? ['p', 'in part'];
            return (
              <tr key={statement.topic}>
                <td>{statement.topic}</td>
                <td>
                  <span class={`yn ${mark}`}>
                    <i />
                    {word}
                  </span>
                </td>
                <td>{prose(statement.text)}</td>
              </tr>
            );
          })}
        </tbody>
      </table>
    </TableBox>
  );
}

/** Warnings of the inspection, then choices made while the file was read. */
export function Remarks({ record }: { record: RecordDetail }) {
  const warnings = record.inspection?.findings.filter((finding) => finding.warning) ?? [];
  if (warnings.length + record.notes.length === 0) return null;
  return (
    <div class="finds">
      {warnings.map((finding) => (
        <Finding key={finding.text} kind="warn">
          {finding.topic && <b>{capital(finding.topic)}: </b>}
          {prose(finding.text)}
        </Finding>
      ))}
      {record.notes.map((note) => (
        <LibraryFinding key={note.text} finding={note} />
      ))}
    </div>
  );
}

const GAPS_SHOWN = 4;

/** The longest gaps, and how many there are. */
function gapsOf(gaps: RecordDetail['gaps']): string {
  const length = (gap: (typeof gaps)[0]): number => gap.to_s - gap.from_s;
  const longest = [...gaps].sort((a, b) => length(b) - length(a)).slice(0, GAPS_SHOWN);
  const told = longest.map((gap) => `${seconds(length(gap))} at ${seconds(gap.from_s)}`).join(', ');
  return gaps.length > GAPS_SHOWN ? `${gaps.length}, the longest ${told}` : told;
}
