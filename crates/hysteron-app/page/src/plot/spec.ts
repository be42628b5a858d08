// What a figure shows; how it is drawn is the business of figure.ts (canvas) and svg.ts (files).

export type Color =
  'measured' | 'model' | 'residual' | 'drive' | 'reference' | 'band' | 'k6' | 'k4' | 'rule2';
export type Range = [number, number];

export interface Axis {
  label: string;
  unit: string;
  log?: boolean;
  /** Whole range of the axis; without it that of the data. */
  range?: Range;
  /** No numbers and no label: the figure below has the same axis. */
  hide?: boolean;
}

export interface Line {
  /** In the legend and in the reading; a line without a name is in neither. */
  name?: string;
  color: Color;
  x: ArrayLike<number>;
  y: ArrayLike<number | null>;
  /** Indices at which a new piece begins: no line leads there. */
  breaks?: number[];
  width?: number;
  dash?: number[];
  /** Radius of a point at each value, instead of a line. */
  points?: number;
  filled?: (index: number) => boolean;
  /** Half height of the error bar of each point. */
  errors?: ArrayLike<number | null>;
}

export interface Band {
  name: string;
  x: ArrayLike<number>;
  low: ArrayLike<number>;
  high: ArrayLike<number>;
}

export type Tool = 'zoom' | 'pan' | 'mask' | 'cut';

export interface Spec {
  /** Name of the zoom in the URL. */
  key: string;
  title: string;
  /** For those who do not see the figure. */
  description?: string;
  height: number;
  x: Axis;
  y: Axis;
  lines: Line[];
  band?: Band;
  /** Output over drive: a path, not a function of x; read by the nearest point of the plane. */
  loop?: boolean;
  /** Zoomed across alone; upwards it fits itself to what is shown. */
  flat?: boolean;
  /** A line at y = 0. */
  zero?: boolean;
  masks?: Range[];
  stretches?: { from: number; to: number; label?: string }[];
  levels?: { y: number; label?: string }[];
  marks?: { x: number; y: number; text: string }[];
  /** The axes stay as they are while this stays. */
  hold?: string;
  tools?: Tool[];
  /** What mask and cut tell. */
  chosen?: (tool: 'mask' | 'cut', from: number, to: number) => void;
}

export interface View {
  x: Range;
  y: Range;
}

/** What is chosen of the whole view. */
export interface Zoom {
  x: Range;
  y?: Range;
}
