import * as Plot from "@observablehq/plot";
import { html } from "htl";

import { base, colors, figure } from "./figure.js";
import { number, percent } from "./format.js";
import { table } from "./table.js";

// What was handed in for a dataset's test samples (carillon score), beside what was trained here.
export function leaderboardSections({ leaderboards }) {
  return leaderboards.map((board, i) => ({ id: `leaderboard-${i}`, title: `Leaderboard: ${board.task} of ${board.dataset}`, content: () => content(board) }));
}

const shown = (value, unit) => (unit === "%" ? percent(value) : `${number(value)} ${unit}`.trim());
const measureOf = (row, name) => row.measures.find((measure) => measure.name === name);

function withInterval({ mean, unit, interval95 }) {
  return typeof interval95?.[0] === "number" ? `${shown(mean, unit)} [${shown(interval95[0], unit)}, ${shown(interval95[1], unit)}]` : shown(mean, unit);
}

function content(board) {
  const names = [...new Set(board.rows.flatMap((row) => row.measures.map((measure) => measure.name)))];
  return html`<p>${board.asked.replaceAll("`", "")}</p>
    ${board.notes.map((note) => html`<p class="note bad">${note}</p>`)}
    ${board.rows.length > 1 ? chart(board) : ""}
    ${table(
      [
        { title: "rank", number: true, value: (r) => r.rank },
        { title: "entry", value: (r) => r.entry, text: (r) => html`${r.entry}${r.trained_here ? html` <span class="note">trained here</span>` : ""}` },
        { title: "seeds", number: true, value: (r) => r.seeds },
        ...names.map((name) => ({
          title: name,
          number: true,
          value: (r) => measureOf(r, name)?.mean,
          text: (r) => (measureOf(r, name) ? withInterval(measureOf(r, name)) : "–"),
        })),
        { title: "less the first one's", number: true, value: (r) => r.difference?.mean, text: (r) => difference(r) },
      ],
      board.rows,
      { caption: `Entries of ${board.task}` },
    )}
    <p class="source">${board.folder}</p>`;
}

function difference(row) {
  if (!row.difference) return "–";
  return `${withInterval({ ...row.difference, unit: row.measures[0].unit })}${row.told_apart ? "" : ", not told apart"}`;
}

// The first measure of the best entries; hollow where it is not told from the first.
function chart(board) {
  const [first] = board.rows[0].measures;
  const rows = board.rows.slice(0, 30).map((row) => ({ ...row, ...row.measures[0], place: `${row.rank}. ${row.entry}` }));
  const scale = first.unit === "%" ? 100 : 1;
  return figure(
    (width) =>
      Plot.plot(
        base(width, {
          height: 26 * rows.length + 70,
          marginLeft: Math.min(220, width / 3),
          x: { label: first.unit ? `${first.name} [${first.unit}]` : first.name, grid: true, nice: true },
          y: { label: null, domain: rows.map((row) => row.place) },
          marks: [
            Plot.link(rows.filter((row) => row.interval95), { x1: (row) => scale * row.interval95[0], x2: (row) => scale * row.interval95[1], y1: "place", y2: "place", stroke: colors[0] }),
            Plot.dot(rows, { x: (row) => scale * row.mean, y: "place", r: 4, stroke: colors[0], fill: (row) => (row.rank === 1 || row.told_apart ? colors[0] : "white"), tip: true, title: (row) => `${row.entry}: ${withInterval(row)}` }),
          ],
        }),
      ),
    { title: `${first.name} of ${board.task}`, caption: `With 95 % intervals. Hollow: not told from the first on the same samples.${board.rows.length > 30 ? ` The first 30 of ${board.rows.length}.` : ""}`, source: board.folder },
  );
}
