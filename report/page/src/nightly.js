import * as Plot from "@observablehq/plot";
import { html } from "htl";

import { base, colors, figure } from "./figure.js";
import { number, seconds, source } from "./format.js";
import { table } from "./table.js";

// What changed since the nightly runs before (scripts/nightly).
export function nightlySections({ nightly_runs: runs }) {
  return runs.map((run, i) => ({ id: `nightly-${i}`, title: `The nightly run of ${run.date}`, content: () => content(run) }));
}

const bad = new Set(["slower", "worse", "failed"]);
function shown(value, unit) {
  if (typeof value !== "number") return value ?? "–";
  if (unit === "s") return seconds(value);
  return `${number(value, 4)}${unit && unit !== "1" ? ` ${unit}` : ""}`;
}

function content(run) {
  const measures = [...run.measures].sort((a, b) => Number(bad.has(b.verdict)) - Number(bad.has(a.verdict)));
  const marked = measures.filter(({ verdict, value }) => typeof value === "number" && !["steady", "learning", "new"].includes(verdict));
  const made = { command: "scripts/nightly", ranks: run.ranks, carillon: `${run.version} (${run.commit})`, processor: run.cpu, date: run.date };
  const from = source(made, `${run.folder}/nightly.json`);
  return html`<p class=${run.verdict === "fine" ? "good" : run.verdict === "learning" ? "" : "bad"}>${verdict(run)}</p>
    ${table(
      [
        { title: "run", value: (r) => `${r.command} ${r.config}` },
        { title: "time", number: true, value: (r) => r.seconds, text: (r) => seconds(r.seconds) },
        { title: "outcome", value: (r) => String(r.ok), text: (r) => (r.ok ? "done" : html`<span class="bad">${r.message}</span>`) },
      ],
      run.runs,
    )}
    <p class="source">${from}</p>
    <div class="figures">${marked.slice(0, 12).map((measure) => trend(measure, from))}</div>
    <details open=${marked.length === 0}><summary>All ${measures.length} measures</summary>${table(
      [
        { title: "measure", value: (m) => m.name },
        { title: "this run", number: true, value: (m) => m.value, text: (m) => shown(m.value, m.unit) },
        { title: "as a rule", number: true, value: (m) => m.typical, text: (m) => shown(m.typical, m.unit) },
        { title: "bound", number: true, value: (m) => m.bound, text: (m) => shown(m.bound, m.unit) },
        { title: "change", value: (m) => m.change ?? "" },
        { title: "verdict", value: (m) => m.verdict, text: (m) => html`<span class=${bad.has(m.verdict) ? "bad" : ""}>${m.verdict}</span>` },
      ],
      measures,
    )}</details>`;
}

function verdict(run) {
  const count = run.measures.filter((measure) => bad.has(measure.verdict)).length;
  if (run.verdict === "failed") return "The nightly run could not run as a whole.";
  if (run.verdict === "learning") {
    const learning = run.measures.filter((measure) => ["learning", "new"].includes(measure.verdict)).length;
    return `${learning} of ${run.measures.length} measures have too few nightly runs to compare with (${run.nightly_runs} at the most); the others are as before.`;
  }
  return count === 0 ? `Nothing is slower or less accurate than in ${run.nightly_runs} nightly runs before.` : `${count} of ${run.measures.length} measures are worse than in ${run.nightly_runs} nightly runs before.`;
}

// The history's last run is this one.
function trend(measure, from) {
  const rows = measure.history.map(([date, value], run) => ({ run, date, value, last: run === measure.history.length - 1 }));
  return figure(
    (width) =>
      Plot.plot(
        base(width, {
          height: 200,
          marginLeft: 60,
          x: { label: "nightly run", ticks: [] },
          y: { label: measure.unit, grid: true, nice: true },
          marks: [
            typeof measure.bound !== "number" ? null : Plot.ruleY([measure.bound], { strokeDasharray: "4 3" }),
            Plot.line(rows, { x: "run", y: "value", stroke: colors[7] }),
            Plot.dot(rows, { x: "run", y: "value", fill: (row) => (!row.last ? colors[0] : bad.has(measure.verdict) ? colors[4] : colors[2]), r: 4, tip: true, title: (row) => `${row.last ? "this run" : row.date}: ${shown(row.value, measure.unit)}` }),
          ],
        }),
      ),
    { narrow: true, title: measure.name, caption: `${measure.verdict} ${measure.change ?? ""}; dashed: the bound.`, source: from },
  );
}
