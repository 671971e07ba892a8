#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "synth/modal/contact_force.hpp"
#include "synth/modal/readout.hpp"
#include "synth/motion/detail/driven_bank.hpp"
#include "synth/motion/detail/driven_strike.hpp"

namespace carillon::synth::motion {

/// A force on a body over a block, at a place that may move.
struct Drive {
  Eigen::MatrixX3d begin;   ///< mode shapes at the place at the block's first sample, modes x 3
  Eigen::MatrixX3d end;     ///< at the sample after its last
  Eigen::Matrix3Xd forces;  ///< [N] at the block's samples and the one after: count + 1 columns
  /// Rates of them as far as they are slow against the modes of each octave (slow_rates()): count
  /// columns each; none: an octave's modes have none, or readouts do not ask.
  std::vector<Eigen::Matrix3Xf> slow_rates = {};
};

/// Gains of rows over a block: those of `before` go over into those of `after` in a straight line.
/// Delays are not looked at: rows are as they leave the body.
struct DrivenGains {
  const modal::Readout* before = nullptr;
  const modal::Readout* after = nullptr;  ///< may be the same
  double begin = 0;                       ///< fraction of `after` at the block's first sample
  double end = 0;                         ///< at the sample after its last
};

/// Modes of one body under any forces at audio rate, q'' + 2 d q' + lambda q = phi . F.
///
/// Exact at the samples for forces that are straight lines between them, whatever the damping
/// (linear_force_step()), and for strikes of any duration and time, however short: during contact
/// their motion is added to what is heard, and at the first sample after it to the modes, as
/// synthesize() has it. Decay rates may change between blocks. Modes whose damped frequency is at
/// or above Nyquist are left out. Modes that have decayed below inaudible of the loudest sample
/// since the last force or strike rest; a body at rest costs nothing.
class DrivenModes {
 public:
  /// @throws InputError  sizes that do not match, values that are negative or not finite
  DrivenModes(std::span<const double> eigenvalues, std::span<const double> decay_rates,
              double sample_rate);

  /// Decay rates from the next sample on; steps are made anew where they change.
  /// @throws InputError  as the constructor
  void set_decay_rates(std::span<const double> decay_rates);

  /// A strike that begins `delay` seconds after the next sample (any fraction of one).
  /// @param excitation  phi . impulse of the body's modes [N s kg^-1/2]
  /// @throws InputError  sizes, values that are not finite, a negative delay, a contact of more
  ///                     than 1e5 samples
  void strike(const Eigen::VectorXd& excitation, const modal::ContactForce& force, double delay);

  /// The next samples.
  /// @param rows  receives them, samples x rows, added to what is there
  /// @throws InputError  sizes that do not match, a force that is not finite
  void render(std::span<const Drive> drives, const DrivenGains& gains,
              Eigen::Ref<Eigen::MatrixXd> rows);
  /// Goes on by samples of silence without looking at gains. Only if resting().
  void skip(std::size_t count);

  /// No mode rings and no strike waits or acts.
  bool resting() const { return sounding_ == 0 && strikes_.empty(); }
  /// Samples until the first strike that waits begins; the largest number where none does.
  std::uint64_t until_strike() const;
  std::uint64_t position() const { return position_; }  ///< samples so far
  /// Which octaves of slow_rates.hpp have modes.
  std::vector<bool> octaves() const;
  std::uint64_t mode_samples() const { return mode_samples_; }  ///< modes moved on by a sample
  std::size_t modes() const { return order_.size(); }           ///< below Nyquist

 private:
  /// Weights of the bank's motion in the rows, filled up to whole vectors; padded modes x rows.
  struct Weights {
    Eigen::MatrixXd of_q, of_v, of_force, of_rate;
  };

  Weights weights_of(const modal::Readout& readout) const;
  void set_steps(std::span<const double> decay_rates, bool all);
  void run(std::span<const Drive> drives, const DrivenGains& gains, std::size_t offset,
           std::size_t count, Eigen::Ref<Eigen::MatrixXd> rows);
  void add_slow_rates(const Drive& drive, const std::array<Weights, 2>& weights, std::size_t keys,
                      std::size_t offset, const Eigen::VectorXd& fractions,
                      Eigen::Ref<Eigen::MatrixXd> rows, Eigen::Index total) const;
  void add_strike(const DrivenStrike& strike, const std::array<Weights, 2>& weights,
                  std::size_t keys, const Eigen::VectorXd& fractions,
                  Eigen::Ref<Eigen::MatrixXd> rows) const;
  void rest_inaudible(const std::array<Weights, 2>& weights, std::size_t keys);

  double sample_rate_;
  std::vector<std::size_t> order_;  ///< the bank's modes among those given, slow decays first
  std::size_t given_ = 0;           ///< modes given
  std::vector<double> eigenvalues_, decay_rates_;  ///< in the bank's order
  DrivenBank bank_;
  std::vector<DrivenStrike> strikes_;
  std::size_t sounding_ = 0;  ///< of the bank's modes, the first ones that do not rest
  double peak_ = 0;           ///< since the last force or strike
  std::uint64_t position_ = 0;
  std::uint64_t mode_samples_ = 0;
};

}  // namespace carillon::synth::motion
