import { html } from "htl";

import { whenSized } from "./seen.js";

// What make() gives; where it throws, what is wrong in its place, so that the rest is shown.
export function safely(make) {
  try {
    return make();
  } catch (error) {
    return html`<p class="note bad">This part cannot be drawn: ${error.message}</p>`;
  }
}

// A chart that is drawn anew for every width it gets, with what it shows and where its numbers come
// from. draw(width) gives an SVG element.
export function figure(draw, { title, caption, source, narrow = false } = {}) {
  const box = html`<div class="chart"></div>`;
  const drawing = (width) => {
    const drawn = draw(width);
    const svg = drawn.matches("svg") ? drawn : drawn.querySelector(":scope > svg");
    svg.setAttribute("role", "img");
    svg.setAttribute("aria-label", title ?? "Chart");
    // Names of marks within a picture are no one's; ARIA has none for groups without a role.
    for (const group of drawn.querySelectorAll("g[aria-label]")) group.removeAttribute("aria-label");
    return drawn;
  };
  whenSized(box, (width) => box.replaceChildren(safely(() => drawing(width))));
  return html`<figure class=${narrow ? "narrow" : ""}>
    ${title ? html`<h4>${title}</h4>` : ""}
    ${box}
    <figcaption>${caption ?? ""} ${source ? html`<span class="source">${source}</span>` : ""}</figcaption>
  </figure>`;
}

// What all charts have in common.
export const base = (width, options) => ({
  width,
  marginBottom: 44,
  marginLeft: 52,
  marginTop: 28,
  style: { background: "transparent", fontFamily: "inherit", fontSize: "12px" },
  ...options,
});

// Okabe and Ito's colours, told apart by everyone, in shades that show on white and on black.
export const colors = ["#0072B2", "#E69F00", "#009E73", "#CC79A7", "#D55E00", "#56B4E9", "#8A7A00", "#7F7F7F"];

// Ticks of a logarithmic axis: powers of ten alone where there are many, more between them where there
// is less than one.
export function logTicks([low, high]) {
  const ticks = [];
  const decades = Math.log10(high / low);
  const steps = decades > 4 ? [1] : decades > 1.5 ? [1, 3] : decades > 0.8 ? [1, 2, 5] : [1, 1.5, 2, 3, 4, 5, 6, 8];
  for (let power = Math.floor(Math.log10(low)); power <= Math.ceil(Math.log10(high)); ++power) {
    for (const step of steps) {
      const tick = step * 10 ** power;
      if (tick >= low && tick <= high) ticks.push(tick);
    }
  }
  return ticks;
}

export function logScale(values, label, format) {
  const finite = values.filter((value) => value > 0 && Number.isFinite(value));
  const domain = [Math.min(...finite) / 1.25, Math.max(...finite) * 1.25];
  return { type: "log", domain, ticks: logTicks(domain), tickFormat: format, label, labelOffset: 40, grid: true };
}
