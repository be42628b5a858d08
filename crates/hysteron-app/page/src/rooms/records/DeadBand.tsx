// What counts of the drive: one below a threshold as nothing, a larger one whole or by what exceeds it.
import { useState } from 'preact/hooks';
import type { RecordDetail, RecordSettings } from '../../api/types';
import { unitText } from '../../format';
import { settings } from './roles';

type Counts = 'dead_band' | 'dead_zone';

export function DeadBand({ record }: { record: RecordDetail }) {
  const { dead_band: band, dead_zone: zone } = record.settings;
  const threshold = band ?? zone;
  const [written, write] = useState('');
  const [counts, count] = useState<Counts>(zone != null ? 'dead_zone' : 'dead_band');
  const [open, show] = useState(threshold != null);
  const set = (band: Pick<RecordSettings, Counts>): void => void settings(record.id, band);
  const unit = unitText(record.input_unit);
  return (
    <details
      class="stretches"
      open={open || threshold != null}
      onToggle={(event) => show(event.currentTarget.open)}
    >
      <summary>Dead band of the drive</summary>
      <form
        class="row wrap"
        onSubmit={(event) => {
          event.preventDefault();
          if (Number(written) > 0) set({ dead_band: null, dead_zone: null, [counts]: Number(written) });
        }}
      >
        <label class="row">
          <span class="soft">below</span>
          <input
            type="number"
            step="any"
            min="0"
            value={written}
            onInput={(event) => write(event.currentTarget.value)}
          />{' '}
          {unit} it counts as 0,
        </label>
        <label class="row">
          <span class="soft">above</span>
          <select value={counts} onChange={(event) => count(event.currentTarget.value as Counts)}>
            <option value="dead_band">as it is</option>
            <option value="dead_zone">by what exceeds it</option>
          </select>
        </label>
        <button type="submit" disabled={!(Number(written) > 0)}>
          Set it
        </button>
      </form>
      {threshold != null && (
        <p>
          A drive below {threshold} {unit} counts as 0, a larger one{' '}
          {zone != null ? 'by what exceeds it' : 'as it is'}{' '}
          <button type="button" class="link" onClick={() => set({ dead_band: null, dead_zone: null })}>
            clear
          </button>
        </p>
      )}
    </details>
  );
}
