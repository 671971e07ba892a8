import { uint8s } from "./arrays.js";

// Channels of a WAV file of 16 bits, as the report holds sounds.
export function channelsOf({ audio, channels }) {
  const data = uint8s(audio);
  const view = new DataView(data.buffer);
  let at = 12;
  while (view.getUint32(at) !== 0x64617461) at += 8 + view.getUint32(at + 4, true); // "data"
  const count = view.getUint32(at + 4, true) / 2 / channels;
  return Array.from({ length: channels }, (_, channel) =>
    Float32Array.from({ length: count }, (_, i) => view.getInt16(at + 8 + 2 * (channels * i + channel), true) / 32768),
  );
}

// What a listener would say of a sound, from its first channel as it is stored: its level [dB, root
// mean square over the clip], and its reverberation time T20 [s] by Schroeder's backward integration
// (ISO 3382), undefined where it does not fall by 25 dB.
export function heardOf(sample) {
  const [clip] = channelsOf(sample);
  const left = new Float64Array(clip.length + 1);
  for (let i = clip.length - 1; i >= 0; --i) left[i] = left[i + 1] + clip[i] ** 2;
  if (left[0] === 0) return {};
  const level = 10 * Math.log10(left[0] / clip.length) - (sample.labels["played at [dB]"] ?? 0);
  const when = (decibels) => left.findIndex((energy) => energy < left[0] * 10 ** (decibels / 10));
  const [begin, end] = [when(-5), when(-25)];
  // The last tenth of a clip ends with the clip, not with the sound.
  return { level, decay: end < 0.9 * clip.length ? (3 * (end - begin)) / sample.sample_rate_hz : undefined };
}
