import { html } from "htl";

import { uint8s } from "./arrays.js";
import { channelsOf } from "./clip.js";
import { number } from "./format.js";
import { openPlayer } from "./player.js";
import { whenSeen } from "./seen.js";
import { spectrogram } from "./spectrogram.js";
import { drawVoxels } from "./voxels.js";

export const audioAddress = (sample) => `data:audio/wav;base64,${sample.audio}`;
export const labelText = (value) => (typeof value === "number" ? number(value, 3) : value);

// A sample to hear and to see; at once, or when it is scrolled to.
export function soundCard(sample, { atOnce = false } = {}) {
  const draw = atOnce ? (_, make) => make() : whenSeen;
  const canvas = html`<div class="spectrogram" role="img" aria-label=${`Spectrogram of ${sample.key}`}></div>`;
  draw(canvas, () => canvas.append(thumbnail(sample)));
  return html`<article class="card">
    <h3>${sample.key}</h3>
    ${canvas}
    <audio controls preload="none" src=${audioAddress(sample)} aria-label=${sample.key}></audio>
    ${views(sample, draw)}
    ${labels(sample)}
    <div class="buttons">${openButton(sample)}</div>
  </article>`;
}

export const thumbnail = (sample) => spectrogram(channelsOf(sample)[0], sample.sample_rate_hz, 320, 128);

export function openButton(sample) {
  const button = html`<button type="button" aria-haspopup="dialog" aria-label=${`Look closer at ${sample.key}`}>Look closer</button>`;
  button.onclick = () => openPlayer(sample, html`<div>${views(sample, (_, make) => make())}${labels(sample)}</div>`);
  return button;
}

function labels(sample) {
  const known = Object.entries(sample.labels).filter(([, value]) => value !== null);
  return html`<dl>${known.map(([name, value]) => html`<div><dt>${name.replaceAll("_", " ")}</dt><dd>${labelText(value)}</dd></div>`)}</dl>`;
}

function views(sample, draw) {
  if (!sample.picture && !sample.voxels) return "";
  return html`<div class="views">
    ${sample.picture ? html`<img src=${`data:image/png;base64,${sample.picture}`} alt=${`Frame of ${sample.object}`} width="120" height="120">` : ""}
    ${sample.voxels ? voxels(sample, draw) : ""}
  </div>`;
}

function voxels({ voxels: { resolution, cells }, object }, draw) {
  const place = html`<span class="voxels" role="img" aria-label=${`Voxels of ${object}`}></span>`;
  draw(place, () => place.append(drawVoxels(uint8s(cells), resolution, 120)));
  return place;
}
