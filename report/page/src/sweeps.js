import { html } from "htl";

import { number, source } from "./format.js";
import { table } from "./table.js";

// The table of each sweep: what varies, and what the variants' datasets came to.
export function sweepSections({ sweeps }) {
  return sweeps.map((sweep, i) => ({ id: `sweep-${i}`, title: `Variants: ${sweep.name}`, content: () => content(sweep) }));
}

function content(sweep) {
  const results = Object.keys(sweep.variants[0] ?? {}).filter(
    (key) => !["variant", "values", "set"].includes(key) && sweep.variants.some((variant) => variant[key] !== null),
  );
  return html`${table(
    [
      ...sweep.keys.map((key) => ({ title: key, value: (variant) => variant.values[key] })),
      ...results.map((key) => ({
        title: key.replaceAll("_", " "),
        number: sweep.variants.some((variant) => typeof variant[key] === "number"),
        value: (variant) => variant[key],
        text: (variant) => (typeof variant[key] === "number" ? number(variant[key], 4) : variant[key] ?? "–"),
      })),
    ],
    sweep.variants,
  )}
  <p class="source">${source(sweep.made, `${sweep.folder}/sweep.json`)}</p>`;
}
