import * as Plot from "@observablehq/plot";
import { html } from "htl";

import { base, colors, figure } from "./figure.js";
import { number, seconds, source } from "./format.js";
import { table } from "./table.js";

// What changed since the nights before (scripts/nightly).
export function nightSections({ nights }) {
  return nights.map((night, i) => ({ id: `night-${i}`, title: `The night of ${night.date}`, content: () => content(night) }));
}

const bad = new Set(["slower", "worse", "failed"]);
function shown(value, unit) {
  if (typeof value !== "number") return value ?? "–";
  if (unit === "s") return seconds(value);
  return `${number(value, 4)}${unit && unit !== "1" ? ` ${unit}` : ""}`;
}

function content(night) {
  const measures = [...night.measures].sort((a, b) => Number(bad.has(b.verdict)) - Number(bad.has(a.verdict)));
  const marked = measures.filter(({ verdict, value }) => typeof value === "number" && !["steady", "learning", "new"].includes(verdict));
  const made = { command: "scripts/nightly", ranks: night.ranks, carillon: `${night.version} (${night.commit})`, processor: night.cpu, date: night.date };
  const from = source(made, `${night.folder}/nightly.json`);
  return html`<p class=${night.verdict === "fine" ? "good" : night.verdict === "learning" ? "" : "bad"}>${verdict(night)}</p>
    ${table(
      [
        { title: "run", value: (r) => `${r.command} ${r.config}` },
        { title: "time", number: true, value: (r) => r.seconds, text: (r) => seconds(r.seconds) },
        { title: "outcome", value: (r) => String(r.ok), text: (r) => (r.ok ? "done" : html`<span class="bad">${r.message}</span>`) },
      ],
      night.runs,
    )}
    <p class="source">${from}</p>
    <div class="figures">${marked.slice(0, 12).map((measure) => trend(measure, from))}</div>
    <details open=${marked.length === 0}><summary>All ${measures.length} measures</summary>${table(
      [
        { title: "measure", value: (m) => m.name },
        { title: "tonight", number: true, value: (m) => m.value, text: (m) => shown(m.value, m.unit) },
        { title: "as a rule", number: true, value: (m) => m.typical, text: (m) => shown(m.typical, m.unit) },
        { title: "bound", number: true, value: (m) => m.bound, text: (m) => shown(m.bound, m.unit) },
        { title: "change", value: (m) => m.change ?? "" },
        { title: "verdict", value: (m) => m.verdict, text: (m) => html`<span class=${bad.has(m.verdict) ? "bad" : ""}>${m.verdict}</span>` },
      ],
      measures,
    )}</details>`;
}

function verdict(night) {
  const count = night.measures.filter((measure) => bad.has(measure.verdict)).length;
  if (night.verdict === "failed") return "The night could not run as a whole.";
  if (night.verdict === "learning") {
    const learning = night.measures.filter((measure) => ["learning", "new"].includes(measure.verdict)).length;
    return `${learning} of ${night.measures.length} measures have too few nights to compare with (${night.nights} at the most); the others are as before.`;
  }
  return count === 0 ? `Nothing is slower or less accurate than in ${night.nights} nights before.` : `${count} of ${night.measures.length} measures are worse than in ${night.nights} nights before.`;
}

// The history's last night is this one.
function trend(measure, from) {
  const rows = measure.history.map(([date, value], night) => ({ night, date, value, tonight: night === measure.history.length - 1 }));
  return figure(
    (width) =>
      Plot.plot(
        base(width, {
          height: 200,
          marginLeft: 60,
          x: { label: "night", ticks: [] },
          y: { label: measure.unit, grid: true, nice: true },
          marks: [
            typeof measure.bound !== "number" ? null : Plot.ruleY([measure.bound], { strokeDasharray: "4 3" }),
            Plot.line(rows, { x: "night", y: "value", stroke: colors[7] }),
            Plot.dot(rows, { x: "night", y: "value", fill: (row) => (!row.tonight ? colors[0] : bad.has(measure.verdict) ? colors[4] : colors[2]), r: 4, tip: true, title: (row) => `${row.tonight ? "tonight" : row.date}: ${shown(row.value, measure.unit)}` }),
          ],
        }),
      ),
    { narrow: true, title: measure.name, caption: `${measure.verdict} ${measure.change ?? ""}; dashed: the bound.`, source: from },
  );
}
