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
}

/** Computes the modes of the linear part of a model. The promise is refused with the errors of the model. */
export function modes(text: string, options?: Omit<Options, "seconds">): Promise<Modes>;

/** Plays a model with its own gesture. The promise is refused with the errors of the model, in words. */
export function render(text: string, options?: Options): Promise<Rendered>;

/** Reports the findings about a model. The promise is refused with its errors. */
export function check(text: string, options?: Omit<Options, "seconds">): Promise<Checked>;

/** Packs a model for the address of a page: `play.html#model=…`. */
export function pack(text: string): Promise<string>;
