import FFT from "fft.js";
import { html } from "htl";

import { number } from "./format.js";

// Power spectrogram of a clip as a picture with its scales: time across, frequency up on a
// logarithmic scale, 80 dB of magma. Windows of 1,024 values (Hann), a quarter apart.
const size = 1024;
export const range = 80;
export const lowest = 60;

export function spectrogram(samples, sampleRate, width, height) {
  const seconds = samples.length / sampleRate;
  const step = timeStep(seconds);
  const times = Array.from({ length: Math.floor(seconds / step) + 1 }, (_, i) => i * step);
  return html`<div class="scales" aria-hidden="true">
    ${drawing(samples, sampleRate, width, height)}
    ${toneLabels(sampleRate)}
    <span class="unit">Hz</span>
    ${times.map((time, i) => html`<span class="time" style=${`left: ${(100 * time) / seconds}%`}>${i === 0 ? "0 s" : number(time, 2)}</span>`)}
  </div>`;
}

// Between labels of an axis of time [s].
export function timeStep(seconds) {
  return [0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 60].find((each) => seconds / each < 6) ?? seconds / 4;
}

// Where tones are on the axis of frequency.
export function toneLabels(sampleRate) {
  const octaves = Math.log2(sampleRate / 2 / lowest);
  const up = (hertz) => `bottom: ${(100 * Math.log2(hertz / lowest)) / octaves}%`;
  const tones = [100, 300, 1000, 3000, 10000].filter((hertz) => hertz < 0.45 * sampleRate);
  return tones.map((hertz) => html`<span class="tone" style=${up(hertz)}>${hertz < 1000 ? `${hertz}` : `${hertz / 1000}k`}</span>`);
}

function drawing(samples, sampleRate, width, height) {
  const frames = powers(samples);
  const loudest = frames.reduce((most, frame) => frame.reduce((m, p) => Math.max(m, p), most), 1e-30);
  const canvas = document.createElement("canvas");
  canvas.width = width;
  canvas.height = height;
  const picture = canvas.getContext("2d").createImageData(width, height);
  // Every window and every frequency falls into a pixel: the largest of those in one is shown, as
  // the line of a mode is narrower than a pixel at high frequencies.
  const columns = Array.from({ length: width }, (_, x) => {
    const begin = Math.floor((x / width) * frames.length);
    return largest(frames.slice(begin, Math.max(begin + 1, Math.floor(((x + 1) / width) * frames.length))));
  });
  for (let y = 0; y < height; ++y) {
    // From the lowest at the bottom to half the rate at the top.
    const bin = (row) => (lowest * (sampleRate / 2 / lowest) ** (1 - row / height) * size) / sampleRate;
    columns.forEach((column, x) => {
      const level = 1 + (10 * Math.log10(within(column, bin(y + 1), bin(y)) / loudest + 1e-30)) / range;
      picture.data.set(magma(Math.min(1, Math.max(0, level))), 4 * (y * width + x));
    });
  }
  canvas.getContext("2d").putImageData(picture, 0, 0);
  return canvas;
}

function largest(frames) {
  if (frames.length === 1) return frames[0];
  return frames[0].map((_, bin) => frames.reduce((most, frame) => Math.max(most, frame[bin]), 0));
}

// The largest power from bin `low` to bin `high`; between two bins where none lies there.
function within(powers, low, high) {
  const last = powers.length - 1;
  const [first, end] = [Math.ceil(low), Math.min(Math.floor(high), last)];
  if (first > end) {
    const below = Math.min(Math.floor(low), last);
    const part = (low + high) / 2 - below;
    return (1 - part) * powers[below] + part * powers[Math.min(below + 1, last)];
  }
  let most = 0;
  for (let bin = first; bin <= end; ++bin) most = Math.max(most, powers[bin]);
  return most;
}

function powers(samples) {
  const fft = new FFT(size);
  const window = Float64Array.from({ length: size }, (_, i) => 0.5 - 0.5 * Math.cos((2 * Math.PI * i) / size));
  const frames = [];
  const spectrum = fft.createComplexArray();
  for (let begin = 0; begin === 0 || begin + size <= samples.length; begin += size / 4) {
    const block = Array.from(window, (w, i) => w * (samples[begin + i] ?? 0));
    fft.realTransform(spectrum, block);
    frames.push(Float64Array.from({ length: size / 2 }, (_, i) => spectrum[2 * i] ** 2 + spectrum[2 * i + 1] ** 2));
  }
  return frames;
}

// Points of the magma colour map (matplotlib, CC0), straight lines between.
const points = [[0, 0, 4], [28, 16, 68], [79, 18, 123], [129, 37, 129], [181, 54, 122], [229, 80, 100], [251, 135, 97], [254, 194, 135], [252, 253, 191]];

export function magma(share) {
  const place = share * (points.length - 1);
  const low = Math.min(Math.floor(place), points.length - 2);
  const part = place - low;
  return [...points[low].map((value, i) => Math.round(value + part * (points[low + 1][i] - value))), 255];
}
