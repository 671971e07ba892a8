import { html } from "htl";

// A slider over the logarithm of a positive value. moved(value) while it moves, changed(value) after it has.
export function slider({ label, low, high, value, format, moved = () => {}, changed = () => {} }) {
  // Zero, and what lies beyond the ends, stands at the nearer end until it is moved.
  const place = Math.min(1, Math.max(0, Math.log(Math.max(value, low) / low) / Math.log(high / low)));
  const shown = html`<output>${format(value)}</output>`;
  const input = html`<input type="range" min="0" max="1" step="any" value=${place} aria-valuetext=${format(value)}>`;
  const read = () => low * (high / low) ** Number(input.value);
  input.oninput = () => {
    shown.textContent = format(read());
    input.setAttribute("aria-valuetext", format(read()));
    moved(read());
  };
  input.onchange = () => changed(read());
  return html`<label>${label} ${shown}${input}</label>`;
}
