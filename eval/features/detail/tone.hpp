#pragma once

#include <complex>
#include <cstddef>
#include <span>
#include <vector>

namespace carillon::eval::features {

/// A damped sinusoid x[n] = Re(amplitude exp(rate n)), n = 0 .. count - 1.
struct Tone {
  std::complex<double> amplitude;
  std::complex<double> rate;  ///< (-d + 2 pi i f) / sample rate
  double tried = 0;           ///< chi squared around it when it was last tried as two, in vain
};

/// Every `step`-th of the bins [first, last) of a discrete Fourier transform.
struct BinRange {
  std::size_t first = 0;
  std::size_t last = 0;
  std::size_t step = 1;
  std::size_t size() const { return last > first ? (last - first + step - 1) / step : 0; }
  std::size_t at(std::size_t i) const { return first + i * step; }
};

/// The discrete Fourier transform of `count` samples, on which tones have closed forms.
class ToneGrid {
 public:
  explicit ToneGrid(std::size_t count);
  std::size_t count() const { return count_; }
  std::size_t bins() const { return cos_.size(); }

  /// Adds factor times a tone's transform on a range of bins.
  /// @param spectrum  all bins
  void add(const Tone& tone, double factor, BinRange range,
           std::span<std::complex<double>> spectrum) const;
  /// The same where only the range is at hand.
  /// @param part  range.size() bins
  void add_part(const Tone& tone, double factor, BinRange range,
                std::span<std::complex<double>> part) const;

  /// Derivatives of a tone's transform with respect to the real and imaginary parts of its
  /// amplitude, and to those of its rate: 4 columns, each of range.size() bins.
  void derivatives(const Tone& tone, BinRange range, std::span<std::complex<double>> columns) const;

 private:
  std::size_t count_;
  std::vector<double> cos_, sin_;  ///< of omega_k
};

/// Adds factor times a tone to a signal over time.
void add_tone(std::span<double> signal, const Tone& tone, double factor);

/// Energy of a tone over the samples: sum of x[n]^2, without the part that oscillates at twice its
/// frequency.
double energy(const Tone& tone, std::size_t count);

/// Sum of a[n] b[n] over the samples, without the part that oscillates at the sum of their
/// frequencies; energy(a) where b is a.
double product(const Tone& a, const Tone& b, std::size_t count);

}  // namespace carillon::eval::features
