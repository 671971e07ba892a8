import * as Plot from "@observablehq/plot";
import { html } from "htl";

import { base, colors, figure, logScale } from "./figure.js";
import { number, percent, seconds, source } from "./format.js";
import { table } from "./table.js";

// What accuracy costs in time: one picture for each stage that was measured.
export function accuracySection(report) {
  const figures = [
    ...report.ladders.flatMap(modesFigures),
    ...firstOfName(report.datasets).filter((dataset) => solvedShapes(dataset).length > 0).map(bodiesFigure),
    ...report.ladders.flatMap(soundFigures),
    ...report.ladders.flatMap(featureFigures),
    ...report.damping.flatMap(fitFigures),
    ...report.classification.map(classifierFigure),
  ].filter(Boolean);
  const failed = failures(report);
  if (figures.length === 0 && failed.length === 0) return null;
  return {
    id: "accuracy",
    title: "What accuracy costs",
    content: html`<p>Seconds run across, the error runs down: lower is better, left is cheaper.</p>
      <div class="figures">${figures}</div>${missing(report)}
      ${failed.length > 0 ? html`<details open><summary class="bad">${failed.length} measurements failed</summary>${table([{ title: "what", value: (f) => f.what }, { title: "reason", value: (f) => f.reason }], failed)}</details>` : ""}`,
  };
}

// What could not be measured, and why.
function failures({ ladders, damping }) {
  const of = (what, reason) => (reason ? [{ what, reason }] : []);
  return [
    ...ladders.flatMap((ladder) => [
      ...of("sound", ladder.sound?.failure),
      ...of("features", ladder.features?.failure),
      ...(ladder.objects ?? []).flatMap((body) => [
        ...of(body.name, body.failure),
        ...(body.rungs ?? []).flatMap((rung) => of(`${body.name}, order ${rung.order}, size × ${rung.size_factor ?? "chosen"}`, rung.failure)),
      ]),
    ]),
    ...damping.flatMap((document) => (document.failures ?? []).flatMap((failure) => of(failure.task, failure.message))),
  ];
}

// What would fill the gaps.
function missing(report) {
  const none = (key) => !report.ladders.some((ladder) => (key === "objects" ? ladder.objects.length > 0 : ladder[key]));
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

const orders = new Map([1, 2, 3, 4].map((order, i) => [`order ${order}`, [colors[7], colors[1], colors[0], colors[2]][i]]));

function modesFigures(ladder) {
  const bodies = (ladder.objects ?? []).filter((body) => solved(body).length > 0);
  const all = bodies.flatMap(solved);
  const present = [...orders.keys()].filter((order) => all.some((rung) => `order ${rung.order}` === order));
  if (all.length === 0) return [];
  const x = logScale(all.map((rung) => rung.seconds), "seconds", (value) => number(value));
  const y = logScale(all.map((rung) => Math.max(rung.worst_cents, 1e-4)), "worst mode [cents]", (value) => number(value));
  return bodies.map((body) => {
    const rungs = solved(body).map((rung) => ({ ...rung, cents: Math.max(rung.worst_cents, 1e-4) }));
    const front = rungs.filter((rung) => rung.on_front).sort((a, b) => a.seconds - b.seconds);
    return figure(
      (width) =>
        Plot.plot(
          base(width, {
            height: 260,
            x,
            y,
            color: { type: "ordinal", domain: present, range: present.map((order) => orders.get(order)), legend: true },
            marks: [
              Plot.line(front, { x: "seconds", y: "cents", stroke: "currentColor", strokeOpacity: 0.6 }),
              Plot.dot(rungs, {
                x: "seconds",
                y: "cents",
                fill: (rung) => `order ${rung.order}`,
                r: 4,
                tip: true,
                title: (rung) =>
                  `order ${rung.order}, ${number(1000 * rung.element_size_m)} mm\nworst ${number(rung.worst_cents)} cents (estimated ${number(rung.estimated_worst_cents)})\nmedian ${number(rung.median_cents)} cents\n${seconds(rung.seconds)}, ${number(rung.unknowns, 6)} unknowns`,
              }),
            ],
          }),
        ),
      {
        narrow: true,
        title: `Modes: ${body.name}`,
        caption: body.half_the_error_costs ? `Half the error costs ${number(body.half_the_error_costs)} times the time (along the line).` : "",
        source: source(ladder.made, `${ladder.folder}/accuracy.json: ${ladder.modes} modes against a far finer reference`),
      },
    );
  });
}

function solved(body) {
  return (body.rungs ?? []).filter((rung) => rung.failure === undefined && rung.worst_cents !== undefined);
}

function solvedShapes(dataset) {
  return dataset.shapes.filter((shape) => shape.pitch_error_cents > 0 && shape.seconds > 0);
}

// Of a sweep's variants, whose bodies are mostly the same, the first.
function firstOfName(datasets) {
  return datasets.filter((dataset, i) => datasets.findIndex((other) => other.name === dataset.name) === i);
}

// Of a dataset's own bodies: estimates, as no reference is solved in a build.
function bodiesFigure(dataset) {
  const rows = solvedShapes(dataset);
  const families = [...new Set(rows.map((row) => row.family))];
  return figure(
    (width) =>
      Plot.plot(
        base(width, {
          height: 260,
          x: logScale(rows.map((row) => row.seconds), "seconds of the body's modes", (value) => number(value)),
          y: logScale(rows.map((row) => row.pitch_error_cents), "worst mode, estimated [cents]", (value) => number(value)),
          color: { domain: families, range: families.map((_, i) => colors[i % colors.length]), legend: families.length <= 10 },
          marks: [
            Plot.dot(rows, {
              x: "seconds",
              y: "pitch_error_cents",
              stroke: "family",
              r: 4,
              tip: true,
              title: (row) => `${row.id}\n${number(row.pitch_error_cents)} cents, ${seconds(row.seconds)}\norder ${row.order}, ${number(row.unknowns, 6)} unknowns`,
            }),
          ],
        }),
      ),
    {
      narrow: true,
      title: `Modes: the bodies of ${dataset.name}`,
      caption: "Each body at the setting of the build. Bodies whose modes came from the cache took no time for them.",
      source: source(dataset.made, `${dataset.folder}/trace.json and modes/`),
    },
  );
}

function soundFigures(ladder) {
  const rows = (ladder.sound?.rungs ?? []).filter((row) => row.error_db > 0);
  if (rows.length === 0) return [];
  return [...new Set(rows.map((row) => row.key))].map((key) => {
    const own = rows.filter((row) => row.key === key).sort((a, b) => a.value - b.value);
    return figure(
      (width) =>
        Plot.plot(
          base(width, {
            height: 260,
            marginRight: 50,
            x: logScale(own.map((row) => row.seconds), "seconds of one sound", (value) => seconds(value)),
            y: { label: "difference to the full sound [dB]", grid: true, zero: true, nice: true },
            marks: [
              Plot.line(own, { x: "seconds", y: "error_db", z: "body", stroke: colors[0], sort: "value" }),
              Plot.dot(own, { x: "seconds", y: "error_db", fill: colors[0], r: 4, tip: true, title: (row) => `${key} ${row.value}\n${number(row.error_db)} dB, ${seconds(row.seconds)}` }),
              Plot.text(own, { x: "seconds", y: "error_db", text: (row) => String(row.value), dx: 8, textAnchor: "start" }),
            ],
          }),
        ),
      {
        narrow: true,
        title: key === "modes" ? "Sound: modes that ring" : "Sound: order of a room's reflections",
        caption: `Numbers at the points: ${key === "modes" ? "the lowest so many modes" : "reflections on the way"}. Median over ${own[0].sounds} sounds of short-time spectra.`,
        source: source(ladder.made, `${ladder.folder}/accuracy.json: ${ladder.sound.body}`),
      },
    );
  });
}

function featureFigures(ladder) {
  const rows = (ladder.features?.rungs ?? []).filter((row) => row.bounds_frequency > 0);
  if (rows.length === 0) return [];
  const methods = [...new Set(rows.map((row) => row.method))];
  return [
    figure(
      (width) =>
        Plot.plot(
          base(width, {
            height: 260,
            marginRight: 40,
            x: logScale(rows.map((row) => row.seconds), "seconds of one clip", (value) => seconds(value)),
            y: logScale(rows.map((row) => row.bounds_frequency), "error of frequency [Cramér-Rao bounds]", (value) => number(value)),
            color: { domain: methods, range: colors, legend: true },
            marks: [
              Plot.ruleY([1], { strokeDasharray: "4 3" }),
              Plot.dot(rows, {
                x: "seconds",
                y: "bounds_frequency",
                fill: "method",
                r: 4,
                tip: true,
                title: (row) =>
                  `${row.method}, ${row.modes} modes at ${row.snr_db} dB\nfrequency ${number(row.bounds_frequency)}, decay rate ${number(row.bounds_decay_rate)} bounds\nfound ${percent(row.found)}\n${seconds(row.seconds)}`,
              }),
              Plot.text(rows, { x: "seconds", y: "bounds_frequency", text: (row) => String(row.modes), dx: 7, textAnchor: "start" }),
            ],
          }),
        ),
      {
        narrow: true,
        title: "Features of recordings",
        caption: "Median errors over the least that noise allows (1, dashed). Numbers at the points: modes of a clip.",
        source: source(ladder.made, `${ladder.folder}/accuracy.json: ${ladder.features.clips} clips each`),
      },
    ),
  ];
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
  const rows = classification.rows
    .filter((row) => row.training_s > 0)
    .map((row) => ({ ...row, error: Math.max(1 - row.accuracy.mean, 0.5 / row.samples) }));
  if (rows.length === 0) return null;
  const tasks = [...new Set(rows.map((row) => row.task))];
  return figure(
    (width) =>
      Plot.plot(
        base(width, {
          height: 300,
          x: logScale(rows.map((row) => row.training_s), "seconds of training", (value) => number(value)),
          y: logScale(rows.map((row) => row.error), "wrong answers, test part", (value) => percent(value)),
          color: { domain: tasks, range: colors, legend: true },
          marks: [
            Plot.dot(rows, {
              x: "training_s",
              y: "error",
              fill: "task",
              r: 4,
              tip: true,
              title: (row) => `${row.method} (${row.senses})\n${row.task}: ${percent(row.accuracy.mean)} right\ntrained in ${seconds(row.training_s)}`,
            }),
            Plot.text(rows, { x: "training_s", y: "error", text: "method", dy: -9, fontSize: 9, filter: () => width > 500 && rows.length <= 24 }),
          ],
        }),
      ),
    {
      title: `Classifiers: ${classification.name}`,
      caption: "Each point one method on one task.",
      source: source(classification.made, `${classification.folder}/classification.json`),
    },
  );
}
