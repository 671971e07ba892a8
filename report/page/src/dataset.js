import * as Plot from "@observablehq/plot";
import { html } from "htl";

import { costFigure } from "./cost.js";
import { base, colors, figure } from "./figure.js";
import { bytes, count, hertz, number, seconds, source } from "./format.js";
import { galleryLink } from "./gallery.js";
import "./paper.js";
import { ranksOf } from "./ranks.js";
import { table } from "./table.js";

export function datasetSections({ datasets, gallery }) {
  return datasets.map((dataset, index) => ({
    id: `dataset-${index}`,
    title: datasets.length > 1 ? `What was built: ${dataset.label}` : "What was built",
    content: () => datasetContent(dataset, gallery, index, datasets.length > 3),
  }));
}

function datasetContent(dataset, gallery, index, folded) {
  const parts = html`<div>
    ${summary(dataset)}
    ${failures(dataset, gallery, index)}
    ${warnings(dataset)}
    ${worstModes(dataset, gallery)}
    ${costFigure(dataset, { title: "What accuracy cost in time" }) ?? ""}
    ${objects(dataset)}
    ${making(dataset)}
    ${configuration(dataset)}
  </div>`;
  return folded ? html`<details open=${index === 0 || dataset.failed > 0}><summary>${summaryLine(dataset)}</summary>${parts}</details>` : parts;
}

function summaryLine(dataset) {
  return `${count(dataset.samples, "sound")} of ${count(dataset.objects, "object", "objects")}`;
}

function summary(dataset) {
  const about = dataset.about;
  const tiles = [
    ["sounds", dataset.samples.toLocaleString("en")],
    ["objects", dataset.objects.toLocaleString("en")],
    ["materials", dataset.materials.length],
    ["failed tasks", dataset.failed],
    ["took", seconds(wallSeconds(dataset))],
    ["in tasks, of all ranks", seconds(dataset.task_seconds)],
    ["on disk", bytes(dataset.bytes)],
  ];
  return html`<div>
    ${about.description ? html`<p>${about.description}</p>` : ""}
    <dl class="tiles">${tiles.map(([name, value]) => html`<div class=${name === "failed tasks" && value > 0 ? "bad" : ""}><dt>${name}</dt><dd>${value}</dd></div>`)}</dl>
    <p class="source">${dataset.folder}${about.license ? ` · ${about.license}` : ""}${about.creators ? ` · ${about.creators.join(", ")}` : ""}</p>
  </div>`;
}

// Of every run, one after the other, as long as its ranks were there; undefined where none is done.
function wallSeconds({ runs }) {
  const there = runs.map((run) => Math.max(0, ...(run.ranks ?? []).map((rank) => rank.busy_s + rank.idle_s)));
  return there.length > 0 ? there.reduce((sum, one) => sum + one, 0) : undefined;
}

// Those that cost most other tasks first.
function failures(dataset, gallery, index) {
  if (dataset.failed === 0) return html`<p id=${`failures-${index}`} class="good">No task failed.</p>`;
  const lost = (failure) => (failure.skipped ?? []).length;
  return html`<div id=${`failures-${index}`}><h3>What failed</h3>
    ${table(
      [
        { title: "task", value: (f) => f.task, text: (f) => galleryLink(gallery, { dataset: dataset.name, object: objectOf(f.task) }, html`<code>${f.task}</code>`) },
        { title: "stage", value: (f) => f.stage ?? "" },
        { title: "reason", value: (f) => f.message, text: (f) => html`${f.message}${f.hint ? html`<br><em>${f.hint}</em>` : ""}` },
        { title: "left out with it", number: true, value: lost },
        { title: "again", value: (f) => f.reproduce ?? "", text: (f) => html`<code>${f.reproduce ?? ""}</code>` },
      ],
      [...dataset.failures].sort((a, b) => lost(b) - lost(a)),
      { caption: "Failed tasks, those with the most left out first" },
    )}${leftOut(dataset.failed - dataset.failures.length, "failures.json has", "more")}</div>`;
}

// Of modes/ID and samples/ID-NNNN.
function objectOf(task) {
  return task.replace(/^modes\//, "").replace(/^samples\/(.*)-\d+$/, "$1");
}

function worstModes(dataset, gallery) {
  if (dataset.worst_modes.length === 0) return "";
  const unseen = dataset.objects - dataset.shapes.length;
  return html`<h3>Where pitch is known least</h3>
    ${table(
      [
        { title: "object", value: (m) => m.object, text: (m) => galleryLink(gallery, { dataset: dataset.name, ...m }, m.object) },
        { title: "mode", number: true, value: (m) => m.mode },
        { title: "error (estimated)", number: true, value: (m) => m.cents, text: (m) => `± ${number(m.cents, 3)} cents` },
        { title: "frequency", number: true, value: (m) => m.hertz, text: (m) => hertz(m.hertz) },
        { title: "material", value: (m) => m.material },
        { title: "size", number: true, value: (m) => m.size, text: (m) => `× ${number(m.size, 4)}` },
      ],
      dataset.worst_modes,
      { caption: `The ${dataset.worst_modes.length} modes with the largest error bars, the worst first` },
    )}
    <p class="source">Objects of several materials or sizes by the first one that has the mode.${unseen > 0 ? ` Of the ${dataset.shapes.length} objects that took longest; ${unseen} more were not looked at.` : ""}
      ${source(dataset.made, `${dataset.folder}/modes/`)}</p>`;
}

function warnings(dataset) {
  if (dataset.warned === 0) return "";
  return html`<div><h3>What is doubtful</h3>
    ${table(
      [
        { title: "task", value: (w) => w.task, text: (w) => html`<code>${w.task}</code>` },
        { title: "warning", value: (w) => w.message },
      ],
      dataset.warnings,
      { caption: "Warnings" },
    )}${leftOut(dataset.warned - dataset.warnings.length, "warnings.json has", "more")}</div>`;
}

// Small print: where the time went.
function making(dataset) {
  const parts = [stages(dataset), effects(dataset), ranksOf(dataset)].filter(Boolean);
  return parts.length === 0 ? "" : html`<details class="small-print"><summary>Where the time went: stages, effects and ranks</summary>${parts}</details>`;
}

function stages(dataset) {
  const rows = Object.entries(dataset.stages)
    .map(([name, entry]) => ({ name, ...entry }))
    .filter((row) => row.seconds > 0)
    .sort((a, b) => b.seconds - a.seconds);
  if (rows.length === 0) return "";
  return html`<h3>Where the time went</h3>
    ${figure(
      (width) =>
        Plot.plot(
          base(width, {
            height: 26 * rows.length + 50,
            marginLeft: 120,
            marginRight: 70,
            x: { label: "seconds on all ranks", grid: true, tickFormat: (value) => number(value), ticks: Math.max(2, Math.floor(width / 120)) },
            y: { label: null, domain: rows.map((row) => row.name) },
            marks: [
              Plot.barX(rows, { x: "seconds", y: "name", fill: colors[0], title: (row) => `${row.name}: ${seconds(row.seconds)} in ${count(row.calls, "call")}` }),
              Plot.text(rows, { x: "seconds", y: "name", text: (row) => `${seconds(row.seconds)}`, textAnchor: "start", dx: 4 }),
              Plot.ruleX([0]),
            ],
          }),
        ),
      {
        caption: "Stages of all tasks. Some lie within others, so that they have no sum: the estimate of an object's errors solves it once more, coarser.",
        source: source(dataset.made, `${dataset.folder}/trace.json`),
      },
    )}`;
}

function effects(dataset) {
  const on = dataset.effects.filter((effect) => effect.enabled);
  const off = dataset.effects.filter((effect) => !effect.enabled);
  if (dataset.effects.length === 0) return "";
  return html`<h3>Effects and their cost</h3>
    ${table(
      [
        { title: "effect", value: (e) => e.name },
        { title: "calls", number: true, value: (e) => e.calls, text: (e) => number(e.calls, 6) },
        { title: "time", number: true, value: (e) => e.seconds, text: (e) => seconds(e.seconds) },
        { title: "a call", number: true, value: (e) => e.seconds / e.calls, text: (e) => (e.calls ? seconds(e.seconds / e.calls) : "–") },
        { title: "why it runs", value: (e) => e.reason },
      ],
      on,
      { caption: "Effects that ran" },
    )}
    <p class="source">${source(dataset.made, `${dataset.folder}/trace.json`)}</p>
    <details><summary>${count(off.length, "effect")} that nothing calls for did not run: trace.json has no call of ${off.length === 1 ? "it" : "them"}</summary>
    ${table([{ title: "effect", value: (e) => e.name }, { title: "calls", number: true, value: (e) => e.calls }, { title: "why not", value: (e) => e.reason }], off, { caption: "Effects that did not run" })}
    </details>`;
}

function objects(dataset) {
  const worst = (shape) => (shape.failure ? Infinity : shape.pitch_error_cents ?? -1);
  return html`<details class="small-print"><summary>${count(dataset.shapes.length, "object")}, the largest error bar first</summary>
    ${table(
      [
        { title: "object", value: (s) => s.id },
        { title: "family", value: (s) => s.family },
        { title: "part", value: (s) => s.split },
        { title: "variants", number: true, value: (s) => s.variants },
        { title: "modes", number: true, value: (s) => s.modes },
        { title: "complete to", number: true, value: (s) => s.complete_to_hz, text: (s) => (s.complete_to_hz ? hertz(s.complete_to_hz) : "–") },
        { title: "worst pitch error (estimated)", number: true, value: (s) => s.pitch_error_cents, text: (s) => (s.pitch_error_cents === null ? "–" : `${number(s.pitch_error_cents, 2)} cents`) },
        { title: "median", number: true, value: (s) => s.median_pitch_error_cents, text: (s) => (s.median_pitch_error_cents === null ? "–" : `${number(s.median_pitch_error_cents, 2)} cents`) },
        { title: "order", number: true, value: (s) => s.order },
        { title: "unknowns", number: true, value: (s) => s.unknowns, text: (s) => number(s.unknowns, 6) },
        { title: "time", number: true, value: (s) => s.seconds, text: (s) => seconds(s.seconds) },
        ...(dataset.shapes.some((s) => s.failure) ? [{ title: "cannot be read", value: (s) => s.failure ?? "" }] : []),
      ],
      [...dataset.shapes].sort((a, b) => worst(b) - worst(a) || 0),
      { caption: "Objects", max: 100 },
    )}${leftOut(dataset.objects - dataset.shapes.length, "modes/ has", "more, which took less time")}
    <p class="source">${source(dataset.made, `${dataset.folder}/modes/ and trace.json`)}</p></details>`;
}

function leftOut(number, where, what) {
  return number > 0 ? html`<p class="source">${where} ${number.toLocaleString("en")} ${what}.</p>` : "";
}

function configuration(dataset) {
  return html`<details class="small-print"><summary>Configuration and versions</summary>
    ${table([{ title: "library", value: ([name]) => name }, { title: "version", value: ([, version]) => version }], Object.entries(dataset.versions), { caption: "Versions" })}
    <pre tabindex="0" role="region" aria-label=${`Configuration of ${dataset.label}`}>${dataset.configuration}</pre></details>`;
}
