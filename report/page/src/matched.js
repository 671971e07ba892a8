import { html } from "htl";

import { hertz, number, seconds } from "./format.js";
import { table } from "./table.js";

const cents = (from, to) => 1200 * Math.log2(to / from);

// Pairs [a, b] of modes, ascending: of equal number, or those of which each is the other's nearest in pitch.
// a, b: frequencies [Hz], ascending.
export function matched(a, b, byNumber) {
  if (byNumber) return Array.from({ length: Math.min(a.length, b.length) }, (_, mode) => [mode, mode]);
  const nearest = (from, to) => from.map((one) => to.reduce((best, other, i) => (Math.abs(cents(one, other)) < Math.abs(cents(one, to[best])) ? i : best), 0));
  const [ofA, ofB] = [nearest(a, b), nearest(b, a)];
  return ofA.map((other, mode) => [mode, other]).filter(([mode, other]) => ofB[other] === mode);
}

// The modes of two objects beside each other. one, other: {name, modes: [{hertz, cents, t60}]}; show([a, b])
// when a row is chosen, null for what has no partner.
export function modesTable(one, other, byNumber, show) {
  const hertzOf = ({ modes }) => modes.map((mode) => mode.hertz);
  const pairs = matched(hertzOf(one), hertzOf(other), byNumber);
  const [inA, inB] = [0, 1].map((side) => new Set(pairs.map((pair) => pair[side])));
  const alone = (modes, taken) => modes.map((_, mode) => mode).filter((mode) => !taken.has(mode));
  const rows = [
    ...pairs,
    ...alone(one.modes, inA).map((mode) => [mode, null]),
    ...alone(other.modes, inB).map((mode) => [null, mode]),
  ].map(([a, b]) => ({ a, b, left: one.modes[a], right: other.modes[b] }));
  rows.sort((x, y) => (x.left ?? x.right).hertz - (y.left ?? y.right).hertz);
  const button = (row, mode, frequency) => html`<button type="button" class="plain" onclick=${() => show([row.a, row.b])}>${mode + 1}: ${hertz(frequency)}</button>`;
  const difference = ({ left, right }) => (left && right ? cents(left.hertz, right.hertz) : null);
  const column = (title, value, text) => ({ title, number: true, value, text: (row) => (value(row) === null ? "–" : text(value(row), row)) });
  const sides = [["A", "left", "a"], ["B", "right", "b"]];
  const error = (value) => `± ${number(value, 2)} cents`;
  return table(
    [
      ...sides.map(([letter, side, mode]) => column(`${letter}: mode`, (row) => row[side]?.hertz ?? null, (value, row) => button(row, row[mode], value))),
      column("B above A", difference, (value) => `${value > 0 ? "+" : ""}${number(value, 4).replace("-", "−")} cents`),
      ...sides.map(([letter, side]) => column(`${letter}: error`, (row) => row[side]?.cents ?? null, error)),
      ...sides.map(([letter, side]) => column(`${letter}: T60`, (row) => row[side]?.t60 ?? null, seconds)),
    ],
    rows,
    { caption: `Modes of A (${one.name}) and B (${other.name}); ${pairs.length} are matched`, max: 120 },
  );
}
