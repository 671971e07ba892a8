#include "synth/resonators.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <cstddef>
#include <numbers>
#include <vector>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "synth/resonators.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef CARILLON_SYNTH_RESONATORS_TYPES
#define CARILLON_SYNTH_RESONATORS_TYPES
namespace carillon::synth {

/// Most samples in one vector; powers of the step are kept up to it.
constexpr std::size_t kMaxLanes = 16;
constexpr std::size_t kPowers = 5;  // steps of 1, 2, 4, 8, 16 samples

/// Where a partial stands at a block's first sample, and how it turns.
struct Phasor {
  double real = 0;
  double imag = 0;
  std::array<double, kPowers> step_real{};
  std::array<double, kPowers> step_imag{};
};

}  // namespace carillon::synth
#endif

HWY_BEFORE_NAMESPACE();
namespace carillon::synth::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using Lanes = hn::CappedTag<double, kMaxLanes>;
using Vector = hn::Vec<Lanes>;

/// The phasor's first samples, one in each lane.
HWY_INLINE void first_lanes(const Phasor& phasor, Vector& real, Vector& imag) {
  const Lanes lanes;
  HWY_ALIGN std::array<double, kMaxLanes> re{};
  HWY_ALIGN std::array<double, kMaxLanes> im{};
  re[0] = phasor.real;
  im[0] = phasor.imag;
  std::size_t filled = 1;
  for (std::size_t power = 0; filled < hn::Lanes(lanes); ++power, filled *= 2) {
    for (std::size_t k = 0; k < filled; ++k) {
      re[filled + k] = re[k] * phasor.step_real[power] - im[k] * phasor.step_imag[power];
      im[filled + k] = re[k] * phasor.step_imag[power] + im[k] * phasor.step_real[power];
    }
  }
  real = hn::Load(lanes, re.data());
  imag = hn::Load(lanes, im.data());
}

/// Adds groups of four phasors to `count` samples (rounded up to whole vectors). Four, because the
/// chain of products of one is longer than the arithmetic units are wide.
void add_phasors(const Phasor* phasors, std::size_t groups, std::size_t count, double* samples) {
  const Lanes lanes;
  const std::size_t width = hn::Lanes(lanes);
  std::size_t power = 0;
  while ((std::size_t{1} << power) < width) ++power;
  for (std::size_t group = 0; group < groups; ++group) {
    const Phasor* four = phasors + 4 * group;
    Vector re0, im0, re1, im1, re2, im2, re3, im3;
    first_lanes(four[0], re0, im0);
    first_lanes(four[1], re1, im1);
    first_lanes(four[2], re2, im2);
    first_lanes(four[3], re3, im3);
    const Vector step_re0 = hn::Set(lanes, four[0].step_real[power]);
    const Vector step_im0 = hn::Set(lanes, four[0].step_imag[power]);
    const Vector step_re1 = hn::Set(lanes, four[1].step_real[power]);
    const Vector step_im1 = hn::Set(lanes, four[1].step_imag[power]);
    const Vector step_re2 = hn::Set(lanes, four[2].step_real[power]);
    const Vector step_im2 = hn::Set(lanes, four[2].step_imag[power]);
    const Vector step_re3 = hn::Set(lanes, four[3].step_real[power]);
    const Vector step_im3 = hn::Set(lanes, four[3].step_imag[power]);
    const auto turn = [](Vector& re, Vector& im, const Vector step_re, const Vector step_im)
                          HWY_ATTR {
                            const Vector next = hn::NegMulAdd(im, step_im, hn::Mul(re, step_re));
                            im = hn::MulAdd(re, step_im, hn::Mul(im, step_re));
                            re = next;
                          };
    for (std::size_t i = 0; i < count; i += width) {
      const Vector sum = hn::Add(hn::Add(re0, re1), hn::Add(re2, re3));
      hn::Store(hn::Add(hn::Load(lanes, samples + i), sum), lanes, samples + i);
      turn(re0, im0, step_re0, step_im0);
      turn(re1, im1, step_re1, step_im1);
      turn(re2, im2, step_re2, step_im2);
      turn(re3, im3, step_re3, step_im3);
    }
  }
}

}  // namespace carillon::synth::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace carillon::synth {

HWY_EXPORT(add_phasors);

namespace {

/// Samples between two anchors: long enough to hide an anchor's cost, short enough that the
/// product's rounding (about 1e-16 a step) stays below 1e-13.
constexpr std::size_t kBlock = 1024;

/// exp((-d + i omega) t), the phase reduced in extended precision: after a minute at 20 kHz it is
/// 7e6 rad, which a double holds to 1e-9 only.
std::complex<double> exponential(const Partial& partial, long double t) {
  constexpr long double kTurn = 2 * std::numbers::pi_v<long double>;
  const long double turns = partial.angular_frequency * t / kTurn;
  const auto angle = static_cast<double>((turns - std::rint(turns)) * kTurn);
  const double decay = std::exp(-partial.decay_rate * static_cast<double>(t));
  return {decay * std::cos(angle), decay * std::sin(angle)};
}

void set_steps(const Partial& partial, double sample_rate, Phasor& phasor) {
  for (std::size_t power = 0; power < kPowers; ++power) {
    const auto samples = static_cast<long double>(std::size_t{1} << power);
    const std::complex<double> step = exponential(partial, samples / sample_rate);
    phasor.step_real[power] = step.real();
    phasor.step_imag[power] = step.imag();
  }
}

}  // namespace

void add_partials(std::span<const Partial> partials, long double first_time, double sample_rate,
                  double tail, double peak, std::span<double> samples) {
  std::vector<Partial> active;
  std::vector<Phasor> phasors;
  for (const Partial& partial : partials) {
    if (partial.amplitude == 0.0) continue;
    active.push_back(partial);
    set_steps(partial, sample_rate, phasors.emplace_back());
  }
  const double share = active.empty() ? 0 : tail / static_cast<double>(active.size());
  HWY_ALIGN_MAX std::array<double, kBlock> sum;
  for (std::size_t begin = 0; begin < samples.size() && !active.empty(); begin += kBlock) {
    const long double time = first_time + static_cast<long double>(begin) / sample_rate;
    std::size_t kept = 0;
    for (std::size_t i = 0; i < active.size(); ++i) {
      const std::complex<double> value = active[i].amplitude * exponential(active[i], time);
      const double envelope = std::abs(active[i].amplitude) *
                              std::exp(-active[i].decay_rate * static_cast<double>(time));
      if (envelope == 0 || envelope < share * peak) continue;
      active[kept] = active[i];
      phasors[kept] = phasors[i];
      phasors[kept].real = value.real();
      phasors[kept].imag = value.imag();
      ++kept;
    }
    active.resize(kept);
    // Silent phasors fill up the last group of four.
    const std::size_t groups = (kept + 3) / 4;
    phasors.resize(4 * groups);
    std::fill(phasors.begin() + static_cast<std::ptrdiff_t>(kept), phasors.end(), Phasor{});
    const std::size_t count = std::min(kBlock, samples.size() - begin);
    sum.fill(0);
    HWY_DYNAMIC_DISPATCH(add_phasors)(phasors.data(), groups, count, sum.data());
    for (std::size_t i = 0; i < count; ++i) {
      samples[begin + i] += sum[i];
      peak = std::max(peak, std::abs(samples[begin + i]));
    }
  }
}

}  // namespace carillon::synth
#endif  // HWY_ONCE
