// Structures of several axes: their columns, and the ranking of a comparison.
import type { AxesComparison } from '../api/types';
import { PickRow } from '../components/Pick';
import { Finding } from '../components/words';
import { TableBox } from '../components/window';
import { count, prose, significant } from '../format';

type Candidate = AxesComparison['candidates'][0];

export function AxesRanking({ comparison, pick }: { comparison: AxesComparison; pick: string | null }) {
  const unit = comparison.output_unit;
  const within = (value: number | null, error: number | null): string =>
    value == null ? '–' : `${significant(value, 3)}${error == null ? '' : ` ± ${significant(error, 2)}`}`;
  const above = (candidate: Candidate): string =>
    candidate.name === comparison.best
      ? 'best'
      : within(candidate.above_best, candidate.above_best_std_error);
  return (
    <>
      {comparison.notes.length > 0 && (
        <Finding kind={comparison.preferred ? 'good' : 'note'}>
          {comparison.notes.map((note, i) => (
            <p key={note}>{i === 0 ? <b>{prose(note)}</b> : prose(note)}</p>
          ))}
        </Finding>
      )}
      <TableBox label="Ranking">
        <table class="mid">
          <caption>
            Left out in turn: {count(comparison.folds.length, 'fold')}{' '}
            <span class="soft s">one record of every level</span>
          </caption>
          <thead>
            <tr>
              <th scope="col">Structure</th>
              <th scope="col" class="n">
                Modes
              </th>
              <th scope="col" class="n">
                Parameters
              </th>
              <th scope="col" class="n">
                Held-out error <small>{unit}, ± s.e.</small>
              </th>
              <th scope="col" class="n">
                Above the best <small>{unit}, ± s.e.</small>
              </th>
              <th scope="col" class="n">
                In training <small>{unit}</small>
              </th>
            </tr>
          </thead>
          <tbody>
            {comparison.candidates.map((candidate) => (
              <PickRow key={candidate.name} name={candidate.name} pick={pick}>
                <td class="n">{candidate.modes}</td>
                <td class="n">{candidate.parameters}</td>
                {candidate.error == null ? (
                  <td class="soft" colSpan={3}>
                    {candidate.failures[0] ?? 'not finished'}
                  </td>
                ) : (
                  <>
                    <td class="n">{within(candidate.error, candidate.error_std_error)}</td>
                    <td class="n">{above(candidate)}</td>
                    <td class="n">{within(candidate.training_rmse, null)}</td>
                  </>
                )}
              </PickRow>
            ))}
          </tbody>
        </table>
      </TableBox>
    </>
  );
}
