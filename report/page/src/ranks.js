import * as Plot from "@observablehq/plot";
import { html } from "htl";

import { base, colors, figure } from "./figure.js";
import { bytes, percent, seconds, source } from "./format.js";
import { table } from "./table.js";

// What every rank did when, and how busy the ranks were.
export function ranksOf(dataset) {
  if (dataset.tasks.length === 0) return "";
  const runs = [...new Set(dataset.tasks.map((task) => task.run))];
  return html`<h3>Ranks</h3>
    ${runs.map((run) => timeline(dataset, run, runs.length))}
    ${dataset.ranks.length > 0 ? utilisation(dataset) : ""}`;
}

function timeline(dataset, run, runs) {
  const tasks = dataset.tasks.filter((task) => task.run === run);
  const bars = tasks.flatMap((task) =>
    Array.from({ length: task.width }, (_, i) => ({ ...task, rank: task.rank + i })),
  );
  const ranks = [...new Set(bars.map((bar) => bar.rank))].sort((a, b) => a - b);
  const kinds = [...new Set(bars.map((bar) => bar.kind))];
  const entry = dataset.runs.find((one) => one.run === run);
  const busy = entry?.busy_share === undefined ? "" : ` Busy until the last task began: ${percent(entry.busy_share)}.`;
  return figure(
    (width) =>
      Plot.plot(
        base(width, {
          height: Math.min(22, Math.max(3, 700 / ranks.length)) * ranks.length + 60,
          marginLeft: 50,
          x: { label: "seconds since the run began", grid: true, ticks: Math.max(2, Math.floor(width / 120)) },
          y: { label: "rank", domain: ranks, ticks: ranks.length > 40 ? ranks.filter((r) => r % 16 === 0) : ranks },
          color: { domain: kinds, range: colors, legend: true },
          marks: [
            Plot.barX(bars, {
              x1: "start_s",
              x2: (bar) => bar.start_s + bar.seconds,
              y: "rank",
              fill: "kind",
              insetLeft: 0.25,
              insetRight: 0.25,
              title: (bar) => `${bar.task}: ${seconds(bar.seconds)}, computing ${seconds(bar.cpu_s)} (estimated ${seconds(bar.estimate_s)})`,
            }),
          ],
        }),
      ),
    {
      caption: `${runs > 1 ? `Run ${run}: ` : ""}${tasks.length} tasks on ${ranks.length} ${ranks.length === 1 ? "rank" : "ranks"}.${busy}${dataset.tasks_run > dataset.tasks.length ? ` ${dataset.tasks_run - dataset.tasks.length} short tasks are not drawn.` : ""}`,
      source: source(entry?.made ?? dataset.made, `${dataset.folder}/trace.json`),
    },
  );
}

function utilisation(dataset) {
  return table(
    [
      { title: "rank", number: true, value: (rank) => rank.rank },
      { title: "in tasks", number: true, value: (rank) => rank.busy_s, text: (rank) => seconds(rank.busy_s) },
      { title: "computing", number: true, value: (rank) => rank.cpu_s, text: (rank) => seconds(rank.cpu_s) },
      { title: "waiting for a processor", number: true, value: (rank) => rank.queued_s, text: (rank) => seconds(rank.queued_s) },
      { title: "without a task", number: true, value: (rank) => rank.idle_s, text: (rank) => seconds(rank.idle_s) },
      { title: "most memory", number: true, value: (rank) => rank.peak_memory_bytes, text: (rank) => bytes(rank.peak_memory_bytes) },
    ],
    dataset.ranks.map((rank, i) => ({ rank: i, ...rank })),
    { caption: "The last run", max: 64 },
  );
}
