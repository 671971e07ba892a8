import { html } from "htl";

import { accuracySection } from "./accuracy.js";
import { datasetSections } from "./dataset.js";
import { count } from "./format.js";
import { gallerySection } from "./gallery.js";
import { learningSections } from "./learning.js";
import { nightSections } from "./nights.js";
import { samplesSection } from "./samples.js";
import { sweepSections } from "./sweeps.js";

const report = JSON.parse(document.getElementById("report").textContent);

// Variants of a sweep have one name: their folders tell them apart.
for (const dataset of report.datasets) {
  const alike = report.datasets.filter((other) => other.name === dataset.name).length;
  dataset.label = alike > 1 ? `${dataset.name}, ${dataset.folder.split("/").pop()}` : dataset.name;
}

function header() {
  const names = [...new Set(report.datasets.map((dataset) => dataset.name))];
  const title = names.length > 0 ? names.join(", ") : report.title;
  document.title = `${title} · Carillon report`;
  const sounds = report.datasets.reduce((sum, dataset) => sum + dataset.samples, 0);
  const failed = report.datasets.reduce((sum, dataset) => sum + dataset.failures.length, 0);
  return html`<header>
    <p class="brand">Carillon report</p>
    <h1>${title}</h1>
    <p>${sounds > 0 ? `${count(sounds, "sound")}, ` : ""}${failed > 0 ? html`<a class="bad" href="#failures-0">${count(failed, "failed task")}</a>` : "no task failed"}.
      Made by <code>${report.made.command}</code> on ${report.made.date}, Carillon ${report.made.version},
      ${report.made.processor}.</p>
    ${report.notes.map((note) => html`<p class="note">${note}</p>`)}
  </header>`;
}

// Sections are {id, title, content}; those without content are left out.
const sections = [
  ...nightSections(report),
  accuracySection(report),
  samplesSection(report),
  gallerySection(report),
  ...sweepSections(report),
  ...datasetSections(report),
  ...learningSections(report),
].filter(Boolean);

document.getElementById("page").append(
  header(),
  html`<nav aria-label="Contents"><ul>${sections.map(({ id, title }) => html`<li><a href=${`#${id}`}>${title}</a>`)}</ul></nav>`,
  ...sections.map(({ id, title, content }) => html`<section id=${id}><h2>${title}</h2>${content}</section>`),
);
// The address may name a section that was not there when the page was read.
if (location.hash) document.querySelector(location.hash)?.scrollIntoView();
