// The field in which a reference is drawn, and its points as text for the keyboard.
import { useRef, useState } from 'preact/hooks';
import { short } from '../../format';
import type { Range } from '../../plot/spec';
import { read, written } from './drawn';

interface Props {
  points: Range[];
  unit: string;
  change: (points: Range[]) => void;
}

const [WIDTH, HEIGHT] = [640, 180];
/** Room around the points, as a share of their extent. */
const AIR = 0.25;

function fieldOf(points: Range[]): { low: number; high: number; end: number } {
  const values = points.map(([, value]) => value);
  const [low, high] = [Math.min(...values), Math.max(...values)];
  const air = (high - low || Math.abs(high) || 1) * AIR;
  return { low: low - air, high: high + air, end: Math.max(...points.map(([time]) => time)) * (1 + AIR) };
}

export function DrawnForm({ points, unit, change }: Props) {
  const [text, type] = useState<string | null>(null);
  const field = useRef<SVGSVGElement>(null);
  const { low, high, end } = fieldOf(points);
  const x = ([time]: Range): number => (time / end) * WIDTH;
  const y = ([, value]: Range): number => HEIGHT - ((value - low) / (high - low)) * HEIGHT;
  const add = (event: PointerEvent): void => {
    const bounds = field.current?.getBoundingClientRect();
    if (!bounds) return;
    const point: Range = [
      ((event.clientX - bounds.left) / bounds.width) * end,
      low + (1 - (event.clientY - bounds.top) / bounds.height) * (high - low),
    ];
    const others = points.filter(([time]) => Math.abs(time - point[0]) > end / 100);
    change([...others, point].sort((a, b) => a[0] - b[0]));
  };
  const wrong = text !== null && read(text) === null;
  return (
    <div class="grow stack tight">
      <svg
        class="pad"
        ref={field}
        viewBox={`0 0 ${WIDTH} ${HEIGHT}`}
        preserveAspectRatio="none"
        role="img"
        aria-label={`Drawn reference of ${points.length} points; the field beneath sets them by keys`}
        onPointerDown={add}
      >
        <path class="c-reference" d={`M${points.map((point) => `${x(point)} ${y(point)}`).join('L')}`} />
        {points.map((point) => (
          <path key={point[0]} class="c-reference dot" d={`M${x(point)} ${y(point)}h0`} />
        ))}
      </svg>
      <label class="f">
        <span class="soft">
          Points: time (s) and value ({unit}); a click adds one. The field: up to {short(end)} s, from{' '}
          {short(low)} to {short(high)} {unit}.
        </span>
        <input
          type="text"
          class="long mono"
          aria-invalid={wrong}
          value={text ?? written(points)}
          onInput={(event) => type(event.currentTarget.value)}
          onChange={(event) => {
            const next = read(event.currentTarget.value);
            if (next) {
              change(next);
              type(null);
            }
          }}
        />
      </label>
    </div>
  );
}
