import FFT from "fft.js";

// Power spectrogram of a clip as a picture: time across, frequency up on a logarithmic scale, 80 dB
// of magma. Windows of 1,024 values (Hann), a quarter apart.
const size = 1024;
const range = 80;

export function spectrogram(samples, sampleRate, width, height) {
  const frames = powers(samples);
  const loudest = frames.reduce((most, frame) => frame.reduce((m, p) => Math.max(m, p), most), 1e-30);
  const canvas = document.createElement("canvas");
  canvas.width = width;
  canvas.height = height;
  const picture = canvas.getContext("2d").createImageData(width, height);
  for (let y = 0; y < height; ++y) {
    // From 60 Hz at the bottom to half the rate at the top.
    const hertz = 60 * (sampleRate / 2 / 60) ** (1 - (y + 0.5) / height);
    const bin = Math.min((hertz / sampleRate) * size, size / 2 - 1);
    const low = Math.floor(bin);
    for (let x = 0; x < width; ++x) {
      const frame = frames[Math.floor((x / width) * frames.length)];
      const power = frame[low] * (low + 1 - bin) + frame[Math.min(low + 1, size / 2 - 1)] * (bin - low);
      const level = 1 + (10 * Math.log10(power / loudest + 1e-30)) / range;
      picture.data.set(magma(Math.min(1, Math.max(0, level))), 4 * (y * width + x));
    }
  }
  canvas.getContext("2d").putImageData(picture, 0, 0);
  return canvas;
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

function magma(share) {
  const place = share * (points.length - 1);
  const low = Math.min(Math.floor(place), points.length - 2);
  const part = place - low;
  return [...points[low].map((value, i) => Math.round(value + part * (points[low + 1][i] - value))), 255];
}
