import * as Plot from "@observablehq/plot";
import { html } from "htl";

import { base, colors, figure, logScale } from "./figure.js";
import { number, percent, seconds, source } from "./format.js";
import { table } from "./table.js";

export function learningSections({ damping, classification, transfer }) {
  return [
    ...damping.map((document, i) => ({ id: `damping-${i}`, title: `Damping found again: ${document.name}`, content: () => dampingContent(document) })),
    ...classification.map((document, i) => ({ id: `classification-${i}`, title: `Told apart: ${document.name}`, content: () => classificationContent(document) })),
    ...transfer.map((document, i) => ({ id: `transfer-${i}`, title: `In other conditions: ${document.name}`, content: () => transferContent(document) })),
  ];
}

const interval = (value) => (value?.interval95 ? `${percent(value.mean)} [${percent(value.interval95[0])}, ${percent(value.interval95[1])}]` : percent(value?.mean));

// What is below a hundredth of a per cent is drawn there.
const shown = (error) => Math.max(error, 1e-4);

function dampingContent(document) {
  const rows = document.errors.filter((row) => row.material === "all");
  const [best] = document.features;
  const figuresOf = (some) => html`<div class="figures">${conditions(some).flatMap((group) => errorsFigures(group, document))}</div>`;
  const others = rows.filter((row) => row.features !== best);
  return html`<p>Relative errors of the parameters of the law <em>${document.model}</em>, of materials whose damping is known.</p>
    ${figuresOf(rows.filter((row) => row.features === best))}
    ${others.length > 0 ? html`<details><summary>With features by ${[...new Set(others.map((row) => row.features))].join(", ")}</summary>${figuresOf(others)}</details>` : ""}
    <details><summary>All medians</summary>${table(
      [
        { title: "condition", value: (r) => r.condition },
        { title: "features", value: (r) => r.features },
        { title: "sounds of one", value: (r) => r.from },
        { title: "sounds", number: true, value: (r) => r.sounds },
        { title: "parameter", value: (r) => r.parameter },
        { title: "estimator", value: (r) => r.estimator },
        { title: "median", number: true, value: (r) => r.median, text: (r) => percent(r.median) },
        { title: "quartiles", number: true, value: (r) => r.lower_quartile, text: (r) => `${percent(r.lower_quartile)} to ${percent(r.upper_quartile)}` },
        { title: "failed", number: true, value: (r) => r.failed },
      ],
      rows,
      { max: 400 },
    )}</details>
    ${ahead(document)}
    <p class="source">${source(document.made, `${document.folder}/damping.json`)}</p>`;
}

// Rows by what they have in common: condition, source of features, and where a set's sounds are from.
function conditions(rows) {
  const groups = new Map();
  for (const row of rows) {
    const name = `${row.condition}; sounds of ${row.from === "object" ? "one object" : "any objects"}; features by ${row.features}`;
    groups.set(name, [...(groups.get(name) ?? []), row]);
  }
  return [...groups].map(([name, members]) => ({ name, members }));
}

function errorsFigures({ name, members: rows }, document) {
  return [...new Set(rows.map((row) => row.parameter))].map((parameter) => {
    const own = rows.filter((row) => row.parameter === parameter && row.median > 0);
    if (own.length === 0) return "";
    const estimators = [...new Set(own.map((row) => row.estimator))];
    return figure(
      (width) =>
        Plot.plot(
          base(width, {
            height: 240,
            x: logScale(own.map((row) => row.sounds), "sounds", (value) => String(value)),
            y: logScale(own.flatMap((row) => [row.lower_quartile || row.median, row.upper_quartile].map(shown)), `relative error of ${parameter}`, (value) => percent(value)),
            color: { domain: estimators, range: colors, legend: true },
            marks: [
              Plot.areaY(own, { x: "sounds", y1: (row) => shown(row.lower_quartile || row.median), y2: (row) => shown(row.upper_quartile), fill: "estimator", fillOpacity: 0.12 }),
              Plot.line(own, { x: "sounds", y: (row) => shown(row.median), stroke: "estimator" }),
              Plot.dot(own, { x: "sounds", y: (row) => shown(row.median), fill: "estimator", tip: true, title: (row) => `${row.estimator}, ${row.sounds} sounds: ${percent(row.median)}` }),
            ],
          }),
        ),
      { narrow: true, title: parameter, caption: `${name}. Medians; shaded from quartile to quartile.`, source: source(document.made, `${document.folder}/damping.json`) },
    );
  });
}

function ahead(document) {
  const rows = (document.tests ?? []).filter((row) => row.material === "all");
  if (rows.length === 0) return "";
  return html`<details><summary>Which estimator is ahead</summary>${table(
    [
      { title: "condition", value: (r) => r.condition },
      { title: "features", value: (r) => r.features },
      { title: "sounds", number: true, value: (r) => r.sounds },
      { title: "parameter", value: (r) => r.parameter },
      { title: "pair", value: (r) => r.estimators.join(" and ") },
      { title: "signed-rank p (Holm)", number: true, value: (r) => r.signed_rank_p_holm, text: (r) => number(r.signed_rank_p_holm, 2) },
      { title: "ahead", value: (r) => r.ahead ?? "", text: (r) => r.ahead ?? "not told apart" },
    ],
    rows,
    { max: 400 },
  )}</details>`;
}

function classificationContent(document) {
  const rows = [...document.rows].sort((a, b) => a.task.localeCompare(b.task) || b.accuracy.mean - a.accuracy.mean);
  return html`${table(
    [
      { title: "dataset", value: (r) => r.dataset },
      { title: "task", value: (r) => r.task },
      { title: "method", value: (r) => r.method },
      { title: "modalities", value: (r) => r.modalities },
      { title: "right [95 %]", number: true, value: (r) => r.accuracy.mean, text: (r) => interval(r.accuracy) },
      { title: "balanced", number: true, value: (r) => r.balanced_accuracy?.mean, text: (r) => percent(r.balanced_accuracy?.mean) },
      { title: "papers", number: true, value: (r) => r.published?.accuracy, text: (r) => percent(r.published?.accuracy) },
      { title: "calibration error", number: true, value: (r) => r.recognition?.calibration_error, text: (r) => percent(r.recognition?.calibration_error) },
      { title: "trained in", number: true, value: (r) => r.training_s, text: (r) => seconds(r.training_s) },
      { title: "parameters", number: true, value: (r) => r.parameters, text: (r) => r.parameters?.toLocaleString("en") ?? "–" },
    ],
    rows,
  )}
  <p class="source">${source(document.made, `${document.folder}/classification.json`)}</p>
  ${confusions(rows, document)}`;
}

// The report holds one for each task: of the method that is most often right.
function confusions(rows, document) {
  return html`<div class="figures">${rows
    .filter((row) => row.confusion?.length > 1)
    .map((row) => {
      const cells = row.confusion.flatMap((line, truth) => {
        const sum = line.reduce((a, b) => a + b, 0) || 1;
        return line.map((value, answer) => ({ truth: row.classes[truth], answer: row.classes[answer], value, share: value / sum }));
      });
      const many = row.classes.length > 20;
      return figure(
        (width) =>
          Plot.plot(
            base(width, {
              height: Math.min(640, (many ? 8 : 26) * row.classes.length + 130),
              marginLeft: many ? 30 : 90,
              marginBottom: many ? 30 : 80,
              x: { label: "answer", domain: row.classes, tickRotate: -50, ticks: many ? [] : undefined },
              y: { label: "truth", domain: row.classes, ticks: many ? [] : undefined },
              color: { scheme: "blues", domain: [0, 1] },
              marks: [
                Plot.cell(cells, { x: "answer", y: "truth", fill: "share", inset: many ? 0 : 0.5, tip: true, title: (cell) => `${cell.truth} taken for ${cell.answer}: ${cell.value} (${percent(cell.share)})` }),
                many || width < 500 ? null : Plot.text(cells, { x: "answer", y: "truth", text: (cell) => (cell.value ? String(cell.value) : ""), fill: (cell) => (cell.share > 0.5 ? "white" : "black"), fontSize: 10 }),
              ],
            }),
          ),
        {
          narrow: row.classes.length < 8,
          title: `${row.task}: ${row.method}`,
          caption: `${row.dataset}: ${percent(row.accuracy.mean)} of ${row.samples} right.${many ? " Names of classes show at the pointer." : ""}`,
          source: source(document.made, `${document.folder}/classification.json`),
        },
      );
    })}</div>`;
}

function transferContent(document) {
  return html`${table(
    [
      { title: "kind", value: (r) => r.kind },
      { title: "trained on", value: (r) => r.trained_on },
      { title: "method", value: (r) => r.method },
      { title: "share of the target", number: true, value: (r) => r.share, text: (r) => percent(r.share) },
      { title: "right at home", number: true, value: (r) => r.own?.mean, text: (r) => (r.own ? interval(r.own) : "–") },
      { title: `right in “${document.target}”`, number: true, value: (r) => r.target?.mean, text: (r) => interval(r.target) },
      { title: "gain", number: true, value: (r) => r.gain?.mean, text: (r) => (r.gain ? interval(r.gain) : "–") },
    ],
    document.rows,
  )}
  <p class="source">${source(document.made, `${document.folder}/transfer.json`)}</p>`;
}
