import { html } from "htl";
import WaveSurfer from "wavesurfer.js";
import Spectrogram from "wavesurfer.js/plugins/spectrogram";
import Timeline from "wavesurfer.js/plugins/timeline";
import Zoom from "wavesurfer.js/plugins/zoom";

import { uint8s } from "./arrays.js";
import { lowest, magma, range } from "./spectrogram.js";

const colorMap = Array.from({ length: 256 }, (_, i) => magma(i / 255).map((value) => value / 255));
const maxZoom = 20000; // pixels per second

// One sample as large as the screen: waveform and spectrogram that can be zoomed into, by buttons, keys
// (+, -, 0) or the wheel.
export function openPlayer(sample, details) {
  const stage = html`<div class="stage"></div>`;
  const audio = html`<audio controls aria-label=${sample.key}></audio>`;
  const shown = html`<output class="note"></output>`;
  const button = (text, act) => Object.assign(html`<button type="button">${text}</button>`, { onclick: act });
  const dialog = html`<dialog class="player" aria-label=${`Sample ${sample.key}`}>
    <div class="bar"><h2>${sample.key}</h2>${button("Close", () => dialog.close())}</div>
    ${stage}
    <div class="buttons bar">${button("Zoom in", () => zoom(2))}${button("Zoom out", () => zoom(0.5))}${button("Whole clip", () => zoom(0))}${shown}</div>
    ${audio}
    ${details}
  </dialog>`;
  document.body.append(dialog);
  dialog.showModal();

  const style = getComputedStyle(dialog);
  const wave = WaveSurfer.create({
    container: stage,
    media: audio,
    height: 80,
    sampleRate: sample.sample_rate_hz,
    waveColor: style.getPropertyValue("--accent"),
    progressColor: style.getPropertyValue("--quiet"),
    cursorColor: style.getPropertyValue("--bad"),
    minPxPerSec: 0,
    autoScroll: false,
    plugins: [
      Timeline.create({ secondaryLabelOpacity: 1, formatTimeCallback: (seconds) => `${Number(seconds.toFixed(4))} s` }),
      Zoom.create({ maxZoom, exponentialZooming: true }),
      // The thumbnails' scales: a tone is where it is there.
      Spectrogram.create({
        labels: true,
        labelsBackground: "rgba(0, 0, 4, 0.6)",
        labelsColor: "#ffffff",
        labelsHzColor: "#ffffff",
        height: Math.min(320, Math.max(160, innerHeight / 3)),
        fftSamples: 1024,
        scale: "logarithmic",
        frequencyMin: lowest,
        frequencyMax: sample.sample_rate_hz / 2,
        autoGain: true,
        rangeDB: range,
        colorMap,
      }),
    ],
  });
  const whole = () => wave.getWidth() / wave.getDuration();
  let pixels = 0;
  const tell = () => (shown.value = `${Number((wave.getWidth() / pixels).toPrecision(3))} s across`);
  const zoom = (factor) => {
    const middle = (wave.getScroll() + wave.getWidth() / 2) / pixels;
    const wanted = Math.min(maxZoom, Math.max(whole(), factor * pixels));
    wave.zoom(wanted);
    wave.setScroll(middle * wanted - wave.getWidth() / 2);
  };
  wave.on("ready", () => {
    pixels = whole();
    tell();
  });
  wave.on("zoom", (wanted) => {
    pixels = Math.max(whole(), wanted);
    tell();
  });
  wave.on("error", (error) => (shown.value = `It cannot be shown: ${error.message}`));
  const keys = { "+": 2, "=": 2, "-": 0.5, 0: 0 };
  dialog.onkeydown = (event) => {
    if (event.key in keys && !event.ctrlKey && !event.metaKey) zoom(keys[event.key]);
  };
  dialog.onclose = () => {
    wave.destroy();
    dialog.remove();
  };
  wave.loadBlob(new Blob([uint8s(sample.audio)], { type: "audio/wav" })).catch(() => {});
  return dialog;
}
