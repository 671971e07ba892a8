#include "render/maps/fourier_grid.hpp"

#include <fftw3.h>

#include <mutex>

#include "core/fft_planner.hpp"

namespace carillon::render::maps {

FourierGrid::FourierGrid(int width, int height)
    : width_(width), stride_(2 * static_cast<std::size_t>(width / 2 + 1)) {
  const std::lock_guard lock(core::fft_planner());
  values_ = fftw_alloc_real(stride_ * static_cast<std::size_t>(height));
  auto* waves = reinterpret_cast<fftw_complex*>(values_);
  forward_ = fftw_plan_dft_r2c_2d(height, width, values_, waves, FFTW_ESTIMATE);
  inverse_ = fftw_plan_dft_c2r_2d(height, width, waves, values_, FFTW_ESTIMATE);
  for (std::size_t i = 0; i < stride_ * static_cast<std::size_t>(height); ++i) values_[i] = 0;
}

FourierGrid::~FourierGrid() {
  const std::lock_guard lock(core::fft_planner());
  fftw_destroy_plan(static_cast<fftw_plan>(forward_));
  fftw_destroy_plan(static_cast<fftw_plan>(inverse_));
  fftw_free(values_);
}

void FourierGrid::forward() {
  fftw_execute(static_cast<fftw_plan>(forward_));
}

void FourierGrid::inverse() {
  fftw_execute(static_cast<fftw_plan>(inverse_));
}

namespace {

void transform(std::span<double> values, int width, int height, fftw_r2r_kind along_width,
               fftw_r2r_kind along_height) {
  fftw_plan plan = nullptr;
  {
    const std::lock_guard lock(core::fft_planner());
    plan = fftw_plan_r2r_2d(height, width, values.data(), values.data(), along_height, along_width,
                            FFTW_ESTIMATE);
  }
  fftw_execute(plan);
  const std::lock_guard lock(core::fft_planner());
  fftw_destroy_plan(plan);
}

/// FFTW's factors: every coefficient comes n times as large, the one that alternates and the mean
/// 2 n times (they are their own mirror images).
double factor(int k, int n, Symmetry symmetry) {
  const bool alone = symmetry == Symmetry::even ? k == 0 : k == n - 1;
  return (alone ? 0.5 : 1.0) / n;
}

}  // namespace

void to_mirrored_waves(std::span<double> values, int width, int height, Symmetry along_width,
                       Symmetry along_height) {
  const auto kind = [](Symmetry symmetry) {
    return symmetry == Symmetry::even ? FFTW_REDFT10 : FFTW_RODFT10;
  };
  transform(values, width, height, kind(along_width), kind(along_height));
  for (int row = 0; row < height; ++row) {
    for (int column = 0; column < width; ++column) {
      values[std::size_t(row) * std::size_t(width) + std::size_t(column)] *=
          factor(row, height, along_height) * factor(column, width, along_width);
    }
  }
}

void from_mirrored_waves(std::span<double> values, int width, int height) {
  // FFTW counts every coefficient but the mean twice.
  for (int row = 0; row < height; ++row) {
    for (int column = 0; column < width; ++column) {
      values[std::size_t(row) * std::size_t(width) + std::size_t(column)] *=
          (row == 0 ? 1 : 0.5) * (column == 0 ? 1 : 0.5);
    }
  }
  transform(values, width, height, FFTW_REDFT01, FFTW_REDFT01);
}

}  // namespace carillon::render::maps
