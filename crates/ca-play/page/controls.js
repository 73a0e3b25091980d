// Sliders of live parameters and ports.
//
// Decides that a slider is a position between 0 and 1, logarithmic where a range spans decades, and that the field beside
// it takes whatever the model takes, units too; who double-clicks gets the value at load.

const STEPS = 1000;

/** A row: name, field, slider, words. `send` gets a number or a text and promises an answer. */
export function slider({ name, value, min, max, unit, doc }, send, refused) {
  const low = min ?? Math.min(0, 2 * value), high = max ?? Math.max(1, 2 * value);
  const decades = low > 0 && high / low > 100;
  const position = (v) => (decades ? Math.log(v / low) / Math.log(high / low) : (v - low) / (high - low)) * STEPS;
  const number = (p) => (decades ? low * Math.pow(high / low, p / STEPS) : low + ((high - low) * p) / STEPS);
  const row = document.createElement("div");
  row.className = "row";
  const label = document.createElement("label");
  const field = document.createElement("input");
  const range = document.createElement("input");
  label.textContent = name;
  label.htmlFor = range.id = `param-${name}`;
  field.type = "text";
  field.setAttribute("aria-label", `${name}, typed`);
  Object.assign(range, { type: "range", min: 0, max: STEPS, step: 1 });
  row.append(label, field, range);
  if (doc) {
    const words = document.createElement("small");
    words.textContent = doc;
    row.append(words);
  }
  const show = (v) => {
    if (document.activeElement !== field) field.value = `${tidy(v)}${unit ? " " + unit : ""}`;
    if (!row.moving) range.value = position(Math.min(high, Math.max(low, v)));
    range.setAttribute("aria-valuetext", field.value);
  };
  const set = async (v) => {
    const answer = await send(v);
    if (!answer.ok) refused(answer.text);
  };
  range.oninput = () => {
    const v = number(Number(range.value));
    field.value = `${tidy(v)}${unit ? " " + unit : ""}`;
    set(v);
  };
  range.onpointerdown = () => (row.moving = true);
  range.onpointerup = range.onpointercancel = () => (row.moving = false);
  range.ondblclick = () => set(value).then(() => show(value));
  field.onchange = () => {
    set(field.value.trim());
    field.blur();
  };
  show(value);
  return { row, show };
}

export function tidy(v) {
  if (v === 0) return "0";
  const size = Math.abs(v);
  return size >= 1e5 || size < 1e-3 ? v.toExponential(3).replace(/\.?0+e/, "e").replace("e+", "e") : String(Number(v.toPrecision(4)));
}
