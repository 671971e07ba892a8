#pragma once

#include <complex>
#include <cstddef>
#include <span>

#include "core/fft.hpp"

namespace carillon::render::maps {

/// Real numbers on a grid that repeats, and their Fourier transform, in one piece of memory.
class FourierGrid {
 public:
  FourierGrid(int width, int height);

  double& at(int column, int row) {
    return values_[std::size_t(row) * stride_ + std::size_t(column)];
  }
  /// Coefficient of exp(2 pi i (column x / width + row y / height)); columns 0 to width / 2.
  std::complex<double>& wave(int column, int row) {
    return reinterpret_cast<std::complex<double>*>(
        values_.get())[std::size_t(row) * (stride_ / 2) + std::size_t(column)];
  }
  int waves() const { return width_ / 2 + 1; }

  void forward();  ///< no factor
  void inverse();  ///< no factor: forward, then inverse, multiplies by width times height

 private:
  int width_;
  std::size_t stride_;
  core::FftNumbers values_;
  core::FftPlan forward_, inverse_;
};

/// Half a period of numbers that go on mirrored, with or without a change of sign, at both of their
/// edges (half a step beyond the last), as sums of cosines or sines: values[row * width + column].
///
/// Even: x_j = sum over k = 0..n-1 of c_k cos(pi k (j + 1/2) / n), stored at k.
/// Odd:  x_j = sum over k = 1..n of c_k sin(pi k (j + 1/2) / n), stored at k - 1.
void to_mirrored_waves(std::span<double> values, int width, int height, core::Mirrored along_width,
                       core::Mirrored along_height);
/// Back, of even symmetry both ways.
void from_mirrored_waves(std::span<double> values, int width, int height);

}  // namespace carillon::render::maps
