// Formats and parses numbers: few digits, a common unit prefix, and small masses in grams. A typed number without a
// unit has the displayed unit. A text with a unit is left to the server, which knows all units of the language.

/** @type {Array<[number, string]>} */
const PREFIXES = [[1e9, "G"], [1e6, "M"], [1e3, "k"], [1, ""], [1e-3, "m"], [1e-6, "µ"], [1e-9, "n"], [1e-12, "p"]];
const SIMPLE = /^(m|s|Hz|N|W|J|Pa|g|N\/m|N s\/m|m\/s)$/;
const SHORT = new Set(["m", "s", "g"]);

// smaller values are shown as zero
const NOTHING = 1e-24;

// at most `digits` significant digits, without trailing zeros
export function plain(value, digits = 4) {
  if (!Number.isFinite(value)) return "–";
  const size = Math.abs(value);
  if (size < NOTHING) return "0";
  if (size !== 0 && (size < 1e-4 || size >= 1e7)) return value.toExponential(Math.min(2, digits - 1)).replace(/\.?0+e/, "e").replace("e+", "e");
  return String(+value.toPrecision(size >= 1000 ? Math.max(digits, 5) : digits));
}

// factor and name of the unit in which `value` is shown
export function shownUnit(value, unit) {
  let size = Math.abs(value);
  if (unit === "kg") {
    if (size >= 1 || size === 0) return [1, "kg"];
    const [factor, name] = shownUnit(size * 1000, "g");
    return [factor / 1000, name];
  }
  if (!SIMPLE.test(unit) || size === 0) return [1, unit];
  const low = SHORT.has(unit) ? 0.1 : 0.01;
  if (size >= low && size < 1e4) return [1, unit];
  for (const [factor, prefix] of PREFIXES) if (size >= factor * 0.9999) return [factor, prefix + unit];
  return [1, unit];
}

export function format(value, unit = "", digits = 4) {
  const [factor, name] = shownUnit(value, unit || "");
  const text = plain(value / factor, digits);
  return name ? text + " " + name : text;
}

// value to send for a typed text: a number in the unit of the protocol, or the text itself if it has a unit
export function typed(text, current, unit) {
  const clean = text.trim().replace(/[−–]/, "-");
  if (clean === "") return null;
  if (/^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i.test(clean)) return Number(clean) * shownUnit(current, unit || "")[0];
  return clean;
}

// maps a value to the slider position 0..1 and back: linear, logarithmic, or logarithmic above zero
export function scaleOf(low, high, value) {
  if (low > 0 && high / low >= 30) {
    const span = Math.log(high / low);
    return { log: true, place: v => Math.log(Math.max(v, low) / low) / span, value: p => low * Math.exp(p * span) };
  }
  if (low === 0 && value > 0 && high / value > 100) {
    const unit = value / 10, span = Math.log1p(high / unit);
    return { log: true, place: v => Math.log1p(Math.max(v, 0) / unit) / span, value: p => unit * Math.expm1(p * span) };
  }
  return { log: false, place: v => (v - low) / (high - low || 1), value: p => low + p * (high - low) };
}
