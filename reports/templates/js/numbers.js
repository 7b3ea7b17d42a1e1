// Numbers as text: few digits, powers of ten as 2.31·10⁻¹¹, SI prefixes, real minus signs.

export const MINUS = "−";
const SMALL = { "-": "⁻", 0: "⁰", 1: "¹", 2: "²", 3: "³", 4: "⁴", 5: "⁵", 6: "⁶", 7: "⁷", 8: "⁸", 9: "⁹" };
const PREFIXES = { "-18": "a", "-15": "f", "-12": "p", "-9": "n", "-6": "µ", "-3": "m", 0: "", 3: "k", 6: "M", 9: "G" };
export const THIN = "\u202f";

/**
 * Whether a value is a number that is neither infinite nor NaN.
 * @param {number | null | undefined} value
 * @returns {value is number}
 */
export function finite(value) {
  return Number.isFinite(value);
}

/**
 * Whether a value is a finite number above zero, which a logarithmic axis can show.
 * @param {number | null | undefined} value
 * @returns {value is number}
 */
export function positive(value) {
  return finite(value) && value > 0;
}

/** A number with this many significant digits; plain from a thousandth to ten thousand, else a power of ten. */
export function figure(value, digits = 3) {
  if (value === null || value === undefined) return "";
  if (Number.isNaN(value)) return "NaN";
  if (!Number.isFinite(value)) return value > 0 ? "∞" : `${MINUS}∞`;
  if (value === 0) return "0";
  const [mantissa, exponent] = value.toExponential(digits - 1).split("e");
  const power = Number(exponent);
  const text =
    power >= -3 && power < 4
      ? Number(`${mantissa}e${power}`).toFixed(Math.max(digits - 1 - power, 0))
      : `${mantissa}·10${superscript(power)}`;
  return text.replace("-", MINUS);
}

/** A number with this many decimals; zero has no sign. */
export function fixed(value, decimals) {
  return (Number(value.toFixed(decimals)) || 0).toFixed(decimals).replace("-", MINUS);
}

export function superscript(power) {
  return [...String(power)].map((sign) => SMALL[sign]).join("");
}

/** A quantity with the prefix that leaves one to three digits before the point: 0.0118 m is 12 mm. */
export function si(value, unit, digits = 2) {
  if (!Number.isFinite(value)) return figure(value);
  if (value === 0) return `0${THIN}${unit}`;
  const rounded = Number(value.toPrecision(digits));
  const power = Math.min(9, Math.floor(Math.log10(Math.abs(rounded)) / 3 + 1e-9) * 3);
  if (power < -18) return `${figure(value, digits)}${THIN}${unit}`;
  if (power === 9 && Math.abs(rounded) >= 1e12) return `${figure(value, digits)}${THIN}${unit}`;
  // No kilometres: an error of 5 km is 5000 m.
  const shown = unit === "m" && power > 0 ? 0 : power;
  if (unit === "m" && Math.abs(rounded) >= 1e4) return `${figure(value, digits)}${THIN}m`;
  const scaled = rounded / 10 ** shown;
  const decimals = Math.max(0, digits - 1 - Math.floor(Math.log10(Math.abs(scaled)) + 1e-9));
  return `${scaled.toFixed(decimals)}${THIN}${PREFIXES[shown]}${unit}`.replace("-", MINUS);
}

const ROW_UNITS = { m: 1, mm: 1e-3, "µm": 1e-6, nm: 1e-9, pm: 1e-12, fm: 1e-15 };

/** The unit in which the middle of some lengths [m] has one to three digits before the point. */
export function unitOf(lengths) {
  const sorted = lengths.filter((value) => value > 0 && Number.isFinite(value)).sort((a, b) => a - b);
  const middle = sorted[Math.floor((sorted.length - 1) / 2)] ?? 1;
  return Object.keys(ROW_UNITS).find((unit) => middle >= ROW_UNITS[unit]) ?? "fm";
}

/** A length as a plain number of that unit, two digits; as 3e5 where it has too many zeros. */
export function inUnit(value, unit) {
  if (!Number.isFinite(value)) return figure(value);
  const [mantissa, power] = (value / ROW_UNITS[unit]).toExponential(1).split("e").map(Number);
  if (value === 0 || (power >= -2 && power < 4)) return String(Number(`${mantissa}e${power}`));
  return `${Math.round(mantissa)}e${power}`.replace("-", MINUS);
}

/** A length that the reader chose, with its prefix: 0.001 is 1 mm. */
export function chosen(value, unit) {
  const digits = value.toExponential().split("e")[0].replace(/[-.]/g, "").length;
  return si(value, unit, Math.max(1, digits));
}

/** A number that a person chose, such as a time or a step, as it was written. */
export function given(value) {
  const [mantissa, power] = Number(value.toPrecision(12)).toExponential().split("e").map(Number);
  const text = power >= -3 || value === 0 ? String(Number(value.toPrecision(12))) : `${mantissa === 1 ? "" : `${mantissa}·`}10${superscript(power)}`;
  return text.replace("-", MINUS);
}

export function listed(names) {
  return names.length > 1 ? `${names.slice(0, -1).join(", ")} and ${names.at(-1)}` : (names[0] ?? "");
}

export function counted(count, noun) {
  return count === 1 ? `1 ${noun}` : `${count} ${noun}s`;
}

/** The ends of an interval. */
export function interval(low, high) {
  return low === null || low === undefined ? "" : `${figure(low)} to ${figure(high)}`;
}

/** A ratio: ×2.3. */
export function times(ratio) {
  if (ratio === null || ratio === undefined) return "";
  return `×${THIN}${ratio >= 100 ? figure(ratio, 3) : ratio.toPrecision(ratio >= 10 ? 3 : 2)}`;
}
