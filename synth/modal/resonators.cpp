#include "synth/modal/resonators.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#if defined(__SSE2__)
#include <xmmintrin.h>
#endif

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "synth/modal/resonators.cpp"
#include <hwy/cache_control.h>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace carillon::synth::modal::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using Lanes = hn::CappedTag<double, max_lanes>;
using Vector = hn::Vec<Lanes>;

/// One voice: its last two vectors and the recursion's coefficients.
struct Recursion {
  Vector last, next, twice, square;
};

HWY_INLINE Recursion begin(const Voice& voice, std::size_t power) {
  const Lanes lanes;
  const Rotation& rotation = *voice.rotation;
  const Vector real = hn::Load(lanes, rotation.real.data());
  const Vector imag = hn::Load(lanes, rotation.imag.data());
  const double a = rotation.powers[power].real();
  const double b = rotation.powers[power].imag();
  const double re = voice.value.real();
  const double im = voice.value.imag();
  const auto values = [&](double x, double y) HWY_ATTR {
    return hn::NegMulAdd(hn::Set(lanes, y), imag, hn::Mul(hn::Set(lanes, x), real));
  };
  return {values(re, im), values(re * a - im * b, re * b + im * a), hn::Set(lanes, 2 * a),
          hn::Set(lanes, a * a + b * b)};
}

/// Adds voices to a block, four at a time: the chain of products of one is longer than the
/// arithmetic units are wide.
void add_voices(const Voice* voices, std::size_t size, std::size_t count, double* samples) {
  const Lanes lanes;
  const std::size_t width = hn::Lanes(lanes);
  std::size_t power = 0;
  while ((std::size_t{1} << power) < width) ++power;
  static constexpr Rotation at_rest{};
  const Voice silent{&at_rest, 0};
  for (std::size_t first = 0; first < size; first += 4) {
    const auto voice = [&](std::size_t k) -> const Voice& {
      return first + k < size ? voices[first + k] : silent;
    };
    // Banks of many bodies do not fit the caches: fetch the next four meanwhile.
    for (std::size_t next = first + 4; next < std::min(first + 8, size); ++next) {
      const Rotation* rotation = voices[next].rotation;
      hwy::Prefetch(rotation->real.data());
      hwy::Prefetch(rotation->imag.data());
      hwy::Prefetch(rotation->powers.data());
      hwy::Prefetch(rotation->powers.data() + 4);
      hwy::Prefetch(rotation->powers.data() + 8);
    }
    Recursion v0 = begin(voice(0), power);
    Recursion v1 = begin(voice(1), power);
    Recursion v2 = begin(voice(2), power);
    Recursion v3 = begin(voice(3), power);
    for (std::size_t i = 0; i < count; i += 2 * width) {
      double* here = samples + i;
      const Vector sum = hn::Add(hn::Add(v0.last, v1.last), hn::Add(v2.last, v3.last));
      hn::Store(hn::Add(hn::Load(lanes, here), sum), lanes, here);
      v0.last = hn::MulSub(v0.twice, v0.next, hn::Mul(v0.square, v0.last));
      v1.last = hn::MulSub(v1.twice, v1.next, hn::Mul(v1.square, v1.last));
      v2.last = hn::MulSub(v2.twice, v2.next, hn::Mul(v2.square, v2.last));
      v3.last = hn::MulSub(v3.twice, v3.next, hn::Mul(v3.square, v3.last));
      here += width;
      const Vector more = hn::Add(hn::Add(v0.next, v1.next), hn::Add(v2.next, v3.next));
      hn::Store(hn::Add(hn::Load(lanes, here), more), lanes, here);
      v0.next = hn::MulSub(v0.twice, v0.last, hn::Mul(v0.square, v0.next));
      v1.next = hn::MulSub(v1.twice, v1.last, hn::Mul(v1.square, v1.next));
      v2.next = hn::MulSub(v2.twice, v2.last, hn::Mul(v2.square, v2.next));
      v3.next = hn::MulSub(v3.twice, v3.last, hn::Mul(v3.square, v3.next));
    }
  }
}

double peak_of(const double* samples, std::size_t count) {
  const Lanes lanes;
  const std::size_t width = hn::Lanes(lanes);
  Vector peak = hn::Zero(lanes);
  std::size_t i = 0;
  for (; i + width <= count; i += width) {
    peak = hn::Max(peak, hn::Abs(hn::Load(lanes, samples + i)));
  }
  double largest = hn::GetLane(hn::MaxOfLanes(lanes, peak));
  for (; i < count; ++i) largest = std::max(largest, std::abs(samples[i]));
  return largest;
}

}  // namespace carillon::synth::modal::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace carillon::synth::modal {

HWY_EXPORT(add_voices);
HWY_EXPORT(peak_of);

namespace {

#if defined(__SSE2__)
/// Numbers below the normal range take a hundred times as long; they are cleared meanwhile.
class ClearSubnormals {
 public:
  ClearSubnormals() : before_(_mm_getcsr()) { _mm_setcsr(before_ | 0x8040U); }
  ~ClearSubnormals() { _mm_setcsr(before_); }
  ClearSubnormals(const ClearSubnormals&) = delete;
  ClearSubnormals& operator=(const ClearSubnormals&) = delete;

 private:
  unsigned before_;
};
#else
struct ClearSubnormals {
  ClearSubnormals() {}  // NOLINT: a declaration of it is used
};
#endif

/// Product by its parts: std::complex's own looks after infinities, which do not occur.
std::complex<double> product(const std::complex<double>& a, const std::complex<double>& b) {
  return {a.real() * b.real() - a.imag() * b.imag(), a.real() * b.imag() + a.imag() * b.real()};
}

}  // namespace

std::complex<double> exponential(double decay_rate, long double angular_frequency, long double t) {
  constexpr long double turn = 2 * std::numbers::pi_v<long double>;
  const long double turns = angular_frequency * t / turn;
  const auto angle = static_cast<double>((turns - std::rint(turns)) * turn);
  const double decay = std::exp(-decay_rate * static_cast<double>(t));
  return {decay * std::cos(angle), decay * std::sin(angle)};
}

Rotation make_rotation(double decay_rate, long double angular_frequency, double sample_rate) {
  Rotation rotation;
  // The step and its squares in extended precision: hours of products keep their phase.
  const long double angle = angular_frequency / sample_rate;
  const long double decay = std::exp(-static_cast<long double>(decay_rate) / sample_rate);
  long double re = decay * std::cos(angle);
  long double im = decay * std::sin(angle);
  for (std::complex<double>& power : rotation.powers) {
    power = {static_cast<double>(re), static_cast<double>(im)};
    const long double next = re * re - im * im;
    im = 2 * re * im;
    re = next;
  }
  rotation.real[0] = 1;
  rotation.imag[0] = 0;
  for (std::size_t power = 0, filled = 1; filled < max_lanes; ++power, filled *= 2) {
    const double step_re = rotation.powers[power].real();
    const double step_im = rotation.powers[power].imag();
    for (std::size_t k = 0; k < filled; ++k) {
      rotation.real[filled + k] = rotation.real[k] * step_re - rotation.imag[k] * step_im;
      rotation.imag[filled + k] = rotation.real[k] * step_im + rotation.imag[k] * step_re;
    }
  }
  return rotation;
}

void add_voices(std::span<const Voice> voices, std::size_t count, SampleBlock& block) {
  const ClearSubnormals clear;
  HWY_DYNAMIC_DISPATCH(add_voices)(voices.data(), voices.size(), count, block.samples.data());
}

void move_on(std::span<Voice> voices, std::size_t count) {
  const ClearSubnormals clear;
  for (std::size_t power = 0; power < step_powers; ++power) {
    if ((count >> power & 1U) == 0) continue;
    for (Voice& voice : voices) voice.value = product(voice.value, voice.rotation->powers[power]);
  }
}

void drop_below(double level, std::vector<Voice>& voices) {
  std::erase_if(voices, [level](const Voice& voice) {
    const double re = std::abs(voice.value.real());
    const double im = std::abs(voice.value.imag());
    const double largest = std::max(re, im);
    if (largest == 0) return true;
    // The largest part decides most cases without a square root.
    return largest < level && std::hypot(re, im) < level;
  });
}

double peak_of(const SampleBlock& block, std::size_t count) {
  return HWY_DYNAMIC_DISPATCH(peak_of)(block.samples.data(), count);
}

double store_block(const SampleBlock& block, std::span<float> samples) {
  for (std::size_t i = 0; i < samples.size(); ++i) {
    samples[i] = static_cast<float>(block.samples[i]);
  }
  return peak_of(block, samples.size());
}

}  // namespace carillon::synth::modal
#endif  // HWY_ONCE
