#include "eval/features/detail/tone.hpp"

#include <cmath>
#include <numbers>

namespace carillon::eval::features {

namespace {

using Complex = std::complex<double>;

/// exp(rate count), and 1 less it without cancellation for slow and low tones.
struct End {
  Complex value;
  Complex one_less;
};
End end_of(const Complex& rate, std::size_t count) {
  const Complex power = rate * static_cast<double>(count);
  const double grown = std::expm1(power.real());
  const double half = std::sin(power.imag() / 2);
  const double cosine = std::cos(power.imag());
  const double sine = std::sin(power.imag());
  const double magnitude = 1 + grown;
  // exp(a + ib) - 1 = expm1(a) cos b - 2 sin^2(b / 2) + i exp(a) sin b
  const Complex less(grown * cosine - 2 * half * half, magnitude * sine);
  return {{magnitude * cosine, magnitude * sine}, -less};
}

/// What the inner loops of transforms are compiled for: without contraction, vectors of any width
/// give the same digits.
#if defined(__x86_64__) && defined(__linux__)
#define CARILLON_VECTOR_CLONES __attribute__((target_clones("avx512f", "avx2", "default")))
#else
#define CARILLON_VECTOR_CLONES
#endif

/// out += (b0 - b1 w) / (1 - p w + q w^2), w = exp(-i omega_k).
CARILLON_VECTOR_CLONES
void add_fractions(const double* cosines, const double* sines, std::size_t size, double b0,
                   double b1, double p, double q, double* out) {
  for (std::size_t i = 0; i < size; ++i) {
    const double c = cosines[i], s = sines[i];
    const double top_re = b0 - b1 * c, top_im = b1 * s;
    const double down_re = 1 - p * c + q * (c * c - s * s), down_im = p * s - q * (2 * c * s);
    const double scale = 1 / (down_re * down_re + down_im * down_im);
    out[2 * i] += (top_re * down_re + top_im * down_im) * scale;
    out[2 * i + 1] += (top_im * down_re - top_re * down_im) * scale;
  }
}

/// Columns of derivatives as derivatives() has them, e, f and g as written there.
CARILLON_VECTOR_CLONES
void fill_derivatives(const double* cosines, const double* sines, std::size_t size, Complex z,
                      Complex e, Complex f, Complex g, double* out) {
  double* amplitude_re = out;
  double* amplitude_im = out + 2 * size;
  double* rate_re = out + 4 * size;
  double* rate_im = out + 6 * size;
  const double er = e.real(), ei = e.imag(), fr = f.real(), fi = f.imag(), gr = g.real(),
               gi = g.imag(), zr = z.real(), zi = z.imag();
  for (std::size_t i = 0; i < size; ++i) {
    const double c = cosines[i], s = sines[i];
    // z w of the tone, and of its mirror image.
    const double ur = zr * c + zi * s, ui = zi * c - zr * s;
    const double vr = zr * c - zi * s, vi = -zi * c - zr * s;
    const double un = 1 / ((1 - ur) * (1 - ur) + ui * ui), vn = 1 / ((1 - vr) * (1 - vr) + vi * vi);
    const double pr = (1 - ur) * un, pi = ui * un;  // q
    const double qr = (1 - vr) * vn, qi = vi * vn;
    const double ar = er * pr - ei * pi, ai = er * pi + ei * pr;
    const double mr = er * qr + ei * qi, mi = er * qi - ei * qr;
    amplitude_re[2 * i] = ar + mr;
    amplitude_re[2 * i + 1] = ai + mi;
    amplitude_im[2 * i] = -(ai - mi);
    amplitude_im[2 * i + 1] = ar - mr;
    // f + g z w q, times q
    const double xr = ur * pr - ui * pi, xi = ur * pi + ui * pr;
    const double yr = vr * qr - vi * qi, yi = vr * qi + vi * qr;
    const double br = fr + gr * xr - gi * xi, bi = fi + gr * xi + gi * xr;
    const double nr = fr + gr * yr + gi * yi, ni = -fi + gr * yi - gi * yr;
    const double dr = br * pr - bi * pi, di = br * pi + bi * pr;
    const double hr = nr * qr - ni * qi, hi = nr * qi + ni * qr;
    rate_re[2 * i] = dr + hr;
    rate_re[2 * i + 1] = di + hi;
    rate_im[2 * i] = -(di - hi);
    rate_im[2 * i + 1] = dr - hr;
  }
}

/// cos and sin of a range's frequencies, one after the other.
class Places {
 public:
  Places(std::span<const double> cosines, std::span<const double> sines, BinRange range) {
    if (range.step == 1) {
      cosines_ = cosines.data() + range.first;
      sines_ = sines.data() + range.first;
      return;
    }
    gathered_.resize(2 * range.size());
    for (std::size_t i = 0; i < range.size(); ++i) {
      gathered_[i] = cosines[range.at(i)];
      gathered_[range.size() + i] = sines[range.at(i)];
    }
    cosines_ = gathered_.data();
    sines_ = gathered_.data() + range.size();
  }
  const double* cosines() const { return cosines_; }
  const double* sines() const { return sines_; }

 private:
  std::vector<double> gathered_;
  const double* cosines_;
  const double* sines_;
};

}  // namespace

ToneGrid::ToneGrid(std::size_t count) : count_(count), cos_(count / 2 + 1), sin_(count / 2 + 1) {
  const double step = 2 * std::numbers::pi / static_cast<double>(count);
  for (std::size_t k = 0; k < cos_.size(); ++k) {
    cos_[k] = std::cos(step * static_cast<double>(k));
    sin_[k] = std::sin(step * static_cast<double>(k));
  }
}

void ToneGrid::add(const Tone& tone, double factor, BinRange range,
                   std::span<Complex> spectrum) const {
  if (range.size() > 0) {
    add_part(tone, factor, range, spectrum.subspan(range.first, range.size()));
  }
}

void ToneGrid::add_part(const Tone& tone, double factor, BinRange range,
                        std::span<Complex> part) const {
  // Sum of A z^n w^n / 2 and its mirror, w = exp(-i omega_k): with B = A (1 - z^N)
  //   (Re B - Re(B conj z) w) / (1 - 2 Re z w + |z|^2 w^2)
  const Complex z = std::exp(tone.rate);
  const Complex b = factor * tone.amplitude * end_of(tone.rate, count_).one_less;
  const double b0 = b.real();
  const double b1 = (b * std::conj(z)).real();
  const double p = 2 * z.real();
  const double q = std::norm(z);
  const Places places(cos_, sin_, range);
  add_fractions(places.cosines(), places.sines(), range.size(), b0, b1, p, q,
                reinterpret_cast<double*>(part.data()));
}

void ToneGrid::derivatives(const Tone& tone, BinRange range, std::span<Complex> columns) const {
  // With q = 1 / (1 - z w), w = exp(-i omega_k), e = 1 - z^N:
  //   d/dA = e q / 2,  d/drate = A / 2 (-N z^N q + e z w q^2),  and the same of the mirror image.
  const std::size_t size = range.size();
  const Complex z = std::exp(tone.rate);
  const End end = end_of(tone.rate, count_);
  const Complex lost = -static_cast<double>(count_) * end.value;
  const Complex e = 0.5 * end.one_less, f = 0.5 * tone.amplitude * lost,
                g = 0.5 * tone.amplitude * end.one_less;
  const Places places(cos_, sin_, range);
  fill_derivatives(places.cosines(), places.sines(), size, z, e, f, g,
                   reinterpret_cast<double*>(columns.data()));
}

void add_tone(std::span<double> signal, const Tone& tone, double factor) {
  constexpr double nothing = 40;  // times 1 / d: below what a double holds of the begin
  const std::complex<double> turn = std::exp(tone.rate);
  std::complex<double> value = factor * tone.amplitude;
  const double length =
      std::min(static_cast<double>(signal.size()), nothing / std::max(-tone.rate.real(), 1e-300));
  for (double& sample : signal.first(static_cast<std::size_t>(length))) {
    sample += value.real();
    value *= turn;
  }
}

double product(const Tone& a, const Tone& b, std::size_t count) {
  const std::complex<double> rate = a.rate + std::conj(b.rate);
  const auto length = static_cast<double>(count);
  const std::complex<double> sum = std::abs(rate) * length < 1e-9
                                       ? length
                                       : (1.0 - std::exp(rate * length)) / (1.0 - std::exp(rate));
  return 0.5 * (a.amplitude * std::conj(b.amplitude) * sum).real();
}

double energy(const Tone& tone, std::size_t count) {
  const double decay = -2 * tone.rate.real();
  const double n = static_cast<double>(count);
  const double sum = std::abs(decay * n) < 1e-9 ? n : -std::expm1(-decay * n) / -std::expm1(-decay);
  return 0.5 * std::norm(tone.amplitude) * sum;
}

}  // namespace carillon::eval::features
