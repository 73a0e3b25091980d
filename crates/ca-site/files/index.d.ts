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

/** Plays a model with its own gesture. The promise is refused with the errors of the model, in words. */
export function render(text: string, options?: Options): Promise<Rendered>;

/** Reports the findings about a model. The promise is refused with its errors. */
export function check(text: string, options?: Omit<Options, "seconds">): Promise<Checked>;

/** Packs a model for the address of a page: `play.html#model=…`. */
export function pack(text: string): Promise<string>;
