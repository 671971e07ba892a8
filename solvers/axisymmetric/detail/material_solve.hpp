#pragma once

#include <cstdint>
#include <vector>

#include "core/trace.hpp"
#include "solvers/axisymmetric/detail/harmonic_search.hpp"
#include "solvers/eigen/solve_modes.hpp"

namespace carillon::solvers::axisymmetric {

class TurnedSurface;

/// The modes of a body in one material, on sections that bodies in other materials share.
class MaterialSolve {
 public:
  /// @param size     of the body
  /// @param options  tolerance, time and whether errors are estimated; its band is not used
  MaterialSolve(const mesh::MeridianSize& size, const elements::Elastic& material,
                const modes::Band& band, const eigen::SolveOptions& options, core::Trace& trace);

  /// Largest wave number [rad/m] among the modes that are sought.
  double largest_wave_number() const;
  /// How many modes should be kept.
  double expected_modes() const;
  /// Of these, the highest harmonic.
  double expected_harmonic() const;

  /// Counts the modes on a section, up to a higher frequency while too few are found.
  /// @param section  in any material
  void count(const HarmonicForms& section);
  /// Finds the modes that were counted.
  /// @throws core::TimeError  time has passed; count() and estimate_errors() too
  void solve();
  /// Compares with the same cells at the next order.
  /// @param saturation  an error over what the next order changes
  /// @return the worst error [cents]
  double estimate_errors(const HarmonicForms& finer_section, double saturation);
  /// Keeps the modes of the band. @return the highest harmonic among them
  int select();
  /// What select() kept, on a surface that is made for its harmonics or higher ones.
  modes::Modes modes_on(const TurnedSurface& surface) const;

 private:
  /// A mode of the whole body: one of a harmonic's pairs, or the one turned against it.
  struct Found {
    double eigenvalue;  ///< [rad^2/s^2]
    std::size_t harmonic, pair;
    bool turned;
    double pitch_error;  ///< [cents]

    double frequency() const;
  };

  std::size_t wanted() const { return static_cast<std::size_t>(band_.max_modes); }
  double first_top() const;
  /// Lowest frequency up to the band's top below which so many modes should be [Hz].
  double frequency_of(double modes) const;
  bool enough() const;
  void heed_time() const;
  void list();
  void certify(modes::Modes& modes) const;

  mesh::MeridianSize size_;
  elements::Elastic material_;
  modes::Band band_;
  const eigen::SolveOptions& options_;
  core::Trace& trace_;
  double estimate_;  ///< of the lowest flexible frequency [Hz]
  double top_;       ///< frequency up to which modes are sought [Hz]
  HarmonicForms forms_;
  std::vector<Harmonic> harmonics_;
  std::vector<Found> found_;   ///< every mode that was counted, ascending
  std::vector<Found> inside_;  ///< those in the band
  std::size_t kept_ = 0;       ///< the first so many of `inside_`
};

}  // namespace carillon::solvers::axisymmetric
