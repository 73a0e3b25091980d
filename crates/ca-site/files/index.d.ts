export interface Options {
  /** duration [s]; that of the model if it is left out */
  seconds?: number;
  /** name of the file of the model, in messages */
  file?: string;
  /** texts of the files from which the model takes parts, by name */
  files?: Record<string, string>;
  /** changed values, by name, such as { "string.f": "220 Hz" } */
  changes?: Record<string, string>;
}

export interface Rendered {
  /** a WAV file of 32-bit floats */
  wav: Uint8Array;
  /** [Hz] */
  rate: number;
  channels: number;
  /** samples in each channel */
  frames: number;
}

export interface Checked {
  /** the findings, in words */
  text: string;
  findings: unknown[];
  /** the proven stability, in one line */
  stability: string;
  masses: number;
  links: number;
}

export interface Mode {
  /** in continuous time [Hz] */
  free_hz: number;
  /** as the scheme plays it at this rate [Hz]; 0 if it does not oscillate */
  heard_hz: number;
  /** from `free_hz` to `heard_hz` */
  cents: number;
  /** time to decay by 60 dB [s]; null if it does not decay */
  t60_s: number | null;
  grows: boolean;
  /** values at the ports, by name [1/√kg] */
  ports: Record<string, number>;
}

export interface Modes {
  /** sound rate [Hz] */
  rate: number;
  /** lowest first */
  modes: Mode[];
  /** links that are not linear and so not included */
  left_out: { name: string; law: string }[];
  /** parts that `tune` can tune */
  parts: string[];
}

export interface TuneOptions extends Pick<Options, "file" | "files"> {
  /** gives the parts, or the cells of a bank, the degrees of a scale */
  scale?: "equal" | "just" | "pythagorean" | "harmonic";
  /** pitch of the first degree of the scale, such as "A3" or "220 Hz" */
  root?: string;
  /** pitch of the note A4 [Hz]; 440 if it is left out */
  a4?: number;
  /** mode of the part, from 1, the lowest, which is tuned if it is left out */
  mode?: number;
}

export interface Tuned {
  /** the text of the model with the new numbers */
  text: string;
  name: string;
  tuned: {
    part: string;
    wanted_hz: number;
    before_hz: number;
    heard_hz: number;
    off_cents: number;
    /** the number in the text */
    number: string;
  }[];
}

export interface AccuracyOptions extends Options {
  /** multiples of the sound rate; if they are left out, as many of 1, 2, 4 and 8 as do not take long */
  times?: number[];
  /** multiple of the sound rate for the reference */
  reference?: number;
  /** modules to compare; the outputs if they are left out */
  probes?: string[];
  /** relative RMS error for which the fastest row is wanted */
  error?: number;
  /** receives the numbers of finished steps and of all steps, often; `false` ends the measurement, which is then refused */
  progress?: (done: number, of: number) => boolean | void;
}

export interface AccuracyRow {
  method: string;
  /** multiple of the sound rate */
  times: number;
  /** relative RMS error of the signal, and of its spectrum; null if the row diverged */
  error: number | null;
  spectrum_error: number | null;
  /** error of the pitch of the strongest partial */
  cents: number | null;
  decay_db: number | null;
  /** energy that the scheme made, relative to the peak of the energy */
  made: number | null;
  /** run time of this module on this machine [ns] */
  ns_per_sample: number;
  real_time_factor: number;
  stability: string;
  /** no other row is both more exact and faster */
  front: boolean;
}

export interface Accuracy {
  name: string;
  /** sound rate [Hz] */
  rate: number;
  /** duration [s] */
  seconds: number;
  rows: AccuracyRow[];
  reference: {
    origin: "modes" | "rate" | "open";
    times: number | null;
    order: number | null;
    /** relative error of the reference */
    known: number;
    method: string;
    agrees: boolean | null;
    second: string | null;
    apart: number | null;
    /** description */
    words: string;
  };
  /** methods that the model cannot use */
  refused: { method: string; why: string }[];
  warned: { method: string; what: string }[];
  /** the fastest proven row within `error` */
  recommended: { method: string; times: number } | null;
  verdict: string | null;
  /** HTML page with plot and table */
  page: string;
}

/** Computes the modes of the linear part of a model. The promise is refused with the errors of the model. */
export function modes(text: string, options?: Omit<Options, "seconds">): Promise<Modes>;

/**
 * Tunes parts of a model, such as "low=A2", or one or several names of parts with a scale. Comments and blanks of the text
 * stay. The promise is refused with the reason if a pitch is not reached.
 */
export function tune(text: string, parts: string | string[], options?: TuneOptions): Promise<Tuned>;

/**
 * Measures error and run time of a model with several methods and multiples of its rate. It takes several seconds, and
 * blocks the thread. The promise is refused with the errors of the model.
 */
export function accuracy(text: string, options?: AccuracyOptions): Promise<Accuracy>;

/** Plays a model with its own gesture. The promise is refused with the errors of the model, in words. */
export function render(text: string, options?: Options): Promise<Rendered>;

/** Reports the findings about a model. The promise is refused with its errors. */
export function check(text: string, options?: Omit<Options, "seconds">): Promise<Checked>;

/** Packs a model for the address of a page: `play.html#model=…`. */
export function pack(text: string): Promise<string>;
