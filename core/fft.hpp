#pragma once

#include <complex>
#include <cstddef>
#include <memory>
#include <span>

#include "core/handle.hpp"

struct fftw_plan_s;

namespace carillon::core {

/// Numbers that lie as FFTW's fastest code wants them; a complex one takes two.
struct FftFree {
  void operator()(double* numbers) const;
};
using FftNumbers = std::unique_ptr<double[], FftFree>;
FftNumbers fft_numbers(std::size_t count);

/// How numbers on a line go on beyond its ends, half a step beyond the last.
enum class Mirrored { even, odd };

/// A transform of numbers at one place, as FFTW does it, without factors. Plans are estimated, so
/// that no clock decides about the last bits. They may be made and destroyed in any thread: FFTW
/// makes one at a time, and a lock sees to it.
class FftPlan {
 public:
  FftPlan() = default;
  /// Real numbers in rows (of `extent`, the last axis innermost) to coefficients, exp(-i ...): of
  /// the last axis those from 0 to half. Both may be the same place; else the signal stays.
  static FftPlan forward(std::span<const int> extent, double* signal,
                         std::complex<double>* spectrum);
  /// Back; the spectrum is lost.
  static FftPlan inverse(std::span<const int> extent, std::complex<double>* spectrum,
                         double* signal);
  /// Cosines of even axes and sines of odd ones (REDFT10 and RODFT10), in place.
  static FftPlan mirrored(std::span<const int> extent, std::span<const Mirrored> axes,
                          double* values);
  /// Back, of even axes (REDFT01).
  static FftPlan from_mirrored(std::span<const int> extent, double* values);

  void run() const;

 private:
  static void destroy(fftw_plan_s** plan);
  explicit FftPlan(fftw_plan_s* plan) : plan_(plan) {}

  Handle<fftw_plan_s*, destroy, nullptr> plan_;
};

}  // namespace carillon::core
