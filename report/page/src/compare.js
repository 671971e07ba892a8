import { html } from "htl";

import { accuracyParts } from "./compare_accuracy.js";
import { configurationPart, countsPart, soundPart, timePart } from "./compare_datasets.js";
import { safely } from "./figure.js";

// Two datasets, studies or evaluations of the page side by side: #compare?a=FOLDER&b=FOLDER.
export function compareSection(report) {
  const runs = runsOf(report);
  if (runs.length < 2) return null;
  return { id: "compare", title: "Two runs side by side", content: () => chooser(runs) };
}

// What lies in one folder belongs together: a dataset, its evaluation, a study.
function runsOf(report) {
  const runs = new Map();
  for (const [kind, documents] of Object.entries({ dataset: report.datasets, study: report.studies, damping: report.damping, classification: report.classification })) {
    for (const document of documents) {
      const folder = document.folder.replace(/\/evaluation$/, "");
      const run = runs.get(folder) ?? { folder, label: document.label ?? document.name ?? folder };
      runs.set(folder, { ...run, [kind]: document });
    }
  }
  const all = [...runs.values()];
  // Figures tell runs apart by their labels.
  for (const run of all) run.title = all.filter(({ label }) => label === run.label).length > 1 ? run.folder : run.label;
  return all;
}

function chooser(runs) {
  const choice = (label, chosen) => {
    const select = html`<select name=${label}>${runs.map((run, i) => html`<option value=${run.folder} selected=${i === chosen}>${run.title}</option>`)}</select>`;
    return { select, element: html`<label>${label}${select}</label>` };
  };
  const [a, b] = [choice("First run", 0), choice("Second run", 1)];
  const place = html`<div aria-live="polite"></div>`;
  const form = html`<form class="choices">${a.element}${b.element}<div class="buttons"><button type="submit">Compare</button></div></form>`;
  form.onsubmit = (event) => {
    event.preventDefault();
    location.hash = `#compare?${new URLSearchParams({ a: a.select.value, b: b.select.value })}`;
  };
  const follow = () => {
    const [name, query] = location.hash.slice(1).split("?");
    if (name !== "compare" || !query) return;
    const asked = new URLSearchParams(query);
    const pair = ["a", "b"].map((key) => runs.find(({ folder }) => folder === asked.get(key)));
    if (pair.includes(undefined)) {
      place.replaceChildren(html`<p class="note bad">The page has no run ${asked.get(pair[0] ? "b" : "a") ?? "of that name"}.</p>`);
      return;
    }
    [a, b].forEach(({ select }, i) => (select.value = pair[i].folder));
    place.replaceChildren(comparison(pair));
    document.getElementById("compare")?.scrollIntoView();
  };
  addEventListener("hashchange", follow);
  follow();
  return html`<p>Where two runs of this page differ: configuration, time, accuracy, counts, sound.</p>${form}${place}`;
}

function comparison(pair) {
  if (pair[0] === pair[1]) return html`<p class="note">That is one run twice: it does not differ from itself.</p>`;
  const datasets = pair.map(({ dataset, title }) => dataset && { ...dataset, title });
  const parts = [
    ...(datasets.every(Boolean) ? [configurationPart, countsPart, timePart].map((part) => () => part(datasets)) : []),
    () => accuracyParts(pair),
    ...(datasets.every(Boolean) ? [() => soundPart(datasets)] : []),
  ];
  return html`<div>${parts.map(safely)}</div>`;
}
