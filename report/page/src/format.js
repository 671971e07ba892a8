// Numbers and units for people.

export function number(value, digits = 3) {
  if (value === null || value === undefined || Number.isNaN(value)) return "–";
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size >= 1e6 || size < 1e-4) {
    const power = Math.floor(Math.log10(size));
    return `${(value / 10 ** power).toPrecision(digits)}·10${superscript(power)}`;
  }
  if (size >= Math.min(10 ** digits, 1e4)) return Math.round(value).toLocaleString("en");
  return String(Number(value.toPrecision(digits)));
}

function superscript(value) {
  return [...String(value)].map((c) => (c === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[Number(c)])).join("");
}

export function seconds(value) {
  if (value === null || value === undefined || Number.isNaN(value)) return "–";
  if (value < 1e-3) return `${number(1e6 * value, 2)} µs`;
  if (value < 1) return `${number(1e3 * value, 3)} ms`;
  if (value < 100) return `${number(value, 3)} s`;
  const [whole, minutes] = [Math.round(value), Math.round(value / 60)];
  if (whole < 6000) return `${Math.floor(whole / 60)} min ${whole % 60} s`.replace(/ 0 s$/, "");
  return `${Math.floor(minutes / 60)} h ${minutes % 60} min`;
}

export function bytes(value) {
  const units = ["B", "KiB", "MiB", "GiB", "TiB"];
  let unit = 0;
  while (value >= 1000 && unit < units.length - 1) {
    value /= 1024;
    ++unit;
  }
  return `${number(value, 3)} ${units[unit]}`;
}

export function percent(value, digits = 3) {
  if (value === null || value === undefined || Number.isNaN(value)) return "–";
  return `${number(100 * value, digits)} %`;
}

// Where figures come from: files, and the command and the machine that made them.
export function source(made, files) {
  if (!made) return files;
  const ranks = made.ranks > 1 ? ` (${made.ranks} ranks)` : "";
  return `${files} · ${made.command}${ranks}, Carillon ${made.carillon}, ${made.processor}, ${made.date}`;
}

export function hertz(value) {
  return value >= 1000 ? `${number(value / 1000, 4)} kHz` : `${number(value, 4)} Hz`;
}

export function count(value, singular, plural = `${singular}s`) {
  return `${value.toLocaleString("en")} ${value === 1 ? singular : plural}`;
}
