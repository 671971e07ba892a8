#include "render/maps/detail/fourier_grid.hpp"

#include <algorithm>

namespace carillon::render::maps {

using core::FftPlan;
using core::Mirrored;

FourierGrid::FourierGrid(int width, int height)
    : width_(width), stride_(2 * static_cast<std::size_t>(width / 2 + 1)) {
  const std::size_t count = stride_ * static_cast<std::size_t>(height);
  values_ = core::fft_numbers(count);
  const int extent[] = {height, width};
  forward_ = FftPlan::forward(extent, values_.get(), &wave(0, 0));
  inverse_ = FftPlan::inverse(extent, &wave(0, 0), values_.get());
  std::fill_n(values_.get(), count, 0.0);
}

void FourierGrid::forward() {
  forward_.run();
}

void FourierGrid::inverse() {
  inverse_.run();
}

namespace {

/// FFTW's factors: every coefficient comes n times as large, the one that alternates and the mean
/// 2 n times (they are their own mirror images).
double factor(int k, int n, Mirrored symmetry) {
  const bool alone = symmetry == Mirrored::even ? k == 0 : k == n - 1;
  return (alone ? 0.5 : 1.0) / n;
}

}  // namespace

void to_mirrored_waves(std::span<double> values, int width, int height, Mirrored along_width,
                       Mirrored along_height) {
  const int extent[] = {height, width};
  const Mirrored axes[] = {along_height, along_width};
  FftPlan::mirrored(extent, axes, values.data()).run();
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
  const int extent[] = {height, width};
  FftPlan::from_mirrored(extent, values.data()).run();
}

}  // namespace carillon::render::maps
