#include "core/fft.hpp"

#include <fftw3.h>

#include <array>
#include <mutex>
#include <vector>

namespace carillon::core {

namespace {

std::mutex& planner() {
  static std::mutex mutex;
  return mutex;
}

// FFTW's complex numbers and the standard's have one layout.
fftw_complex* to_fftw(std::complex<double>* numbers) {
  return reinterpret_cast<fftw_complex*>(numbers);
}

int axes_of(std::span<const int> extent) {
  return static_cast<int>(extent.size());
}

}  // namespace

void FftFree::operator()(double* numbers) const {
  fftw_free(numbers);
}

FftNumbers fft_numbers(std::size_t count) {
  return FftNumbers(fftw_alloc_real(count));
}

void FftPlan::destroy(fftw_plan_s** plan) {
  const std::lock_guard lock(planner());
  fftw_destroy_plan(*plan);
}

FftPlan FftPlan::forward(std::span<const int> extent, double* signal,
                         std::complex<double>* spectrum) {
  const std::lock_guard lock(planner());
  return FftPlan(
      fftw_plan_dft_r2c(axes_of(extent), extent.data(), signal, to_fftw(spectrum), FFTW_ESTIMATE));
}

FftPlan FftPlan::inverse(std::span<const int> extent, std::complex<double>* spectrum,
                         double* signal) {
  const std::lock_guard lock(planner());
  return FftPlan(
      fftw_plan_dft_c2r(axes_of(extent), extent.data(), to_fftw(spectrum), signal, FFTW_ESTIMATE));
}

FftPlan FftPlan::mirrored(std::span<const int> extent, std::span<const Mirrored> axes,
                          double* values) {
  std::vector<fftw_r2r_kind> kinds;
  for (const Mirrored axis : axes) {
    kinds.push_back(axis == Mirrored::even ? FFTW_REDFT10 : FFTW_RODFT10);
  }
  const std::lock_guard lock(planner());
  return FftPlan(
      fftw_plan_r2r(axes_of(extent), extent.data(), values, values, kinds.data(), FFTW_ESTIMATE));
}

FftPlan FftPlan::from_mirrored(std::span<const int> extent, double* values) {
  const std::vector<fftw_r2r_kind> kinds(extent.size(), FFTW_REDFT01);
  const std::lock_guard lock(planner());
  return FftPlan(
      fftw_plan_r2r(axes_of(extent), extent.data(), values, values, kinds.data(), FFTW_ESTIMATE));
}

void FftPlan::run() const {
  fftw_execute(plan_.get());
}

}  // namespace carillon::core
