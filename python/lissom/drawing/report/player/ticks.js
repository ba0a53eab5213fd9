// Numbers on axes: where they stand and how they are written.

/** Ticks at steps of 1, 2 or 5 times a power of ten, about so many. */
export function ticks(low, high, count) {
  const rough = (high - low) / Math.max(count, 1);
  if (!(rough > 0) || !Number.isFinite(rough)) return [low];
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].find((factor) => factor * power >= rough * 0.999) * power;
  const found = [];
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; i++) found.push(i * step);
  return found;
}

/** Powers of ten from one exponent to another, about so many. */
export function decades(low, high, count) {
  const step = Math.max(1, Math.ceil((high - low) / Math.max(count, 1)));
  const found = [];
  for (let i = Math.ceil(low / step - 1e-9) * step; i <= high + 1e-9; i += step) found.push(i);
  return found;
}

/** The longest length of 1, 2 or 5 times a power of ten up to a limit. */
export function roundLength(most) {
  const power = 10 ** Math.floor(Math.log10(most));
  return [5, 2, 1].find((factor) => factor * power <= most * (1 + 1e-9)) * power;
}

const RAISED = "⁰¹²³⁴⁵⁶⁷⁸⁹";

export const power = (exponent) =>
  `10${exponent < 0 ? "⁻" : ""}${[...String(Math.abs(exponent))].map((digit) => RAISED[digit]).join("")}`;

/** A number with few digits, as short as it can be. */
export function shortly(value, digits = 3) {
  if (value === 0) return "0";
  if (!Number.isFinite(value)) return "–";
  const exponent = Math.floor(Math.log10(Math.abs(value)) + 1e-12);
  if (exponent < -3 || exponent > 5) {
    const factor = String(Number((value / 10 ** exponent).toPrecision(digits)));
    return `${factor.replace("-", "−")}·${power(exponent)}`;
  }
  return String(Number(value.toPrecision(digits))).replace("-", "−");
}

/** Labels of ticks, all with a common power of ten where they are large or small. */
export function labels(values) {
  const largest = Math.max(...values.map(Math.abs));
  if (!(largest > 0)) return { texts: values.map(() => "0"), factor: "" };
  const exponent = Math.floor(Math.log10(largest) + 1e-12);
  const isFar = exponent < -3 || exponent > 4;
  const unit = isFar ? 10 ** exponent : 1;
  const apart = values.length > 1 ? Math.abs(values[1] - values[0]) / unit : largest / unit;
  const places = Math.min(Math.max(0, Math.ceil(-Math.log10(apart) - 1e-6)), 12);
  const texts = values.map((value) => (value / unit).toFixed(places).replace(/^-(0(\.0*)?)$/, "$1").replace("-", "−"));
  return { texts, factor: isFar ? `×${power(exponent)}` : "" };
}
