// Colours of the picture for a dark and a light background, in OKLCH so that equal steps look equal. There is a row for
// amounts (speed), one for signed displacements, and one for kinds. Resting parts have a quiet but visible colour.
// Moving parts stand out: bright on dark, and deep on light.

function srgb(l, c, h) {
  const r = h * Math.PI / 180, a = c * Math.cos(r), b = c * Math.sin(r);
  const p = (l + 0.3963377774 * a + 0.2158037573 * b) ** 3, q = (l - 0.1055613458 * a - 0.0638541728 * b) ** 3, s = (l - 0.0894841775 * a - 1.291485548 * b) ** 3;
  const linear = [4.0767416621 * p - 3.3077115913 * q + 0.2309699292 * s, -1.2684380046 * p + 2.6097574011 * q - 0.3413193965 * s, -0.0041960863 * p - 0.7034186147 * q + 1.707614701 * s];
  return linear.map(v => {
    const u = Math.min(1, Math.max(0, v));
    return Math.round(255 * (u <= 0.0031308 ? 12.92 * u : 1.055 * u ** (1 / 2.4) - 0.055));
  });
}

// interpolates between points [place, lightness, chroma, hue]
function ramp(points, t) {
  let k = 1;
  while (k < points.length - 1 && points[k][0] < t) k++;
  const [a, b] = [points[k - 1], points[k]], f = Math.min(1, Math.max(0, (t - a[0]) / (b[0] - a[0])));
  return srgb(...[1, 2, 3].map(i => a[i] + (b[i] - a[i]) * f));
}

const MAPS = {
  dark: {
    amount: [[0, 0.50, 0.075, 262], [0.3, 0.62, 0.125, 235], [0.6, 0.77, 0.13, 185], [0.82, 0.87, 0.15, 118], [1, 0.96, 0.1, 100]],
    signed: [[0, 0.82, 0.13, 215], [0.25, 0.66, 0.14, 250], [0.5, 0.5, 0.02, 270], [0.75, 0.68, 0.15, 45], [1, 0.85, 0.13, 75]],
    kinds: [0.76, 0.12],
  },
  light: {
    amount: [[0, 0.66, 0.055, 255], [0.3, 0.57, 0.12, 262], [0.6, 0.5, 0.2, 305], [0.82, 0.52, 0.22, 355], [1, 0.5, 0.2, 390]],
    signed: [[0, 0.38, 0.14, 255], [0.25, 0.55, 0.14, 245], [0.5, 0.68, 0.015, 260], [0.75, 0.58, 0.17, 40], [1, 0.42, 0.14, 30]],
    kinds: [0.54, 0.15],
  },
};
const HUES = [250, 50, 155, 330, 95, 200, 20, 290, 125, 225];

export const kindColour = (theme, i) => {
  const [l, c] = MAPS[theme].kinds;
  return srgb(l, c, HUES[i % HUES.length]);
};

// 256 × 3 texels
export function maps(theme) {
  const out = new Uint8Array(256 * 3 * 4), m = MAPS[theme];
  for (let i = 0; i < 256; i++) {
    const rows = [ramp(m.amount, i / 255), ramp(m.signed, i / 255), kindColour(theme, i)];
    rows.forEach((rgb, row) => out.set([...rgb, 255], 4 * (256 * row + i)));
  }
  return out;
}

// draws one row as an image for the legend
export function legend(canvas, theme, row) {
  const texels = maps(theme), image = new ImageData(256, 1);
  image.data.set(texels.subarray(1024 * row, 1024 * (row + 1)));
  canvas.width = 256; canvas.height = 1;
  canvas.getContext("2d").putImageData(image, 0, 0);
}
