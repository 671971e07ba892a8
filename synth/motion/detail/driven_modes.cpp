#include "synth/motion/detail/driven_modes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.hpp"
#include "synth/modal/modal_response.hpp"
#include "synth/modal/ring_down.hpp"
#include "synth/modal/row_response.hpp"
#include "synth/motion/detail/slow_rates.hpp"

namespace carillon::synth::motion {

namespace {

/// Whether a place stands still over a block.
bool still(const Drive& drive) {
  return drive.begin == drive.end;
}

}  // namespace

DrivenModes::DrivenModes(std::span<const double> eigenvalues, std::span<const double> decay_rates,
                         double sample_rate)
    : sample_rate_(sample_rate), given_(eigenvalues.size()), bank_(0) {
  // Looks at the values, too.
  const modal::Resonances resonances =
      modal::make_resonances(eigenvalues, decay_rates, sample_rate);
  for (const modal::Resonances::Mode& mode : resonances.modes) order_.push_back(mode.index);
  std::stable_sort(order_.begin(), order_.end(),
                   [&](std::size_t a, std::size_t b) { return decay_rates[a] < decay_rates[b]; });
  for (const std::size_t mode : order_) eigenvalues_.push_back(eigenvalues[mode]);
  bank_ = DrivenBank(order_.size());
  decay_rates_.resize(order_.size());
  set_steps(decay_rates, true);
}

void DrivenModes::set_decay_rates(std::span<const double> decay_rates) {
  set_steps(decay_rates, false);
}

void DrivenModes::set_steps(std::span<const double> decay_rates, bool all) {
  if (decay_rates.size() != given_) {
    throw core::InputError(
        fmt::format("driven modes: {} decay rates for {} modes", decay_rates.size(), given_));
  }
  for (std::size_t i = 0; i < order_.size(); ++i) {
    const double rate = decay_rates[order_[i]];
    if (!(rate >= 0 && rate < 1e100)) {
      throw core::InputError(
          fmt::format("driven modes: decay rate of mode {} must be finite and not negative, not {} "
                      "1/s",
                      order_[i], rate));
    }
    if (!all && rate == decay_rates_[i]) continue;
    decay_rates_[i] = rate;
    bank_.set_step(i, modal::linear_force_step(eigenvalues_[i], rate, 1 / sample_rate_));
  }
}

void DrivenModes::strike(const Eigen::VectorXd& excitation, const modal::ContactForce& force,
                         double delay) {
  if (excitation.size() != static_cast<Eigen::Index>(given_) || !excitation.allFinite()) {
    throw core::InputError(fmt::format("driven modes: a strike must have {} finite values, not {}",
                                       given_, excitation.size()));
  }
  Eigen::VectorXd own(static_cast<Eigen::Index>(order_.size()));
  for (std::size_t i = 0; i < order_.size(); ++i) {
    own[static_cast<Eigen::Index>(i)] = excitation[static_cast<Eigen::Index>(order_[i])];
  }
  DrivenStrike strike = driven_strike(eigenvalues_, decay_rates_, own, force, delay, sample_rate_);
  strike.first += position_;
  strike.free += position_;
  strikes_.push_back(std::move(strike));
}

std::uint64_t DrivenModes::until_strike() const {
  std::uint64_t minimum = std::numeric_limits<std::uint64_t>::max();
  for (const DrivenStrike& strike : strikes_) {
    minimum = std::min(minimum, strike.first > position_ ? strike.first - position_ : 0);
  }
  return minimum;
}

DrivenModes::Weights DrivenModes::weights_of(const modal::Readout& readout) const {
  const auto rows = static_cast<Eigen::Index>(readout.delays.size());
  for (const Eigen::MatrixXd* gains : modal::gains_of(readout)) {
    if (gains->size() == 0) continue;
    if (gains->rows() == rows && gains->cols() == static_cast<Eigen::Index>(given_)) continue;
    throw core::InputError(
        fmt::format("driven modes: gains of {} rows and {} modes where {} and {} are meant",
                    gains->rows(), gains->cols(), rows, given_));
  }
  const auto filled = static_cast<Eigen::Index>(bank_.q.size());
  Weights weights;
  for (Eigen::MatrixXd* matrix :
       {&weights.of_q, &weights.of_v, &weights.of_force, &weights.of_rate}) {
    *matrix = Eigen::MatrixXd::Zero(filled, rows);
  }
  for (std::size_t i = 0; i < order_.size(); ++i) {
    const auto to = static_cast<Eigen::Index>(i), from = static_cast<Eigen::Index>(order_[i]);
    for (Eigen::Index row = 0; row < rows; ++row) {
      const modal::Weights of = modal::weights_of(readout, row, from, 1);
      // q'' = F - 2 d q' - lambda q.
      weights.of_q(to, row) = of.displacement - eigenvalues_[i] * of.acceleration;
      weights.of_v(to, row) = of.velocity - 2 * decay_rates_[i] * of.acceleration;
      weights.of_force(to, row) = of.acceleration;
      weights.of_rate(to, row) = of.force_rate;
    }
  }
  return weights;
}

void DrivenModes::skip(std::size_t count) {
  position_ += count;
}

void DrivenModes::render(std::span<const Drive> drives, const DrivenGains& gains,
                         Eigen::Ref<Eigen::MatrixXd> rows) {
  const auto count = static_cast<std::size_t>(rows.rows());
  for (const Drive& drive : drives) {
    const auto modes = static_cast<Eigen::Index>(given_);
    if (drive.begin.rows() != modes || drive.end.rows() != modes ||
        drive.forces.cols() != rows.rows() + 1) {
      throw core::InputError(
          fmt::format("driven modes: a drive of {} modes and {} samples where {} and {} are meant",
                      drive.begin.rows(), drive.forces.cols(), modes, count + 1));
    }
    for (const Eigen::Matrix3Xf& rates : drive.slow_rates) {
      if (rates.cols() == 0 || rates.cols() == rows.rows()) continue;
      throw core::InputError(
          fmt::format("driven modes: rates of {} samples where {} are meant", rates.cols(), count));
    }
    if (!drive.forces.allFinite()) throw core::InputError("driven modes: a force is not finite");
  }
  if (gains.before == nullptr || gains.after == nullptr ||
      static_cast<Eigen::Index>(gains.before->delays.size()) != rows.cols() ||
      static_cast<Eigen::Index>(gains.after->delays.size()) != rows.cols()) {
    throw core::InputError("driven modes: gains do not fit the rows");
  }
  for (std::size_t done = 0; done < count;) {
    for (std::size_t b = 0; b < strikes_.size();) {
      if (strikes_[b].free > position_) {
        ++b;
        continue;
      }
      for (std::size_t i = 0; i < order_.size(); ++i) {
        bank_.q[i] += strikes_[b].end_displacement[static_cast<Eigen::Index>(i)];
        bank_.v[i] += strikes_[b].end_velocity[static_cast<Eigen::Index>(i)];
      }
      sounding_ = order_.size();
      if (strikes_[b].first == strikes_[b].free) peak_ = 0;
      strikes_.erase(strikes_.begin() + static_cast<std::ptrdiff_t>(b));
    }
    std::uint64_t stretch = std::min(bank_stretch, count - done);
    for (const DrivenStrike& strike : strikes_)
      stretch = std::min(stretch, strike.free - position_);
    run(drives, gains, done, stretch, rows);
    position_ += stretch;
    done += stretch;
  }
}

void DrivenModes::run(std::span<const Drive> drives, const DrivenGains& gains, std::size_t offset,
                      std::size_t count, Eigen::Ref<Eigen::MatrixXd> rows) {
  if (sounding_ == 0 && drives.empty() && until_strike() >= count) return;
  const auto total = static_cast<double>(rows.rows());
  const auto first = static_cast<Eigen::Index>(offset), length = static_cast<Eigen::Index>(count);
  const bool fixed = gains.before == gains.after || (gains.begin == 0 && gains.end == 0);
  const std::size_t keys = fixed ? 1 : 2;
  std::array<Weights, 2> weights;
  weights[0] = weights_of(*gains.before);
  if (keys == 2) weights[1] = weights_of(*gains.after);
  const Eigen::VectorXd place =
      (Eigen::VectorXd::LinSpaced(length + 1, 0, static_cast<double>(count)).array() +
       static_cast<double>(offset)) /
      total;
  const Eigen::VectorXd fractions = gains.begin + (gains.end - gains.begin) * place.array();

  // Forces: shapes in the bank's order, and their courses.
  std::vector<std::vector<double>> shapes;
  std::vector<Eigen::VectorXd> courses;
  DrivenForces forces;
  for (const Drive& drive : drives) {
    const bool one = still(drive);
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::VectorXd course = drive.forces.row(axis).segment(first, length + 1);
      if (course.isZero(0)) continue;
      for (int end = 0; end < (one ? 1 : 2); ++end) {
        const Eigen::MatrixX3d& from = end == 0 ? drive.begin : drive.end;
        std::vector<double>& shape = shapes.emplace_back(bank_.q.size(), 0.0);
        for (std::size_t i = 0; i < order_.size(); ++i) {
          shape[i] = from(static_cast<Eigen::Index>(order_[i]), axis);
        }
        Eigen::VectorXd& own = courses.emplace_back(course);
        if (one) continue;
        if (end == 0) {
          own.array() *= 1 - place.array();
        } else {
          own.array() *= place.array();
        }
      }
    }
  }
  for (std::size_t part = 0; part < shapes.size(); ++part) {
    forces.shapes.push_back(shapes[part].data());
    forces.courses.push_back(courses[part].data());
  }
  if (!shapes.empty()) {
    sounding_ = order_.size();
    peak_ = 0;
  }

  Eigen::MatrixXd sums = Eigen::MatrixXd::Zero(length, rows.cols() * static_cast<int>(keys));
  if (sounding_ > 0) {
    std::vector<BankOutput> outputs;
    for (std::size_t key = 0; key < keys; ++key) {
      for (Eigen::Index row = 0; row < rows.cols(); ++row) {
        const Eigen::Index column = static_cast<Eigen::Index>(key) * rows.cols() + row;
        outputs.push_back({weights[key].of_q.col(row).data(), weights[key].of_v.col(row).data(),
                           sums.col(column).data()});
      }
    }
    const std::size_t filled = (sounding_ + bank_lanes - 1) / bank_lanes * bank_lanes;
    run_bank(bank_, filled, forces, outputs, count);
    mode_samples_ += sounding_ * count;
    for (std::size_t part = 0; part < shapes.size(); ++part) {
      const Eigen::Map<const Eigen::VectorXd> shape(shapes[part].data(),
                                                    static_cast<Eigen::Index>(shapes[part].size()));
      for (Eigen::Index column = 0; column < sums.cols(); ++column) {
        const auto& of_force = weights[static_cast<std::size_t>(column / rows.cols())].of_force;
        sums.col(column) +=
            shape.dot(of_force.col(column % rows.cols())) * courses[part].head(length);
      }
    }
  }
  const Eigen::VectorXd after = fractions.head(length);
  for (Eigen::Index row = 0; row < rows.cols(); ++row) {
    auto to = rows.col(row).segment(first, length);
    if (keys == 1) {
      to += sums.col(row);
    } else {
      to.array() += (1 - after.array()) * sums.col(row).array() +
                    after.array() * sums.col(rows.cols() + row).array();
    }
    peak_ = std::max(peak_, to.cwiseAbs().maxCoeff());
  }
  for (const DrivenStrike& strike : strikes_) {
    if (strike.first >= position_ + count) continue;
    if (strike.first >= position_) peak_ = 0;
    add_strike(strike, weights, keys, after, rows.middleRows(first, length));
  }
  for (const Drive& drive : drives) {
    add_slow_rates(drive, weights, keys, offset, after, rows.middleRows(first, length),
                   rows.rows());
  }
  if (shapes.empty()) rest_inaudible(weights, keys);
}

std::vector<bool> DrivenModes::octaves() const {
  std::vector<bool> present(mode_octaves, false);
  for (const double eigenvalue : eigenvalues_) present[octave_of(eigenvalue)] = true;
  return present;
}

void DrivenModes::add_slow_rates(const Drive& drive, const std::array<Weights, 2>& weights,
                                 std::size_t keys, std::size_t offset,
                                 const Eigen::VectorXd& fractions, Eigen::Ref<Eigen::MatrixXd> rows,
                                 Eigen::Index total) const {
  if (drive.slow_rates.empty()) return;
  const auto count = static_cast<Eigen::Index>(rows.rows());
  for (std::size_t key = 0; key < keys; ++key) {
    for (Eigen::Index row = 0; row < rows.cols(); ++row) {
      // What a rate along each axis gives, summed over an octave's modes: at the block's ends.
      Eigen::MatrixX3d begin = Eigen::MatrixX3d::Zero(mode_octaves, 3), end = begin;
      bool any = false;
      for (std::size_t i = 0; i < order_.size(); ++i) {
        const double of_rate = weights[key].of_rate(static_cast<Eigen::Index>(i), row);
        if (of_rate == 0) continue;
        any = true;
        const auto octave = static_cast<Eigen::Index>(octave_of(eigenvalues_[i]));
        const auto mode = static_cast<Eigen::Index>(order_[i]);
        begin.row(octave) += of_rate * drive.begin.row(mode);
        end.row(octave) += of_rate * drive.end.row(mode);
      }
      for (std::size_t octave = 0; any && octave < drive.slow_rates.size(); ++octave) {
        const Eigen::Matrix3Xf& rates = drive.slow_rates[octave];
        if (rates.cols() == 0) continue;
        const auto o = static_cast<Eigen::Index>(octave);
        for (Eigen::Index n = 0; n < count; ++n) {
          const Eigen::Index at = static_cast<Eigen::Index>(offset) + n;
          const double place = static_cast<double>(at) / static_cast<double>(total);
          const double fraction = keys == 1 ? 1 : key == 0 ? 1 - fractions[n] : fractions[n];
          rows(n, row) += fraction * (begin.row(o) + place * (end.row(o) - begin.row(o)))
                                         .dot(rates.col(at).cast<double>().transpose());
        }
      }
    }
  }
}

void DrivenModes::add_strike(const DrivenStrike& strike, const std::array<Weights, 2>& weights,
                             std::size_t keys, const Eigen::VectorXd& fractions,
                             Eigen::Ref<Eigen::MatrixXd> rows) const {
  const auto modes = static_cast<Eigen::Index>(order_.size());
  const std::uint64_t begin = std::max(strike.first, position_);
  const std::uint64_t end =
      std::min(strike.free, position_ + static_cast<std::uint64_t>(rows.rows()));
  for (std::uint64_t n = begin; n < end; ++n) {
    const auto sample = static_cast<Eigen::Index>(n - strike.first);
    const auto at = static_cast<Eigen::Index>(n - position_);
    for (std::size_t key = 0; key < keys; ++key) {
      const double fraction = keys == 1 ? 1 : key == 0 ? 1 - fractions[at] : fractions[at];
      const Weights& of = weights[key];
      for (Eigen::Index row = 0; row < rows.cols(); ++row) {
        rows(at, row) +=
            fraction *
            (of.of_q.col(row).head(modes).dot(strike.displacement.col(sample)) +
             of.of_v.col(row).head(modes).dot(strike.velocity.col(sample)) +
             of.of_rate.col(row).head(modes).dot(strike.force_rate.col(sample)) +
             of.of_force.col(row).head(modes).dot(strike.excitation) * strike.force[sample]);
      }
    }
  }
}

void DrivenModes::rest_inaudible(const std::array<Weights, 2>& weights, std::size_t keys) {
  const double level =
      modal::inaudible * peak_ / static_cast<double>(std::max<std::size_t>(1, modes()));
  while (sounding_ > 0) {
    const std::size_t i = sounding_ - 1;
    // Free modes lose energy whatever their damping: q and q' stay below what it allows.
    const double energy = eigenvalues_[i] * bank_.q[i] * bank_.q[i] + bank_.v[i] * bank_.v[i];
    if (energy > 0) {
      const double v = std::sqrt(energy);
      const double q = eigenvalues_[i] > 0 ? v / std::sqrt(eigenvalues_[i])
                                           : std::numeric_limits<double>::infinity();
      double heard = 0;
      for (std::size_t key = 0; key < keys; ++key) {
        const auto mode = static_cast<Eigen::Index>(i);
        const double of_q = weights[key].of_q.row(mode).cwiseAbs().maxCoeff();
        const double of_v = weights[key].of_v.row(mode).cwiseAbs().maxCoeff();
        heard = std::max(heard, (of_q > 0 ? of_q * q : 0) + of_v * v);
      }
      if (heard > level) return;
      bank_.q[i] = bank_.v[i] = 0;
    }
    --sounding_;
  }
}

}  // namespace carillon::synth::motion
