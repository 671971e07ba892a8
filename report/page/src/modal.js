// Sound of a struck object from its modes, in closed form, as the program makes it (Hertz-like raised
// cosine of unit impulse; exact at the sampling instants).

// What an object's modes become in another material or size. Exact: lambda goes with stiffness over
// density and the inverse square of size, mass-normalised shapes with the root of the mass.
// change: {stiffness, density, size} factors; damping(lambda, mode) gives the decay rate d [1/s].
export function changed(object, change, damping) {
  const factor = change.stiffness / (change.density * change.size ** 2);
  const lambda = Array.from(object.eigenvalues, (value) => factor * value);
  return {
    lambda,
    decay: lambda.map((value, mode) => damping(value, mode)),
    shape: 1 / Math.sqrt(change.density * change.size ** 3),
  };
}

// Velocity [m/s] of the struck point along its outward normal.
// modes: {lambda, decay} of n modes; gains: displacement of the point along the normal [kg^-1/2];
// strike: {impulse [N s], duration [s]} against the normal.
export function ring(modes, gains, strike, sampleRate, count) {
  const sound = new Float64Array(count);
  const contact = Math.min(count, Math.ceil(strike.duration * sampleRate));
  for (let mode = 0; mode < gains.length; ++mode) {
    const lambda = modes.lambda[mode];
    const decay = modes.decay[mode];
    const level = -gains[mode] * gains[mode] * strike.impulse;
    if (level === 0) continue;
    const left = lambda - decay * decay;
    if (left > 0 && Math.sqrt(left) >= Math.PI * sampleRate) continue; // at or above Nyquist
    addMode(sound, level, decay, left, strike.duration, contact, sampleRate);
  }
  return sound;
}

// Velocity after a unit impulse is (p e^{pt} - q e^{qt}) / (p - q) with the poles p, q =
// -d +- sqrt(d^2 - lambda): of an oscillating mode Im(p e^{pt}) / omega.
function addMode(sound, level, decay, left, duration, contact, sampleRate) {
  if (left > 0) {
    const omega = Math.sqrt(left);
    const pole = [-decay, omega];
    addPole(sound, pole, [0, -level / omega], duration, contact, sampleRate);
    return;
  }
  // Nearly critical ones are moved apart by a millionth, where the difference still has digits.
  const root = Math.max(Math.sqrt(-left), 1e-6 * decay);
  addPole(sound, [-decay + root, 0], [level / (2 * root), 0], duration, contact, sampleRate);
  addPole(sound, [-decay - root, 0], [-level / (2 * root), 0], duration, contact, sampleRate);
}

// Adds Re(weight p E(t)), E the response of a first-order system of pole p to the force: forced
// during the contact, free afterwards.
function addPole(sound, pole, weight, duration, contact, sampleRate) {
  const scale = times(weight, pole);
  for (let i = 0; i < contact; ++i) {
    sound[i] += times(scale, forced(pole, i / sampleRate, duration))[0];
  }
  if (contact >= sound.length) return;
  const end = duration > 0 ? forced(pole, duration, duration) : [1, 0];
  const begun = contact / sampleRate - duration;
  let [re, im] = times(times(scale, end), exponential(pole, begun));
  const [stepRe, stepIm] = exponential(pole, 1 / sampleRate);
  const silence = 1e-9 * Math.hypot(re, im);
  for (let i = contact; i < sound.length; ++i) {
    sound[i] += re;
    [re, im] = [re * stepRe - im * stepIm, re * stepIm + im * stepRe];
    if ((i & 1023) === 0 && Math.hypot(re, im) < silence) return;
  }
}

// Integral over [0, t] of e^{p (t - s)} (1 - cos(2 pi s / T)) / T: three exponentials.
function forced(pole, t, duration) {
  const turn = (2 * Math.PI) / duration;
  let sum = [0, 0];
  for (const [part, share] of [[0, 1], [turn, -0.5], [-turn, -0.5]]) {
    const from = exponential([0, part], t);
    const to = exponential(pole, t);
    const quotient = over([from[0] - to[0], from[1] - to[1]], [-pole[0], part - pole[1]]);
    sum = [sum[0] + (share * quotient[0]) / duration, sum[1] + (share * quotient[1]) / duration];
  }
  return sum;
}

const times = ([a, b], [c, d]) => [a * c - b * d, a * d + b * c];
const over = ([a, b], [c, d]) => {
  const norm = c * c + d * d;
  return [(a * c + b * d) / norm, (b * c - a * d) / norm];
};
const exponential = ([re, im], t) => [Math.exp(re * t) * Math.cos(im * t), Math.exp(re * t) * Math.sin(im * t)];

// Level of each mode right after the strike [dB against the loudest], for the picture of them.
export function levels(modes, gains, strike) {
  const amplitude = modes.lambda.map((lambda, i) => {
    const omega = Math.sqrt(Math.max(lambda - modes.decay[i] ** 2, 0));
    return omega > 0 ? gains[i] ** 2 * Math.abs(spectrumOf(strike.duration, omega)) : 0;
  });
  const loudest = Math.max(...amplitude, Number.MIN_VALUE);
  return amplitude.map((value) => 20 * Math.log10(value / loudest));
}

// Displacement [m] that a mode has right after a strike at a point of that gain, where its shape is 1.
export function amplitudeAfter({ lambda, decay }, gain, strike) {
  const omega = Math.sqrt(Math.max(lambda - decay ** 2, 0));
  return omega > 0 ? (Math.abs(gain * spectrumOf(strike.duration, omega)) * strike.impulse) / omega : 0;
}

// Fourier transform of the force at omega, but for its phase.
function spectrumOf(duration, omega) {
  const x = (omega * duration) / 2;
  if (x < 1e-9) return 1;
  const nearOne = Math.abs(x / Math.PI - 1) < 1e-6;
  return nearOne ? 0.5 : Math.sin(x) / (x * (1 - (x / Math.PI) ** 2));
}
