// Answers of the server, as far as the page reads them; the whole is in `api/v1/openapi.json`.

export interface Problem {
  what: string;
  where?: string;
  around?: { number: number; text: string; here: boolean }[];
  do?: string;
}

export interface Command {
  shell: string;
  python: string;
}

export interface Workspace {
  folder: string;
  program: string;
  devices: string[];
  change: number;
  max_upload_bytes: number;
  examples: { name: string; title: string; open: boolean }[];
  trash: { token: string; id: string; deleted: string }[];
}

export type Role = 'auto' | 'quasi-static' | 'dynamic' | 'validate' | 'reference' | 'unused';

export interface RecordSettings {
  role: Role;
  continues: string | null;
  time: string | null;
  input: string | null;
  output: string | null;
  rate: string | null;
  sample_rate_hz: number | null;
  scales: string[];
  dead_band: number | null;
  dead_zone: number | null;
  from_s: number | null;
  to_s: number | null;
  masks: [number, number][];
}

export interface RecordEntry {
  id: string;
  device: string;
  bytes: number;
  modified: string;
  samples: number;
  duration_s: number | null;
  rate_hz: number | null;
  segments: number;
  input: string | null;
  input_unit: string;
  output: string | null;
  output_unit: string;
  /** Kind of model that its quantities call for. */
  usual_kind: string | null;
  settings: RecordSettings;
  glyph: [number, number][];
  warning: string | null;
  error: Problem | null;
  /** Drive and output move, so that something can be identified. */
  usable: boolean;
  simulated: boolean;
  /** The file is being read for the first time. */
  reading?: boolean;
}

export interface Channel {
  name: string;
  unit: string;
  low: number;
  high: number;
  saturated_low_samples: number;
  saturated_high_samples: number;
  step: number | null;
}

export interface Drive {
  kind: string;
  low_hz: number | null;
  high_hz: number | null;
}

export interface Inspection {
  samples: number;
  masked_samples: number;
  sample_rate_hz: number | null;
  jitter_samples: number | null;
  duration_s: number | null;
  input: Channel;
  output: Channel;
  drive: Drive;
  periods: { count: number; settling: number } | null;
  noise_floor_rms: number | null;
  noise_floor_method: string | null;
  drift_per_s: number | null;
  loop: {
    stroke: number;
    opening: number;
    opening_percent_of_stroke: number;
    sense: string;
    butterfly: boolean;
  } | null;
  segments?: Segment[];
  findings: (Finding & { warning: boolean })[];
}

export interface Segment {
  start_s: number;
  duration_s: number;
  sample_rate_hz: number;
  drive: Drive;
}

export interface Prospects {
  statements: { topic: string; determined: boolean | null; text: string }[];
  measure_next: string | null;
}

export interface Finding {
  kind: 'verdict' | 'advice' | 'warning';
  topic: string;
  text: string;
  advice?: unknown;
}

export interface RecordDetail extends RecordEntry {
  columns: {
    path: string;
    shape: number[];
    unit: string | null;
    kind: string;
    used_as: 'input' | 'output' | 'time' | 'rate' | null;
  }[];
  inspection: Inspection | null;
  gaps: { from_s: number; to_s: number }[];
  notes: Finding[];
  prospects: Prospects | null;
  command: Command;
}

export interface Together {
  prospects: Prospects;
  roles: string[];
  command: Command;
}

export interface CurveAxis {
  name: string;
  unit: string;
  low: number;
  high: number;
}

export interface Curve {
  x: number[];
  y: number[];
  breaks: number[];
  across: CurveAxis;
  up: CurveAxis;
  samples: number;
  shown: string;
}

export interface Choice {
  name: string;
  summary: string;
  value: unknown;
}

export interface Options {
  task: Schema;
  defaults: Record<string, unknown>[];
  choices: { option: string; choices: Choice[] }[];
  structures: Choice[];
  truth: Schema;
  truth_default: Record<string, unknown>;
  plan: Schema;
  plan_default: Record<string, unknown>;
  drive: Schema;
  track: Schema;
  forms: {
    name: string;
    summary: string;
    contents: string;
    has_single_precision: boolean;
    has_controllers: boolean;
  }[];
  operations: { name: string; schema: Schema; usual: Record<string, unknown> }[];
}

/** What an operation found and wrote. */
export interface Outcome {
  sentences: string[];
  tables: { title: string; columns: string[]; rows: string[][] }[];
  figures: {
    title: string;
    series: { name: string; curve: Curve }[];
    log_across: boolean;
    log_up: boolean;
  }[];
  files: string[];
  command: Command;
}

/** JSON schema, as far as forms are made from it. */
export interface Schema {
  title?: string;
  description?: string;
  type?: string | string[];
  enum?: unknown[];
  const?: unknown;
  oneOf?: Schema[];
  anyOf?: Schema[];
  allOf?: Schema[];
  properties?: Record<string, Schema>;
  items?: Schema;
  minimum?: number;
  maximum?: number;
  maxItems?: number;
  default?: unknown;
  $ref?: string;
  $defs?: Record<string, Schema>;
}

export type JobState = 'waiting' | 'running' | 'done' | 'stopped' | 'failed' | 'interrupted';

export type JobRequest =
  | {
      kind: 'identify';
      records: string[];
      task?: unknown;
      structure?: string;
      start?: string;
      model?: string;
      inputs?: string[];
      outputs?: string[];
      report?: boolean;
    }
  | {
      kind: 'compare';
      records: string[];
      candidates?: string[];
      quick?: boolean;
      time_limit_s?: number | null;
      inputs?: string[];
      outputs?: string[];
      report?: string;
    };

export interface AxesComparison {
  records: string[];
  output_unit: string;
  preferred: string | null;
  best: string | null;
  folds: string[][];
  candidates: {
    name: string;
    parameters: number;
    modes: number;
    error: number | null;
    error_std_error: number | null;
    above_best: number | null;
    above_best_std_error: number | null;
    as_good_as_best: boolean | null;
    training_rmse: number | null;
    fold_errors: (number | null)[];
    failures: string[];
  }[];
  notes: string[];
  interrupted: boolean;
}

export interface Stage {
  name: string;
  from_s: number;
  cost: number | null;
}

export interface Job {
  id: number;
  request: JobRequest;
  name: string;
  state: JobState;
  revision: number;
  /** Names of stages in their usual order; the name of an entered one begins with one of them. */
  planned?: string[];
  stages: Stage[];
  fraction: number;
  cost: number | null;
  unit: string;
  elapsed_s: number;
  left_s: number | null;
  ahead: number;
  command: Command;
  warning?: string | null;
  created: string;
  started: string | null;
  ended: string | null;
  resumable: boolean;
  result: {
    models: string[];
    reports: string[];
    /** Structures that a comparison has finished so far, in the order of their error. */
    candidates?: Candidate[];
    comparison: Comparison | null;
    /** Of structures of several axes. */
    axes_comparison?: AxesComparison | null;
  };
  error: Problem | null;
}

export interface CostPoint {
  time_s: number;
  cost: number;
  stage: number;
}

export interface LiveLoop {
  record: string;
  stage: number;
  model: Curve;
  residual: Curve;
  rmse: number;
  residual_axis: CurveAxis;
}

export interface Live {
  job: Job;
  costs: CostPoint[];
  measured: Curve | null;
  latest: LiveLoop | null;
}

export interface LiveUpdate {
  job: number;
  fraction: number;
  left_s: number | null;
  stage: string;
  cost: CostPoint | null;
  latest: LiveLoop | null;
}

export interface RequestProgress {
  request: string;
  stage: string;
  fraction: number;
  left_s: number | null;
}

export interface Candidate {
  name: string;
  parameters: number;
  error: number | null;
  error_std_error: number | null;
  above_best: number | null;
  above_best_std_error: number | null;
  as_good_as_best: boolean | null;
  training_rmse: number | null;
  nanoseconds_per_sample: number | null;
  not_realised_because: string | null;
  invertible: string | null;
  fold_errors: (number | null)[];
  failures: string[];
  hopeless: boolean;
}

export interface Comparison {
  records: string[];
  output_unit: string;
  preferred: string | null;
  best: string | null;
  noise_floor: number;
  folds: { left_out: string; content: string; whole_records: boolean }[];
  candidates: Candidate[];
  notes: string[];
  interrupted: boolean;
}

export interface Score {
  record: string;
  unit: string;
  samples: number;
  rmse: number;
  max_abs_error: number;
  rmse_percent_of_stroke: number | null;
  max_percent_of_stroke: number | null;
  fit_percent: number | null;
  offset: number | null;
}

export interface ModelEntry {
  id: string;
  device: string;
  name: string;
  bytes: number;
  modified: string;
  kind: string | null;
  hysteresis: string | null;
  dynamics: string | null;
  unit: string;
  input_unit: string;
  records: string[];
  made: string | null;
  command: string | null;
  scores: Score[];
  simulated: boolean;
  interrupted: boolean;
  error: Problem | null;
}

export interface ParameterRow {
  place: string | null;
  name: string;
  value: number;
  text: string;
  unit: string;
  std_error: number | null;
  std_error_text: string | null;
  interval: { low: number | null; high: number | null } | null;
  held: boolean;
  at_limit: boolean;
}

export interface ModelDetail extends ModelEntry {
  parameters: ParameterRow[];
  findings: Finding[];
  treatment: string[];
  valid_range: string | null;
  drive_range: [number, number] | null;
  /** Correcting the model by its predicted misfit pays. */
  correctable: boolean;
  sample_rate_hz: number | null;
  file: unknown;
}

export interface ModelCurves {
  record: string;
  view: 'loop' | 'time' | 'residual' | 'residual-loop';
  series: { name: string; curve: Curve }[];
  scores: Score;
  fitted: boolean;
  remarks: string[];
}

export interface Judged {
  record: string;
  score: Score | null;
  verdict: string | null;
  remarks: string[];
  in_band_percent: number | null;
  simulated: boolean;
  error: Problem | null;
}

export interface Scored {
  records: Judged[];
  definitions: { name: string; text: string }[];
  command: Command;
}

export interface GainPhase {
  gain: number;
  phase_deg: number;
  gain_std_error: number | null;
  phase_std_error_deg: number | null;
}

export interface Responses {
  record: string;
  unit: string;
  rows: { frequency_hz: number; measured: GainPhase; model: GainPhase }[];
}

export interface Preview {
  files: { name: string; bytes: number; text: string | null }[];
  states: number | null;
  error: number | null;
  findings: Finding[];
  command: Command;
}

export interface Followed {
  reference: Curve;
  drive: Curve;
  error: Curve;
  input_unit: string;
  output_unit: string;
  samples: number;
  sample_rate_hz: number;
  rest: number | null;
  drive_low: number;
  drive_high: number;
  samples_at_range: number;
  samples_at_slew: number;
  preview_samples: number | null;
  predicted_rms_error: number;
  predicted_max_error: number;
  predicted_rms_percent_of_stroke: number;
  band: number | null;
  band_of_measurement: number | null;
  expected_rms_error: number | null;
  shown: Score[];
  findings: Finding[];
  remarks: string[];
  file: string | null;
  command: Command;
}

export interface TrackedController {
  name: string;
  summary: string;
  rms: number | null;
  max: number | null;
  rms_percent_of_stroke: number | null;
  runs_away: boolean;
  bandwidth_hz: number | null;
  gain_margin: number | null;
  phase_margin_deg: number | null;
  samples_held_back: number;
  curves: { drive: Curve; error: Curve };
}

export interface Tracked {
  plant: string;
  output_unit: string;
  sample_rate_hz: number;
  scored_s: [number, number];
  controllers: TrackedController[];
  left_out: string[];
  file: string | null;
  command: Command;
}

export interface History {
  jobs: Job[];
  shell: string;
  python: string;
}

export interface ReportEntry {
  id: string;
  device: string;
  bytes: number;
  modified: string;
}
