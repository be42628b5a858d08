// Controllers that follow the reference in a simulation: on the bench, or on the model of a measured device.
import { useState } from 'preact/hooks';
import { change, Refusal, type Complaint } from '../../api/client';
import { useResource } from '../../api/resource';
import type { Options, Tracked, TrackedController } from '../../api/types';
import { command } from '../../components/dock';
import { SaveAs } from '../../components/SaveAs';
import { SchemaForm } from '../../components/SchemaForm';
import { capital, Failure } from '../../components/words';
import { TableBox } from '../../components/window';
import { Working } from '../../components/Working';
import { prose, quantityText, significant } from '../../format';
import { Plot, Swatch } from '../../plot/Plot';
import type { Line, Spec } from '../../plot/spec';
import { asLine } from '../records/Curves';

export function Bench(props: {
  at: string;
  reference: unknown;
  device: string;
  /** Limits and what is known ahead, as for the drive. */
  inverse: {
    range: number[] | null;
    slew_per_s: number | null;
    bandwidth_hz: number | null;
    virgin_voltage: number | null;
    preview: number | null;
    predict_to_hz: number | null;
  };
  /** The model is one of the bench: its truth is known. Else the model itself is the plant. */
  simulated: boolean;
}) {
  const [tracked, keep] = useState<Tracked | null>(null);
  const [problem, complain] = useState<Complaint | null>(null);
  const [busy, mark] = useState(false);
  const [chosen, choose] = useState<string[]>([]);
  const [asked, ask] = useState<Record<string, unknown>>({});
  const offered = useResource<Options>('options').value;
  const track = (save?: string): Promise<Tracked> => {
    const { range, slew_per_s, bandwidth_hz, virgin_voltage, preview, predict_to_hz } = props.inverse;
    const limits = { range, slew_per_s, bandwidth_hz, virgin_v: virgin_voltage, preview, predict_to_hz };
    const given = { ...limits, ...asked };
    const options = Object.fromEntries(Object.entries(given).filter(([, value]) => value != null));
    const { reference, simulated } = props;
    return change<Tracked>('POST', `${props.at}/track`, { reference, options, on_model: !simulated, save });
  };
  const simulate = async (): Promise<void> => {
    mark(true);
    try {
      const answer = await track();
      command.value = answer.command;
      const ranked = [...answer.controllers].sort((a, b) => (a.rms ?? Infinity) - (b.rms ?? Infinity));
      keep({ ...answer, controllers: ranked });
      choose(ranked.slice(0, 1).map((controller) => controller.name));
      complain(null);
    } catch (error) {
      complain(error instanceof Refusal ? error.complaint : { what: String(error) });
    }
    mark(false);
  };
  if (!tracked) {
    return (
      <div class="card">
        <h2>Controllers, simulated</h2>
        <p class="soft gap">
          {props.simulated
            ? 'The prediction is of the model with itself. On the bench, whose truth lies outside every ' +
              'model class, the controllers show what a device may add.'
            : 'The device is not here, so that every controller runs on the model itself: this ranks ' +
              'them and shows their limits. What the device adds is what the records showed, and more.'}
        </p>
        {offered && (
          <details>
            <summary>Which controllers, margins, what is scored</summary>
            <div class="set twos">
              <SchemaForm
                schema={offered.track}
                root={offered.track}
                value={asked}
                change={ask}
                without={['range', 'slew_per_s', 'bandwidth_hz', 'virgin_v', 'preview', 'predict_to_hz']}
              />
            </div>
          </details>
        )}
        <button type="button" onClick={() => void simulate()} aria-disabled={busy}>
          {busy ? 'Simulating all controllers…' : 'Simulate the controllers'}
        </button>
        <Working at={`${props.at}/track`} what="Controllers" />
        {problem && <Failure problem={problem} />}
      </div>
    );
  }
  const toggle = (name: string): void =>
    choose(chosen.includes(name) ? chosen.filter((other) => other !== name) : [...chosen.slice(-2), name]);
  return (
    <div class="stack">
      <Controllers tracked={tracked} chosen={chosen} toggle={toggle} />
      <div class="row wrap">
        <button type="button" class="quiet" onClick={() => keep(null)}>
          Simulate others
        </button>
        <SaveAs
          stem="track"
          device={props.device}
          what="samples"
          label="Download the samples"
          ready={!busy}
          write={async (save) => (await track(save)).file}
        />
        <Working at={`${props.at}/track`} what="Controllers" />
      </div>
    </div>
  );
}

const STROKES: Pick<Line, 'color' | 'dash' | 'width'>[] = [
  { color: 'band', width: 1.8 },
  { color: 'residual', dash: [6, 2], width: 1.6 },
  { color: 'k6', dash: [2, 2], width: 1.8 },
];

function Controllers(props: { tracked: Tracked; chosen: string[]; toggle: (name: string) => void }) {
  const { tracked, chosen } = props;
  const shown = chosen
    .map((name) => tracked.controllers.find((controller) => controller.name === name))
    .filter((controller): controller is TrackedController => controller !== undefined);
  const unit = tracked.output_unit;
  const spec: Spec = {
    key: 'bench',
    title: 'Error of the chosen controllers',
    description: 'Reference minus displacement of the chosen controllers.',
    height: 216,
    flat: true,
    zero: true,
    x: { label: 'time (s)', unit: 's' },
    y: { label: `reference − y (${unit})`, unit },
    lines: shown.map((controller, i) => ({
      ...asLine(controller.curves.error, 'band', 1.5, controller.name),
      ...STROKES[i % STROKES.length],
    })),
  };
  return (
    <div class="stack">
      {shown.length > 0 && <Plot spec={spec} />}
      <TableBox label="Controllers">
        <table class="mid">
          <caption>
            Controllers <span class="tag sim">simulated</span>
          </caption>
          <thead>
            <tr>
              <th scope="col">Controller</th>
              <th scope="col" class="n">
                Error rms
              </th>
              <th scope="col" class="n">
                largest
              </th>
              <th scope="col" class="n">
                Gain <small>margin</small>
              </th>
            </tr>
          </thead>
          <tbody>
            {tracked.controllers.map((controller) => {
              const at = chosen.indexOf(controller.name);
              return (
                <tr key={controller.name} class={at >= 0 ? 'sel' : ''}>
                  <td title={controller.summary}>
                    <label class="row">
                      <input
                        type="checkbox"
                        checked={at >= 0}
                        onChange={() => props.toggle(controller.name)}
                      />
                      {controller.name}
                      {at >= 0 && (
                        <span class="lg">
                          <Swatch line={STROKES[at % STROKES.length] as Line} />
                        </span>
                      )}
                      {controller.samples_held_back > 0 && <span class="tag warn">at limit</span>}
                    </label>
                  </td>
                  {controller.runs_away ? (
                    <td colSpan={2} class="soft">
                      fails to follow
                    </td>
                  ) : (
                    <>
                      <td class="n">{controller.rms != null ? quantityText(controller.rms, unit) : '–'}</td>
                      <td class="n">{controller.max != null ? quantityText(controller.max, unit) : '–'}</td>
                    </>
                  )}
                  <td class="n">
                    {controller.gain_margin != null ? significant(controller.gain_margin, 2) : 'none'}
                  </td>
                </tr>
              );
            })}
          </tbody>
        </table>
        <p class="soft s">
          {capital(prose(tracked.plant))}. Scored from {significant(tracked.scored_s[0])} to{' '}
          {significant(tracked.scored_s[1])} s.
          {tracked.left_out.length > 0 ? ` Left out: ${tracked.left_out.join('; ')}.` : ''}
        </p>
      </TableBox>
    </div>
  );
}
