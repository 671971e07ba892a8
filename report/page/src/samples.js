import { html } from "htl";

import { count } from "./format.js";
import { whenSeen } from "./seen.js";
import { labelText, openButton, soundCard, thumbnail } from "./sound_card.js";
import { ordered, table } from "./table.js";

export function samplesSection({ datasets }) {
  const all = datasets.flatMap((dataset) => dataset.heard.map((sample) => ({ dataset, ...sample })));
  if (all.length === 0) return null;
  return {
    id: "samples",
    title: "Samples to hear",
    content: () => html`<p>Chosen evenly from the datasets. Each is turned to the same peak, and <em>played at</em> says by how much.
      Spectrograms: 60 Hz to half the sample rate, of the loudest 80 dB, first channel.</p>
      ${choice(all, datasets.length > 1)}`,
  };
}

// More are asked for as text.
const most_choices = 30;

// Samples by what is looked for, as cards or as a table, in the order of any column.
function choice(all, several) {
  const columns = columnsOf(all, several);
  const state = { text: "", labels: new Map(), order: {}, view: "cards" };
  const place = html`<div></div>`;
  const said = html`<p class="note" role="status"></p>`;
  const cards = new Map();
  const cardOf = (sample) => cards.get(sample) ?? cards.set(sample, soundCard(sample)).get(sample);
  const has = (sample, words) => {
    const text = columns.map((column) => column.value(sample) ?? "").join("\n").toLowerCase();
    return words.every((word) => text.includes(word));
  };
  const show = () => {
    const words = state.text.toLowerCase().split(/\s+/);
    const found = all.filter((sample) => has(sample, words) && [...state.labels].every(([title, wanted]) => wanted === "" || wordOf(columns, title, sample) === wanted));
    said.textContent = found.length < all.length ? `${found.length} of ${count(all.length, "sample")}` : count(all.length, "sample");
    place.replaceChildren(state.view === "cards" ? html`<div class="cards">${ordered(columns, found, state.order).map(cardOf)}</div>` : tableOf(columns, found, state.order));
    for (const button of buttons) button.setAttribute("aria-pressed", String(button.value === state.view));
    sortBy.value = state.order.title ?? "";
    down.checked = Boolean(state.order.down);
  };
  const buttons = ["cards", "table"].map((view) => {
    const button = html`<button type="button" value=${view}>${view === "cards" ? "Cards" : "Table"}</button>`;
    button.onclick = () => {
      state.view = view;
      show();
    };
    return button;
  });
  const search = html`<input type="search" name="filter">`;
  search.oninput = () => {
    state.text = search.value.trim();
    show();
  };
  const labels = columns.filter((column) => !column.number || column.title === "size").map((column) => labelFilter(column, all, state, show));
  const sortBy = html`<select name="order"><option value="">as chosen</option>${columns.map(({ title }) => html`<option>${title}</option>`)}</select>`;
  const down = html`<input type="checkbox" name="down">`;
  sortBy.onchange = down.onchange = () => {
    state.order = sortBy.value ? { title: sortBy.value, down: down.checked } : {};
    show();
  };
  show();
  return html`<div role="search" aria-label="Samples" class="choices">
    <label>Filter by any text${search}</label>${labels}
    <label>Order by${sortBy}</label><label class="check">${down} largest first</label>
    </div><div class="buttons bar">${buttons}${said}</div>${place}`;
}

function columnsOf(all, several) {
  const names = [...new Set(all.flatMap((sample) => Object.keys(sample.labels)))];
  return [
    { title: "key", value: (sample) => sample.key, names: true },
    ...(several ? [{ title: "dataset", value: (sample) => sample.dataset.label }] : []),
    { title: "object", value: (sample) => sample.object },
    ...names.map((name) => ({
      title: name.replaceAll("_", " "),
      value: (sample) => sample.labels[name],
      text: (sample) => labelText(sample.labels[name] ?? "–"),
      number: all.every((sample) => typeof (sample.labels[name] ?? 0) === "number"),
    })),
  ];
}

const wordOf = (columns, title, sample) => String(columns.find((column) => column.title === title).value(sample) ?? "");

// A column's values to choose from, where there are several, but not one for each sample.
function labelFilter(column, all, state, show) {
  const values = [...new Set(all.map((sample) => String(column.value(sample) ?? "")))].filter(Boolean).sort();
  if (column.names || values.length < 2 || values.length > most_choices) return "";
  const select = html`<select name=${column.title}><option value="">any</option>${values.map((value) => html`<option>${value}</option>`)}</select>`;
  select.onchange = () => {
    state.labels.set(column.title, select.value);
    show();
  };
  return html`<label>${column.title}${select}</label>`;
}

function tableOf(columns, samples, order) {
  const drawn = (sample) => {
    const place = html`<div class="thumbnail" role="img" aria-label=${`Spectrogram of ${sample.key}`}></div>`;
    whenSeen(place, () => place.append(thumbnail(sample)));
    return place;
  };
  const seen = { title: "sound", sorts: false, value: () => "", text: (sample) => html`${drawn(sample)}<div class="buttons">${openButton(sample)}</div>` };
  return table([seen, ...columns], samples, { caption: "Samples; the heading of a column sorts by it", order });
}
