import * as Plot from "@observablehq/plot";
import { html } from "htl";

import { base, colors, figure, logScale } from "./figure.js";
import { number, percent, seconds } from "./format.js";

// Accuracy of two runs: each value a point with its interval, one run's below the other's.

// Those that differ most are drawn.
const max_rows = 30;

export function accuracyParts(pair) {
  const parts = [modes(pair), studies(pair), damping(pair), classification(pair)].filter(Boolean);
  return html`<h3>Accuracy</h3>${parts.length > 0 ? html`<div class="figures">${parts}</div>` : html`<p class="note">Neither objects, studies nor evaluations that both have.</p>`}`;
}

// Rows that both runs have, by `key`; `read(row)` gives {low, mid, high} of each.
function paired(lists, key, read) {
  const [first, second] = lists.map((rows) => new Map(rows.map((row) => [key(row), read(row)])));
  const both = [...first.keys()].filter((name) => second.has(name)).map((name) => ({ name, values: [first.get(name), second.get(name)] }));
  const complete = both.filter(({ values }) => values.every(({ low, mid, high }) => [low, mid, high].every((value) => Number.isFinite(value))));
  const apart = ({ values: [a, b] }) => Math.abs(Math.log((b.high + 1e-9) / (a.high + 1e-9)));
  return { all: complete, shown: [...complete].sort((a, b) => apart(b) - apart(a)).slice(0, max_rows) };
}

function intervals(pair, { all, shown }, { title, label, caption, format, linear = false }) {
  if (shown.length === 0) return null;
  const titles = pair.map((run) => run.title);
  const rows = shown.flatMap(({ name, values }) => values.map((value, i) => ({ name, run: titles[i], ...value })));
  const floor = Math.min(...rows.map((row) => row.mid).filter((value) => value > 0)) / 10;
  const drawn = (value) => (linear ? value : Math.max(value, floor));
  const x = linear ? { label, grid: true, tickFormat: format } : logScale(rows.flatMap((row) => [row.low, row.mid, row.high].map(drawn)), label, format);
  const better = all.filter(({ values: [a, b] }) => (linear ? b.mid > a.mid : b.mid < a.mid)).length;
  return figure(
    (width) =>
      Plot.plot(
        base(width, {
          height: 34 * shown.length + 90,
          marginLeft: Math.min(170, width / 3),
          x,
          y: { axis: null, domain: titles },
          fy: { label: null, domain: shown.map(({ name }) => name), padding: 0.2, tickFormat: (name) => name.slice(0, Math.max(12, Math.floor(width / 24))) },
          facet: { data: rows, y: "name" },
          color: { domain: titles, range: colors, legend: true },
          marks: [
            Plot.ruleY(rows, { x1: (row) => drawn(row.low), x2: (row) => drawn(row.high), y: "run", stroke: "run", strokeWidth: 2 }),
            Plot.dot(rows, { x: (row) => drawn(row.mid), y: "run", fill: "run", r: 4, tip: true, title: (row) => `${row.name}\n${row.run}: ${format(row.mid)} (${format(row.low)} to ${format(row.high)})` }),
          ],
        }),
      ),
    { title, caption: `${caption} The second run is ahead in ${better} of ${all.length}.${all.length > shown.length ? ` Those ${shown.length} are drawn that differ most.` : ""}` },
  );
}

// Errors of a dataset's objects, as the build estimated them.
function modes(pair) {
  if (!pair.every(({ dataset }) => dataset)) return null;
  const read = ({ median_pitch_error_cents: median, pitch_error_cents: worst }) => ({ low: median, mid: worst, high: worst });
  const shapes = pair.map(({ dataset }) => dataset.shapes.filter((shape) => shape.pitch_error_cents !== null));
  return intervals(pair, paired(shapes, (shape) => shape.id, read), {
    title: "Objects of both",
    label: "estimated pitch error [cents]",
    caption: "The point is the worst mode, the line goes down to the median one.",
    format: (value) => number(value, 2),
  });
}

function studies(pair) {
  if (!pair.every(({ study }) => study)) return null;
  const levels = pair.map(({ study }) =>
    (study.objects ?? []).flatMap((object) => (object.levels ?? []).filter((level) => level.worst_cents > 0).map((level) => ({ ...level, name: `${object.name}, order ${level.order}, × ${level.size_factor ?? "chosen"}` }))),
  );
  return intervals(pair, paired(levels, (level) => level.name, ({ median_cents, worst_cents }) => ({ low: median_cents, mid: worst_cents, high: worst_cents })), {
    title: "Levels of both studies",
    label: "pitch error [cents]",
    caption: "Against each study's reference: the point is the worst mode, the line goes down to the median one.",
    format: (value) => number(value, 2),
  });
}

function damping(pair) {
  if (!pair.every((run) => run.damping)) return null;
  const key = (row) => `${row.parameter}, ${row.estimator}, ${row.sounds} sounds, ${row.condition}, ${row.features}, of ${row.from}`;
  const rows = pair.map((run) => run.damping.errors.filter((row) => row.material === "all"));
  return intervals(pair, paired(rows, key, (row) => ({ low: row.lower_quartile, mid: row.median, high: row.upper_quartile })), {
    title: "Damping found again",
    label: "relative error",
    caption: "Medians, with quartiles.",
    format: (value) => percent(value),
  });
}

function classification(pair) {
  if (!pair.every((run) => run.classification)) return null;
  const key = (row) => `${row.task}, ${row.method} (${row.modalities})`;
  const read = ({ accuracy, training_s }) => {
    const [low, high] = accuracy.interval95 ?? [accuracy.mean, accuracy.mean];
    return { low, mid: accuracy.mean, high, training: seconds(training_s) };
  };
  return intervals(pair, paired(pair.map((run) => run.classification.rows), key, read), {
    title: "Told apart",
    label: "right answers, test part",
    caption: "Accuracies with their 95 % intervals.",
    format: (value) => percent(value),
    linear: true,
  });
}
