import { html } from "htl";

import { uint8s } from "./arrays.js";
import { number } from "./format.js";
import { whenSeen } from "./seen.js";
import { spectrogram } from "./spectrogram.js";
import { drawVoxels } from "./voxels.js";

export function samplesSection({ datasets }) {
  const all = datasets.flatMap((dataset) => dataset.heard.map((sample) => ({ dataset, ...sample })));
  if (all.length === 0) return null;
  return {
    id: "samples",
    title: "Samples to hear",
    content: () => html`<p>Chosen evenly from the datasets. Each is turned to the same peak, and <em>played at</em> says by how much.
      Spectrograms: 60 Hz to half the sample rate, of the loudest 80 dB, first channel.</p>
      <div class="cards">${all.map(card)}</div>`,
  };
}

function card(sample) {
  const labels = Object.entries(sample.labels).filter(([, value]) => value !== null);
  const canvas = html`<div class="spectrogram" role="img" aria-label=${`Spectrogram of ${sample.key}`}></div>`;
  whenSeen(canvas, () => canvas.append(spectrogram(clipOf(sample), sample.sample_rate_hz, 320, 128)));
  return html`<article class="card">
    <h3>${sample.key}</h3>
    ${canvas}
    <audio controls preload="none" src=${`data:audio/wav;base64,${sample.audio}`} aria-label=${sample.key}></audio>
    <div class="views">
      ${sample.picture ? html`<img src=${`data:image/png;base64,${sample.picture}`} alt=${`Frame of ${sample.object}`} width="120" height="120">` : ""}
      ${sample.voxels ? voxels(sample) : ""}
    </div>
    <dl>${labels.map(([name, value]) => html`<div><dt>${name.replaceAll("_", " ")}</dt><dd>${typeof value === "number" ? number(value, 3) : value}</dd></div>`)}</dl>
  </article>`;
}

function voxels({ voxels: { resolution, cells }, object }) {
  const place = html`<span class="voxels" role="img" aria-label=${`Voxels of ${object}`}></span>`;
  whenSeen(place, () => place.append(drawVoxels(uint8s(cells), resolution, 120)));
  return place;
}

// The first channel of a WAV file of 16 bits.
function clipOf({ audio, channels }) {
  const data = uint8s(audio);
  const view = new DataView(data.buffer);
  let at = 12;
  while (view.getUint32(at) !== 0x64617461) at += 8 + view.getUint32(at + 4, true); // "data"
  const count = view.getUint32(at + 4, true) / 2 / channels;
  return Float32Array.from({ length: count }, (_, i) => view.getInt16(at + 8 + 2 * channels * i, true) / 32768);
}
