import { html } from "htl";
import WaveSurfer from "wavesurfer.js";
import Spectrogram from "wavesurfer.js/plugins/spectrogram";
import Timeline from "wavesurfer.js/plugins/timeline";
import Zoom from "wavesurfer.js/plugins/zoom";

import { uint8s } from "./arrays.js";
import { lowest, magma, range, timeStep, toneLabels } from "./spectrogram.js";

const colorMap = Array.from({ length: 256 }, (_, i) => magma(i / 255).map((value) => value / 255));
const maxZoom = 20000; // pixels per second
const wave_pixels = 80;

// One sample as wide as the screen: waveform and spectrogram that can be zoomed into, by buttons, keys
// (+, -, 0) or the wheel.
export function openPlayer(sample, details) {
  const height = Math.round(Math.min(320, Math.max(160, innerHeight / 3)));
  const stage = html`<div></div>`;
  const audio = html`<audio controls aria-label=${sample.key}></audio>`;
  const shown = html`<output class="note"></output>`;
  const button = (text, act) => Object.assign(html`<button type="button">${text}</button>`, { onclick: act });
  const dialog = html`<dialog class="player" aria-label=${`Sample ${sample.key}`}>
    <div class="bar"><h2>${sample.key}</h2><div class="buttons">${button("Close", () => dialog.close())}</div></div>
    <div class="stage"><div class="scales" aria-hidden="true" style=${`top: ${wave_pixels}px; height: ${height}px`}>${toneLabels(sample.sample_rate_hz)}</div>${stage}</div>
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
    height: wave_pixels,
    sampleRate: sample.sample_rate_hz,
    waveColor: style.getPropertyValue("--accent"),
    progressColor: style.getPropertyValue("--quiet"),
    cursorColor: style.getPropertyValue("--bad"),
    minPxPerSec: 0,
    autoScroll: false,
    plugins: [
      Zoom.create({ maxZoom, exponentialZooming: true }),
      // The thumbnails' scales: a tone is where it is there.
      Spectrogram.create({
        height,
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
  let zoomed = 0; // pixels per second that were asked for; the whole clip fills the width at the least
  const pixels = () => Math.max(zoomed, wave.getWidth() / wave.getDuration());
  let axis = null;
  // An axis has the labels that fit into what is seen.
  const tell = () => {
    const seen = wave.getWidth() / pixels();
    shown.value = `${Number(seen.toPrecision(3))} s across`;
    const step = timeStep(seen);
    if (axis?.step === step) return;
    if (axis) wave.unregisterPlugin(axis.plugin);
    axis = { step, plugin: wave.registerPlugin(timeAxis(step)) };
  };
  // About the cursor, where it is seen, else the middle.
  const zoom = (factor) => {
    const cursor = wave.getCurrentTime() * pixels() - wave.getScroll();
    const place = cursor >= 0 && cursor <= wave.getWidth() ? cursor : wave.getWidth() / 2;
    const time = (wave.getScroll() + place) / pixels();
    wave.zoom(Math.min(maxZoom, factor * pixels()));
    wave.setScroll(time * pixels() - place);
  };
  wave.on("ready", tell);
  wave.on("resize", tell);
  wave.on("zoom", (wanted) => {
    zoomed = wanted;
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

function timeAxis(step) {
  const is_labelled = (seconds) => Math.abs(seconds / step - Math.round(seconds / step)) < 1e-6;
  return Timeline.create({
    timeInterval: step / 5,
    primaryLabelInterval: Infinity,
    primaryLabelSpacing: 5,
    secondaryLabelInterval: Infinity,
    formatTimeCallback: (seconds) => (is_labelled(seconds) ? `${Number(seconds.toPrecision(4))} s` : ""),
  });
}
