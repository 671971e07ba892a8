import * as Plot from "@observablehq/plot";
import { html } from "htl";

import { costFigure } from "./cost.js";
import { base, colors, figure, logScale, safely } from "./figure.js";
import { number, percent, seconds, source } from "./format.js";
import { featureFigures, modesFigures, levelsTables, soundFigures } from "./studies.js";
import { table } from "./table.js";

// What accuracy costs in time: one picture for each stage that was measured.
export function accuracySection(report) {
  // A document that cannot be drawn costs its own figures.
  const drawn = (documents, make) => documents.flatMap((document) => safely(() => make(document)));
  const figures = [
    ...drawn(report.studies, modesFigures),
    ...drawn(firstOfName(report.datasets), (dataset) => costFigure(dataset, { title: `Modes: the objects of ${dataset.name}`, narrow: true })),
    ...drawn(report.studies, soundFigures),
    ...drawn(report.studies, featureFigures),
    ...drawn(report.damping, fitFigures),
    ...drawn(report.classification, classifierFigure),
  ].filter(Boolean);
  if (figures.length === 0 && report.studies.length === 0 && report.damping.length === 0) return null;
  return {
    id: "accuracy",
    title: "What accuracy costs",
    content: () => html`<p>Seconds run across, the error runs down: lower is better, left is cheaper.</p>
      <div class="figures">${figures}</div>${missing(report)}
      ${drawn(report.studies, levelsTables)}
      ${safely(() => failuresTable(report))}`,
  };
}

// What could not be measured, and why.
function failuresTable(report) {
  const failed = failures(report);
  return html`${failed.length > 0 ? html`<details open><summary class="bad">${failed.length} measurements failed</summary>${table([{ title: "what", value: (f) => f.what }, { title: "reason", value: (f) => f.reason }], failed)}</details>` : ""}`;
}

function failures({ studies, damping }) {
  const of = (what, reason) => (reason ? [{ what, reason }] : []);
  return [
    ...studies.flatMap((study) => [
      ...of("sound", study.sound?.failure),
      ...of("features", study.features?.failure),
      ...(study.objects ?? []).flatMap((object) => [
        ...of(object.name, object.failure),
        ...(object.levels ?? []).flatMap((level) => of(`${object.name}, order ${level.order}, size × ${level.size_factor ?? "chosen"}`, level.failure)),
      ]),
    ]),
    ...damping.flatMap((document) => (document.failures ?? []).flatMap((failure) => of(failure.task, failure.message))),
  ];
}

// What would fill the gaps.
function missing(report) {
  const none = (key) => !report.studies.some((study) => (key === "objects" ? study.objects?.length > 0 : study[key]));
  const gaps = [
    [none("objects"), "modes against a reference", "carillon accuracy CONFIG"],
    [none("sound"), "sounds with fewer modes and reflections", "carillon accuracy CONFIG with sound:"],
    [none("features"), "features of recordings", "carillon accuracy CONFIG with features:"],
    [report.damping.length === 0, "fits of damping against the number of sounds", "carillon evaluate CONFIG with evaluate.damping"],
    [report.classification.length === 0, "classifiers against training time", "carillon evaluate CONFIG with evaluate.classification"],
  ].filter(([is]) => is);
  if (gaps.length === 0) return "";
  return html`<p class="note">Not measured in the folders shown here: ${gaps.map(([, what, command], i) => html`${i > 0 ? "; " : ""}${what} (<code>${command}</code>)`)}.</p>`;
}

// Of a sweep's variants, whose objects are mostly the same, the first.
function firstOfName(datasets) {
  return datasets.filter((dataset, i) => datasets.findIndex((other) => other.name === dataset.name) === i);
}

// A sound's features cost the time of a fit; the fit itself is a few milliseconds.
function fitFigures(damping) {
  const cost = damping.seconds_per_sound;
  if (!(cost > 0)) return [];
  const parameters = [...new Set(damping.errors.map((row) => row.parameter))];
  return parameters.map((parameter) => {
    const rows = damping.errors
      .filter((row) => row.parameter === parameter && row.material === "all" && row.features === damping.errors[0].features && row.from === damping.errors[0].from && row.condition === damping.errors[0].condition && row.median > 0)
      .map((row) => ({ ...row, seconds: cost * row.sounds }));
    const estimators = [...new Set(rows.map((row) => row.estimator))];
    if (rows.length === 0) return null;
    return figure(
      (width) =>
        Plot.plot(
          base(width, {
            height: 260,
            x: logScale(rows.map((row) => row.seconds), "seconds of the sounds' features", (value) => number(value)),
            y: logScale(rows.map((row) => row.median), `relative error of ${parameter}, median`, (value) => percent(value)),
            color: { domain: estimators, range: colors, legend: true },
            marks: [
              Plot.line(rows, { x: "seconds", y: "median", stroke: "estimator", sort: "sounds" }),
              Plot.dot(rows, {
                x: "seconds",
                y: "median",
                fill: "estimator",
                r: 4,
                tip: true,
                title: (row) => `${row.estimator}, ${row.sounds} sounds\n${percent(row.median)} (${percent(row.lower_quartile)} to ${percent(row.upper_quartile)})`,
              }),
            ],
          }),
        ),
      {
        narrow: true,
        title: `Fits of damping: ${parameter}`,
        caption: `Sets of ${[...new Set(rows.map((row) => row.sounds))].join(", ")} sounds (${rows[0].condition}; features: ${rows[0].features}).`,
        source: source(damping.made, `${damping.folder}/damping.json and damping-trace.json`),
      },
    );
  });
}

function classifierFigure(classification) {
  // A method has one number wherever it stands; half a sample is the least error that is drawn.
  const methods = [...new Set(classification.rows.map((row) => `${row.method} (${row.modalities})`))];
  const floor = (row) => 0.5 / row.samples;
  const rows = classification.rows
    .filter((row) => row.training_s > 0)
    .map((row) => {
      const wrong = (accuracy) => Math.max(1 - accuracy, floor(row));
      const [low, high] = row.accuracy.interval95 ?? [row.accuracy.mean, row.accuracy.mean];
      return { ...row, number: 1 + methods.indexOf(`${row.method} (${row.modalities})`), error: wrong(row.accuracy.mean), least: wrong(high), most: wrong(low) };
    });
  if (rows.length === 0) return [];
  const tasks = [...new Set(rows.map((row) => row.task))];
  const told = new Set(rows.map((row) => row.number));
  return figure(
    (width) =>
      Plot.plot(
        base(width, {
          height: 320,
          x: logScale(rows.map((row) => row.training_s), "seconds of training", (value) => number(value)),
          y: logScale(rows.flatMap((row) => [row.least, row.most]), "wrong answers, test part", (value) => percent(value)),
          color: { domain: tasks, range: colors, legend: true },
          marks: [
            Plot.ruleX(rows, { x: "training_s", y1: "least", y2: "most", stroke: "task", strokeOpacity: 0.5 }),
            Plot.dot(rows, {
              x: "training_s",
              y: "error",
              fill: "task",
              r: 4,
              tip: true,
              title: (row) => `${row.method} (${row.modalities})\n${row.task}: ${percent(row.accuracy.mean)} right\ntrained in ${seconds(row.training_s)}`,
            }),
            Plot.text(rows, { x: "training_s", y: "error", text: (row) => String(row.number), dx: 6, textAnchor: "start" }),
          ],
        }),
      ),
    {
      title: `Classifiers: ${classification.name}`,
      caption: html`Each point one method on one task, with its 95 % interval.${rows.some((row) => row.error === floor(row)) ? " Where all answers are right, half a wrong one is drawn." : ""}
        Methods: ${methods.map((method, i) => (told.has(i + 1) ? `${i + 1} ${method}` : "")).filter(Boolean).join(", ")}.`,
      source: source(classification.made, `${classification.folder}/classification.json`),
    },
  );
}
