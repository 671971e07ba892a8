import * as Plot from "@observablehq/plot";

import { base, colors, figure, logScale } from "./figure.js";
import { number, seconds, source } from "./format.js";

const solved = (shape) => shape.pitch_error_cents > 0 && shape.seconds > 0;

// What accuracy cost in time: each object's seconds against the error bar of its worst mode. Estimates, as no
// reference is solved in a build. Null where nothing of it is known.
export function costFigure(dataset, { title, narrow = false }) {
  const target = dataset.pitch_target_cents;
  const shapes = dataset.shapes.filter(solved);
  if (shapes.length === 0) return null;
  const key = new Set(shapes.map((shape) => shape.family)).size > 1 ? "family" : "material";
  const kinds = mostFrequent(shapes.map((shape) => shape[key]));
  const rows = shapes.map((shape) => ({ ...shape, kind: kinds.includes(shape[key]) ? shape[key] : "others", missed: target !== null && shape.pitch_error_cents > target }));
  const missed = rows.filter((row) => row.missed).length;
  return figure(
    (width) =>
      Plot.plot(
        base(width, {
          height: narrow ? 260 : 340,
          x: logScale(rows.map((row) => row.seconds), "seconds of the object's modes", (value) => number(value)),
          y: logScale([...rows.map((row) => row.pitch_error_cents), ...(target === null ? [] : [target])], "worst mode's error bar [cents]", (value) => number(value)),
          color: { domain: [...kinds, ...(rows.some((row) => row.kind === "others") ? ["others"] : [])], range: colors, legend: true },
          marks: [
            ...(target === null ? [] : [
              Plot.ruleY([target], { strokeDasharray: "6 4", className: "target" }),
              Plot.text([target], { y: (value) => value, frameAnchor: "right", text: (value) => `pitch target, ${number(value)} cents`, textAnchor: "end", dy: -7 }),
            ]),
            Plot.dot(rows, {
              className: "objects",
              x: "seconds",
              y: "pitch_error_cents",
              stroke: "kind",
              strokeWidth: 2,
              symbol: (row) => (row.missed ? "times" : "circle"),
              r: 4,
              tip: true,
              title: (row) => `${row.id}, ${row.material}\n${number(row.pitch_error_cents)} cents, ${seconds(row.seconds)}\norder ${row.order}, ${number(row.unknowns, 6)} unknowns`,
            }),
          ],
        }),
      ),
    {
      narrow,
      title,
      caption: `Each object by its ${key}, at the setting of the build: meshing, solving and estimating its errors. ${said(target, missed)} Objects whose modes came from the cache took no time for them.`,
      source: source(dataset.made, `${dataset.folder}/trace.json and modes/`),
    },
  );
}

function said(target, missed) {
  if (target === null) return "The build had no pitch target.";
  return missed === 0 ? "All are within the pitch target." : `Crosses missed the pitch target: ${missed}.`;
}

// As many as there are colours, with one left for the others.
function mostFrequent(names) {
  const counts = new Map();
  for (const name of names) counts.set(name, (counts.get(name) ?? 0) + 1);
  const all = [...counts.keys()];
  if (all.length <= colors.length) return all;
  return all.sort((a, b) => counts.get(b) - counts.get(a)).slice(0, colors.length - 1);
}
