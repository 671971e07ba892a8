// Arrays as the report holds them: little-endian values in base64.

function bytesOf(text) {
  const raw = atob(text);
  const all = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; ++i) all[i] = raw.charCodeAt(i);
  return all;
}

export const uint8s = bytesOf;
export const int8s = (text) => new Int8Array(bytesOf(text).buffer);
export const int16s = (text) => new Int16Array(bytesOf(text).buffer);
export const uint32s = (text) => new Uint32Array(bytesOf(text).buffer);
export const float32s = (text) => new Float32Array(bytesOf(text).buffer);
export const float64s = (text) => new Float64Array(bytesOf(text).buffer);
