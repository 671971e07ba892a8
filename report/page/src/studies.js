import * as Plot from "@observablehq/plot";
import { html } from "htl";

import { base, colors, figure, logScale } from "./figure.js";
import { number, percent, seconds, source } from "./format.js";
import { table } from "./table.js";

// Figures and tables of what `carillon accuracy` measured.

// What is less is drawn there: nearer to the reference than rounding.
const minCents = 1e-4;

const orders = new Map([1, 2, 3, 4].map((order, i) => [`order ${order}`, [colors[7], colors[1], colors[0], colors[2]][i]]));

export function modesFigures(study) {
  const objects = (study.objects ?? []).filter((object) => solved(object).length > 0);
  const all = objects.flatMap(solved);
  const present = [...orders.keys()].filter((order) => all.some((level) => `order ${level.order}` === order));
  if (all.length === 0) return [];
  const x = logScale(all.map((level) => level.seconds), "seconds", (value) => number(value));
  const y = logScale(all.map((level) => Math.max(level.worst_cents, minCents)), "worst mode [cents]", (value) => number(value));
  return objects.map((object) => {
    const levels = solved(object).map((level) => ({ ...level, cents: Math.max(level.worst_cents, minCents) }));
    const front = levels.filter((level) => level.on_front).sort((a, b) => a.seconds - b.seconds);
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
              Plot.dot(levels, {
                x: "seconds",
                y: "cents",
                fill: (level) => `order ${level.order}`,
                r: 4,
                tip: true,
                title: (level) =>
                  `order ${level.order}, ${number(1000 * level.element_size_m)} mm\nworst ${number(level.worst_cents)} cents (estimated ${number(level.estimated_worst_cents)})\nmedian ${number(level.median_cents)} cents\n${seconds(level.seconds)}, ${number(level.unknowns, 6)} unknowns`,
              }),
            ],
          }),
        ),
      {
        narrow: true,
        title: `Modes: ${object.name}`,
        caption: [
          object.half_the_error_costs ? `Half the error costs ${number(object.half_the_error_costs)} times the time (along the line).` : "",
          levels.some((level) => level.worst_cents < minCents) ? `Errors below ${number(minCents)} cents are drawn there.` : "",
        ].join(" "),
        source: source(study.made, `${study.folder}/accuracy.json: ${study.modes} modes against a far finer reference`),
      },
    );
  });
}

// The same as numbers, and what a target in cents led to.
export function levelsTables(study) {
  const rows = (study.objects ?? []).flatMap((object) => solved(object).map((level) => ({ object, ...level })));
  const chosen = (study.objects ?? []).flatMap((object) => (object.chosen ?? []).map((choice) => ({ object, ...choice, reached: object.levels?.[choice.level]?.worst_cents })));
  if (rows.length === 0) return [];
  const cents = (title, value) => ({ title, number: true, value, text: (row) => (value(row) === null || value(row) === undefined ? "–" : `${number(value(row))} cents`) });
  const objectOf = { title: "object", value: (row) => row.object.name };
  const time = { title: "time", number: true, value: (row) => row.seconds, text: (row) => seconds(row.seconds) };
  return [
    chosen.length > 0
      ? html`<details><summary>What a target chose: ${study.name}</summary>${table(
          [
            objectOf,
            cents("asked for", (row) => row.asked_cents),
            cents("true error", (row) => row.reached),
            { title: "met", value: (row) => String(row.met), text: (row) => (row.failure ? html`<span class="bad">${row.failure}</span>` : row.met ? "yes" : "no") },
            time,
            { title: "again", value: (row) => row.command ?? "", text: (row) => (row.command ? html`<code>${row.command}</code>` : "–") },
          ],
          chosen,
        )}</details>`
      : "",
    html`<details><summary>${rows.length} levels as numbers: ${study.name}</summary>${table(
      [
        objectOf,
        { title: "order", number: true, value: (row) => row.order },
        { title: "element size", number: true, value: (row) => row.element_size_m, text: (row) => `${number(1000 * row.element_size_m)} mm` },
        { title: "unknowns", number: true, value: (row) => row.unknowns, text: (row) => number(row.unknowns, 6) },
        time,
        cents("worst mode", (row) => row.worst_cents),
        cents("worst, as estimated", (row) => row.estimated_worst_cents),
        cents("median mode", (row) => row.median_cents),
        { title: "none is cheaper and better", value: (row) => (row.on_front ? "yes" : "") },
      ],
      rows,
      { max: 400 },
    )}<p class="source">${source(study.made, `${study.folder}/accuracy.json`)}</p></details>`,
  ];
}

function solved(object) {
  return (object.levels ?? []).filter((level) => level.failure === undefined && level.worst_cents !== undefined);
}

export function soundFigures(study) {
  const rows = (study.sound?.levels ?? []).filter((row) => row.error_db > 0);
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
              Plot.line(own, { x: "seconds", y: "error_db", z: "object", stroke: colors[0], sort: "value" }),
              Plot.dot(own, { x: "seconds", y: "error_db", fill: colors[0], r: 4, tip: true, title: (row) => `${key} ${row.value}\n${number(row.error_db)} dB, ${seconds(row.seconds)}` }),
              Plot.text(own, { x: "seconds", y: "error_db", text: (row) => String(row.value), dx: 8, textAnchor: "start" }),
            ],
          }),
        ),
      {
        narrow: true,
        title: key === "modes" ? "Sound: modes that ring" : "Sound: order of a room's reflections",
        caption: `Numbers at the points: ${key === "modes" ? "the lowest so many modes" : "reflections on the way"}. Median over ${own[0].sounds} sounds of short-time spectra.`,
        source: source(study.made, `${study.folder}/accuracy.json: ${study.sound.object}`),
      },
    );
  });
}

export function featureFigures(study) {
  const all = study.features?.levels ?? [];
  const rows = all.filter((row) => row.bounds_frequency > 0);
  if (rows.length === 0) return [];
  const methods = [...new Set(rows.map((row) => row.method))];
  const levels = [...new Set(rows.map((row) => row.snr_db))].sort((a, b) => b - a);
  const missed = all.filter((row) => !(row.found >= 0.95));
  const what = (row) => `${row.method}, ${row.modes} modes at ${row.snr_db} dB`;
  const picture = (key, quantity) =>
    figure(
      (width) =>
        Plot.plot(
          base(width, {
            height: 260,
            marginRight: 40,
            x: logScale(rows.map((row) => row.seconds), "seconds of one clip", (value) => seconds(value)),
            y: logScale([1, ...rows.map((row) => row[key])], `error of ${quantity} [Cramér-Rao bounds]`, (value) => number(value)),
            color: { domain: methods, range: colors, legend: true },
            symbol: { domain: levels, range: ["circle", "triangle", "square", "diamond", "star", "cross"], legend: true, tickFormat: (level) => `${level} dB` },
            marks: [
              Plot.ruleY([1], { strokeDasharray: "4 3" }),
              Plot.dot(rows, {
                x: "seconds",
                y: key,
                fill: "method",
                symbol: "snr_db",
                r: 4,
                tip: true,
                title: (row) =>
                  `${what(row)}\nfrequency ${number(row.bounds_frequency)}, decay rate ${number(row.bounds_decay_rate)} bounds\nfound ${percent(row.found)}\n${seconds(row.seconds)}`,
              }),
              Plot.text(rows, { x: "seconds", y: key, text: (row) => String(row.modes), dx: 7, textAnchor: "start" }),
            ],
          }),
        ),
      {
        narrow: true,
        title: `Features of recordings: ${quantity}`,
        caption: `Median errors of the modes that are found, over the least that noise allows (1, dashed); a shape for each ratio of signal to noise. Numbers at the points: modes of a clip.${
          missed.length > 0 ? ` Not all modes are found: ${missed.map((row) => `${what(row)}, ${percent(row.found, 2)}`).join("; ")}.` : " At least 95 % of the modes are found everywhere."
        }`,
        source: source(study.made, `${study.folder}/accuracy.json: ${study.features.clips} clips each`),
      },
    );
  return [picture("bounds_frequency", "frequency"), picture("bounds_decay_rate", "decay rate")];
}
