// Mask and cut by numbers: what the figure does by dragging.
import { useState } from 'preact/hooks';
import type { RecordDetail } from '../../api/types';
import { seconds } from '../../format';
import { settings } from './roles';

export function Stretches({ record }: { record: RecordDetail }) {
  const [from, setFrom] = useState('');
  const [to, setTo] = useState('');
  // What was opened stays open when the last mask is cleared.
  const [open, show] = useState(record.settings.masks.length > 0);
  const { masks, from_s: first, to_s: last } = record.settings;
  const known = from !== '' && to !== '' && Number(from) < Number(to);
  const cut = first != null || last != null;
  return (
    <details
      class="stretches"
      open={open || masks.length > 0 || cut}
      onToggle={(event) => show(event.currentTarget.open)}
    >
      <summary>Mask and cut</summary>
      <form class="row wrap" onSubmit={(event) => event.preventDefault()}>
        <label class="row">
          <span class="soft">from</span>
          <input
            type="number"
            step="any"
            value={from}
            onInput={(event) => setFrom(event.currentTarget.value)}
          />
        </label>
        <label class="row">
          <span class="soft">to</span>
          <input
            type="number"
            step="any"
            value={to}
            onInput={(event) => setTo(event.currentTarget.value)}
          />{' '}
          s
        </label>
        <button
          type="button"
          disabled={!known}
          onClick={() => void settings(record.id, { masks: [...masks, [Number(from), Number(to)]] })}
        >
          Mask it
        </button>
        <button
          type="button"
          disabled={!known}
          onClick={() => void settings(record.id, { from_s: Number(from), to_s: Number(to) })}
        >
          Keep it alone
        </button>
      </form>
      <ul class="plain">
        {masks.map(([a, b]) => (
          <li key={`${a} ${b}`}>
            masked from {seconds(a)} to {seconds(b)}: simulated, not scored{' '}
            <button
              type="button"
              class="link"
              onClick={() =>
                void settings(record.id, { masks: masks.filter((mask) => mask[0] !== a || mask[1] !== b) })
              }
            >
              clear
            </button>
          </li>
        ))}
        {cut && (
          <li>
            kept{first != null ? ` from ${seconds(first)}` : ''}
            {last != null ? ` to ${seconds(last)}` : ''}{' '}
            <button
              type="button"
              class="link"
              onClick={() => void settings(record.id, { from_s: null, to_s: null })}
            >
              show the whole file
            </button>
          </li>
        )}
      </ul>
    </details>
  );
}
