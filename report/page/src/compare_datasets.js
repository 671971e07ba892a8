import * as Plot from "@observablehq/plot";
import { html } from "htl";
import { load } from "js-yaml";

import { heardOf } from "./clip.js";
import { base, colors, figure } from "./figure.js";
import { bytes, count, number, seconds } from "./format.js";
import { labelText, soundCard } from "./sound_card.js";
import { table } from "./table.js";

// Two datasets: what differs in configuration, counts, time and sound.

const text = (value) => (value === undefined ? "–" : Array.isArray(value) ? `[${value.map(text).join(", ")}]` : typeof value === "string" ? value : JSON.stringify(value));

// {"objects[0].count": 2, ...} of a document; lists of plain values stay whole.
function flattened(value, path = "", flat = new Map()) {
  const is_plain = (one) => one === null || typeof one !== "object";
  if (is_plain(value) || (Array.isArray(value) && value.every(is_plain))) return flat.set(path, value);
  for (const [key, inner] of Object.entries(value)) {
    flattened(inner, Array.isArray(value) ? `${path}[${key}]` : path ? `${path}.${key}` : key, flat);
  }
  return flat;
}

// Of rows {name, values: [a, b]} a table, with the second over the first.
function pairTable(titles, rows, caption) {
  return table(
    [
      { title: "what", value: (row) => row.name },
      ...titles.map((title, i) => ({ title, number: true, value: (row) => row.values[i], text: (row) => (row.format ?? text)(row.values[i]) })),
      { title: "second / first", number: true, value: ({ values: [a, b] }) => b / a, text: ({ values: [a, b] }) => (a > 0 && Number.isFinite(b / a) ? number(b / a) : "–") },
    ],
    rows,
    { caption },
  );
}

export function configurationPart(datasets) {
  const [first, second] = datasets.map(({ configuration, versions }) => flattened({ ...load(configuration), versions }));
  const keys = [...new Set([...first.keys(), ...second.keys()])];
  const differ = keys.filter((key) => text(first.get(key)) !== text(second.get(key)));
  const columns = [{ title: "key", value: (key) => key, text: (key) => html`<code>${key}</code>` }, ...datasets.map(({ title }, i) => ({ title, value: (key) => text([first, second][i].get(key)) }))];
  return html`<h3>Configuration</h3>
    ${differ.length > 0 ? table(columns, differ, { caption: "Keys that differ", max: 400 }) : ""}
    <p class="note">${count(keys.length - differ.length, "key")} ${keys.length - differ.length === 1 ? "is" : "are"} the same in both.</p>`;
}

export function countsPart(datasets) {
  const of = (read) => datasets.map(read);
  const targets = of((d) => d.missed_pitch_targets ?? undefined);
  const rows = [
    { name: "sounds", values: of((d) => d.samples) },
    { name: "objects", values: of((d) => d.objects) },
    { name: "materials", values: of((d) => d.materials.length) },
    { name: "failed tasks", values: of((d) => d.failed) },
    { name: "warnings", values: of((d) => d.warned) },
    { name: "missed pitch targets", values: targets },
    { name: "on disk", values: of((d) => d.bytes), format: bytes },
  ];
  return html`<h3>Counts and failures</h3>${pairTable(of((d) => d.title), rows, "Counts")}${failures(datasets)}`;
}

// Tasks that failed in one of the two, or for another reason.
function failures(datasets) {
  const reasons = datasets.map((dataset) => new Map(dataset.failures.map((failure) => [failure.task, failure.message])));
  const tasks = [...new Set(reasons.flatMap((one) => [...one.keys()]))].filter((task) => reasons[0].get(task) !== reasons[1].get(task));
  if (tasks.length === 0) return "";
  return table([{ title: "task", value: (task) => task, text: (task) => html`<code>${task}</code>` }, ...datasets.map(({ title }, i) => ({ title, value: (task) => reasons[i].get(task) ?? "done" }))], tasks, {
    caption: "Tasks that failed in one alone, or for another reason",
  });
}

export function timePart(datasets) {
  const titles = datasets.map(({ title }) => title);
  const sum = (read) => datasets.map((dataset) => (dataset.ranks.length > 0 ? dataset.ranks.map(read).reduce((a, b) => a + b, 0) : undefined));
  const ranks = [
    { name: "ranks", values: datasets.map((dataset) => dataset.ranks.length) },
    { name: "in tasks, all runs", values: datasets.map((dataset) => dataset.task_seconds), format: seconds },
    { name: "in tasks, last run", values: sum((rank) => rank.busy_s), format: seconds },
    { name: "computing", values: sum((rank) => rank.cpu_s), format: seconds },
    { name: "waiting for a processor", values: sum((rank) => rank.queued_s), format: seconds },
    { name: "without a task", values: sum((rank) => rank.idle_s), format: seconds },
    { name: "most memory of a rank", values: datasets.map((dataset) => Math.max(0, ...dataset.ranks.map((rank) => rank.peak_memory_bytes))), format: bytes },
  ];
  const effects = datasets.map((dataset) => Object.fromEntries(dataset.effects.filter((effect) => effect.calls > 0).map((effect) => [effect.name, effect])));
  return html`<h3>Time</h3>${stages(datasets, titles)}
    ${pairTable(titles, secondsOf(effects), "Effects, seconds on all ranks")}
    ${pairTable(titles, ranks, "Ranks")}`;
}

function secondsOf(entries) {
  const names = [...new Set(entries.flatMap((one) => Object.keys(one)))];
  return names.map((name) => ({ name, values: entries.map((one) => one[name]?.seconds), format: seconds })).filter(({ values }) => values.some((value) => value > 0));
}

function stages(datasets, titles) {
  const rows = secondsOf(datasets.map((dataset) => dataset.stages)).sort((a, b) => Math.max(...b.values.map((v) => v ?? 0)) - Math.max(...a.values.map((v) => v ?? 0)));
  if (rows.length === 0) return "";
  const bars = rows.flatMap(({ name, values }) => values.map((value, i) => ({ name, run: titles[i], seconds: value ?? 0 })));
  return html`${figure(
    (width) =>
      Plot.plot(
        base(width, {
          height: 34 * rows.length + 90,
          marginLeft: 110,
          marginRight: 70,
          x: { label: "seconds on all ranks", grid: true, ticks: Math.max(2, Math.floor(width / 120)) },
          y: { axis: null, domain: titles },
          fy: { label: null, domain: rows.map(({ name }) => name), padding: 0.15 },
          color: { domain: titles, range: colors, legend: true },
          marks: [
            Plot.barX(bars, { x: "seconds", y: "run", fy: "name", fill: "run", title: (bar) => `${bar.name}, ${bar.run}: ${seconds(bar.seconds)}` }),
            Plot.text(bars, { x: "seconds", y: "run", fy: "name", text: (bar) => seconds(bar.seconds), textAnchor: "start", dx: 4 }),
          ],
        }),
      ),
    { title: "Stages of both" },
  )}${pairTable(titles, rows, "Stages, seconds on all ranks")}`;
}

export function soundPart(datasets) {
  const titles = datasets.map(({ title }) => title);
  const [first, second] = datasets.map((dataset) => new Map(dataset.heard.map((sample) => [sample.key, sample])));
  const keys = [...first.keys()].filter((key) => second.has(key));
  if (keys.length === 0) return html`<h3>Sound</h3><p class="note">None of the samples to hear is in both. <code>carillon report --sounds</code> with a larger number puts more of them on the page.</p>`;
  return html`<h3>Sound</h3>
    <p>Samples of the same keys. Level and reverberation time (T20, Schroeder's backward integration) are those of the clips on this page, before they were turned to the same peak.</p>
    ${keys.map((key) => soundPair([first.get(key), second.get(key)], titles))}`;
}

function soundPair(samples, titles) {
  const heard = samples.map(heardOf);
  const unit = (name) => (value) => (value === undefined ? "–" : `${number(value)} ${name}`);
  const names = [...new Set(samples.flatMap((sample) => Object.keys(sample.labels)))];
  const rows = [
    { name: "level", values: heard.map(({ level }) => level), format: unit("dB") },
    { name: "reverberation time", values: heard.map(({ decay }) => decay), format: unit("s") },
    ...names
      .filter((name) => samples[0].labels[name] !== samples[1].labels[name])
      .map((name) => ({ name: name.replaceAll("_", " "), values: samples.map((sample) => sample.labels[name] ?? undefined), format: (value) => labelText(value ?? "–") })),
  ];
  const difference = ([a, b]) => (typeof a === "number" && typeof b === "number" ? b - a : undefined);
  return html`<div class="pair"><h4>${samples[0].key}</h4>
    <div class="cards">${samples.map((sample, i) => html`<div><p class="note">${titles[i]}</p>${soundCard(sample)}</div>`)}</div>
    ${table(
      [
        { title: "what", value: (row) => row.name },
        ...titles.map((title, i) => ({ title, number: true, value: (row) => row.values[i], text: (row) => row.format(row.values[i]) })),
        { title: "second - first", number: true, value: (row) => difference(row.values), text: (row) => (difference(row.values) === undefined ? "–" : row.format(difference(row.values))) },
      ],
      rows,
      { caption: `What differs between the two of ${samples[0].key}` },
    )}</div>`;
}
