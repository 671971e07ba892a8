import { html } from "htl";

import { accuracySection } from "./accuracy.js";
import { compareSection } from "./compare.js";
import { datasetSections } from "./dataset.js";
import { safely } from "./figure.js";
import { count } from "./format.js";
import { gallerySection } from "./gallery.js";
import { leaderboardSections } from "./leaderboards.js";
import { learningSections } from "./learning.js";
import { liveSection } from "./live.js";
import { nightlySections } from "./nightly.js";
import { samplesSection } from "./samples.js";
import { drawEverything } from "./seen.js";
import { sweepSections } from "./sweeps.js";

const report = JSON.parse(document.getElementById("report").textContent);

// Variants of a sweep have one name: their folders tell them apart.
for (const dataset of report.datasets) {
  const alike = report.datasets.filter((other) => other.name === dataset.name).length;
  dataset.label = alike > 1 ? `${dataset.name}, ${dataset.folder.split("/").pop()}` : dataset.name;
}

function outcome() {
  if (report.datasets.length === 0) return "";
  const failed = report.datasets.map((dataset) => dataset.failed);
  const sum = failed.reduce((a, b) => a + b, 0);
  if (sum === 0) return ", no task failed";
  return html`, <a class="bad" href=${`#failures-${failed.findIndex((count) => count > 0)}`}>${count(sum, "failed task")}</a>`;
}

function header() {
  const names = [...new Set(report.datasets.map((dataset) => dataset.name))];
  const title = names.length > 0 ? names.join(", ") : report.title;
  document.title = `${title} · Carillon report`;
  const sounds = report.datasets.reduce((sum, dataset) => sum + dataset.samples, 0);
  return html`<header>
    <p class="brand">Carillon report</p>
    <h1>${title}</h1>
    <p>${count(sounds, "sound")}${outcome()}. Made by <code>${report.made.command}</code> on ${report.made.date}, Carillon ${report.made.carillon},
      on ${report.made.processor}.</p>
    ${report.notes.map((note) => html`<p class="note bad">${note}</p>`)}
  </header>`;
}

// Sections are {id, title, content()}.
const sections = [liveSection, nightlySections, accuracySection, samplesSection, compareSection, gallerySection, sweepSections, datasetSections, leaderboardSections, learningSections]
  .flatMap((make) => make(report))
  .filter(Boolean);

document.getElementById("page").append(
  header(),
  html`<nav aria-label="Contents"><ul>${sections.map(({ id, title }) => html`<li><a href=${`#${id}`}>${title}</a>`)}</ul></nav>`,
  html`<div id="content" tabindex="-1">${sections.map(({ id, title, content }) => html`<section id=${id}><h2>${title}</h2>${safely(content)}</section>`)}</div>`,
);
// The address may name a section that was not there when the page was read.
document.getElementById(location.hash.slice(1).split("?")[0])?.scrollIntoView();

// Paper shows what is folded away.
let folded = [];
addEventListener("beforeprint", () => {
  folded = [...document.querySelectorAll("details:not([open])")];
  for (const details of folded) details.open = true;
  drawEverything();
});
addEventListener("afterprint", () => folded.forEach((details) => (details.open = false)));
