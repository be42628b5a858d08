// A figure with title, tools, legend and reading, for pointer, keyboard and screen reader.
import { useEffect, useLayoutEffect, useRef, useState } from 'preact/hooks';
import { Icon } from '../components/icon';
import { route } from '../route';
import { useSignal } from '../signal';
import { follow } from './drag';
import { Figure } from './figure';
import { reading } from './reading';
import { FORMS, save } from './save';
import type { Line, Spec, Tool, Zoom } from './spec';
import { magnified, setZoom, zoomOf } from './zoom';

const TOOLS: Record<Tool, string> = {
  zoom: 'Zoom: drag a box',
  pan: 'Pan: drag',
  mask: 'Mask a stretch: simulated, not scored',
  cut: 'Keep a stretch, cut the ends off',
};
const KEYS = 'Arrow keys move the reading, + and − zoom, 0 shows all.';

export function Plot({ spec }: { spec: Spec }) {
  useSignal(route);
  const holder = useRef<HTMLDivElement>(null);
  const figure = useRef<Figure | null>(null);
  const latest = useRef(spec);
  const tool = useRef<Tool>('zoom');
  const [chosen, choose] = useState<Tool>('zoom');
  const [index, read] = useState(-1);
  const view = zoomOf(spec.key);
  const viewText = JSON.stringify(view);
  latest.current = spec;
  tool.current = chosen;

  const zoom = (next: Zoom | null): void => setZoom(latest.current.key, next);

  useLayoutEffect(() => {
    if (!holder.current) return;
    const made = new Figure(holder.current, latest.current, zoomOf(latest.current.key));
    figure.current = made;
    const stop = watch(holder.current, made);
    return () => {
      stop();
      made.destroy();
      figure.current = null;
    };
  }, []);

  useLayoutEffect(() => {
    figure.current?.update(spec, view);
    figure.current?.resize();
  }, [spec, viewText]);

  const shape = [spec.lines.length, spec.x.log, spec.y.log, spec.x.hide].join();
  useEffect(() => {
    if (!figure.current) return;
    return follow(figure.current, { spec: () => latest.current, tool: () => tool.current, read, zoom });
  }, [shape]);

  const keys = (event: KeyboardEvent): void => {
    const now = figure.current;
    const leading = spec.lines[0];
    if (!now || !leading || event.ctrlKey || event.metaKey || event.altKey) return;
    const step = Math.max(1, Math.round(leading.x.length / (event.shiftKey ? 20 : 100)));
    const centre = index >= 0 ? Number(leading.x[index]) : (now.shown.x[0] + now.shown.x[1]) / 2;
    const acts: Record<string, () => void> = {
      ArrowRight: () => read(Math.min(leading.x.length - 1, Math.max(0, index) + step)),
      ArrowLeft: () => read(Math.max(0, index - step)),
      '+': () => zoom(magnified(now.shown, centre, 0.6, spec.flat)),
      '=': () => zoom(magnified(now.shown, centre, 0.6, spec.flat)),
      '-': () => zoom(magnified(now.shown, centre, 1 / 0.6, spec.flat)),
      '0': () => zoom(null),
    };
    const act = acts[event.key];
    if (!act) return;
    event.preventDefault();
    event.stopPropagation();
    act();
  };

  const tools = spec.tools ?? ['zoom'];
  const label = `${spec.title}. ${spec.description ?? ''} ${KEYS}`;
  return (
    <figure class="plot">
      <div class="pt">
        <h2 class="h3" title={spec.title}>
          {spec.title}
        </h2>
        <span class="sp" />
        <span class="tb" role="group" aria-label={`Tools of ${spec.title}`}>
          {tools.length > 0 &&
            tools.map((name) => (
              <button
                type="button"
                key={name}
                title={TOOLS[name]}
                aria-label={TOOLS[name]}
                aria-pressed={chosen === name}
                onClick={() => choose(name)}
              >
                <Icon name={name} />
              </button>
            ))}
          <button type="button" title="Show all (0)" aria-label="Show all" onClick={() => zoom(null)}>
            <Icon name="reset" />
          </button>
          <Save figure={() => figure.current} spec={spec} />
        </span>
      </div>
      <Legend spec={spec} />
      <div
        class="pc"
        ref={holder}
        tabIndex={0}
        role="img"
        aria-label={label}
        style={{ height: `${spec.height}px` }}
        onKeyDown={keys}
        onPointerLeave={() => read(-1)}
      >
        <Mark figure={figure.current} spec={spec} index={index} />
      </div>
    </figure>
  );
}

/** Redraws where width or theme changes. */
function watch(holder: HTMLElement, figure: Figure): () => void {
  const size = new ResizeObserver(() => figure.resize());
  size.observe(holder);
  const theme = new MutationObserver(() => figure.redraw());
  theme.observe(document.documentElement, { attributes: true, attributeFilter: ['data-theme'] });
  const scheme = matchMedia('(prefers-color-scheme: dark)');
  const redraw = (): void => figure.redraw();
  scheme.addEventListener('change', redraw);
  return () => {
    size.disconnect();
    theme.disconnect();
    scheme.removeEventListener('change', redraw);
  };
}

/** Reading above the frame and its place in it. */
function Mark({ figure, spec, index }: { figure: Figure | null; spec: Spec; index: number }) {
  const leading = spec.lines[0];
  const y = leading?.y[index];
  const at = figure && leading && y != null ? figure.pixels(Number(leading.x[index]), y) : null;
  const area = figure?.over;
  const inside = at && area && at.left >= 0 && at.left <= area.clientWidth;
  return (
    <>
      <span class="ro" aria-live="polite">
        {inside ? reading(spec, index) : ''}
      </span>
      {inside && (
        <i
          class={spec.loop ? 'at point' : 'at'}
          style={{
            left: `${area.offsetLeft + at.left}px`,
            top: `${area.offsetTop + (spec.loop ? at.top : 0)}px`,
            height: spec.loop ? undefined : `${area.clientHeight}px`,
          }}
        />
      )}
    </>
  );
}

function Save({ figure, spec }: { figure: () => Figure | null; spec: Spec }) {
  const [open, show] = useState(false);
  return (
    <span class="save" onKeyDown={(event) => event.key === 'Escape' && show(false)}>
      <button
        type="button"
        title="Save the figure"
        aria-label="Save the figure"
        aria-expanded={open}
        onClick={() => show(!open)}
      >
        <Icon name="down" />
      </button>
      {open && (
        <span class="menu">
          {FORMS.map((form) => (
            <button
              type="button"
              key={form}
              onClick={() => {
                const now = figure();
                if (now) void save(now, spec, form);
                show(false);
              }}
            >
              {form}
            </button>
          ))}
        </span>
      )}
    </span>
  );
}

function Legend({ spec }: { spec: Spec }) {
  const named = spec.lines.filter((line) => line.name);
  if (named.length === 0 && !spec.band) return null;
  return (
    <div class="lg">
      {named.map((line) => (
        <span key={line.name}>
          <Swatch line={line} />
          {line.name}
        </span>
      ))}
      {spec.band && (
        <span>
          <svg aria-hidden="true">
            <rect class="bdl" width="20" height="8" />
          </svg>
          {spec.band.name}
        </span>
      )}
    </div>
  );
}

export function Swatch({ line }: { line: Pick<Line, 'color' | 'width' | 'dash' | 'points' | 'filled'> }) {
  return (
    <svg class={`c-${line.color}`} aria-hidden="true">
      {line.points ? (
        <circle cx="10" cy="4" r="3" stroke-width="1.6" fill={line.filled?.(0) ? 'currentColor' : 'none'} />
      ) : (
        <line
          x1="0"
          x2="20"
          y1="4"
          y2="4"
          stroke-width={line.width ?? 1.5}
          stroke-dasharray={line.dash?.join(' ')}
        />
      )}
    </svg>
  );
}
