#include "eval/features/detail/tone_fit.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "eval/features/detail/tone_equations.hpp"

namespace carillon::eval::features {

namespace {

using Complex = std::complex<double>;
using Matrix = Eigen::MatrixXd;
using Vector = Eigen::VectorXd;

/// Bins on either side in which a tone that does not decay is fitted.
constexpr double narrow = 12;
/// And half widths of its line beyond: the rest holds 4 % of the information on its decay.
constexpr double half_widths = 5;
/// Ratio of widths of lines that are refined together.
constexpr double alike_limit = 4;

double bins_per_radian(const ToneFit& fit) {
  return static_cast<double>(fit.grid->count()) / (2 * std::numbers::pi);
}

BinRange join(const BinRange& a, const BinRange& b) {
  return {std::min(a.first, b.first), std::max(a.last, b.last)};
}

double separation_of(std::span<const Tone> tones, const Matrix& covariance, std::size_t tone) {
  double minimum = std::numeric_limits<double>::infinity();
  for (std::size_t t = 0; t < tones.size(); ++t) {
    if (t == tone) continue;
    double clearest = 0;
    const Complex apart = tones[t].rate - tones[tone].rate;
    for (const Eigen::Index part : {2, 3}) {
      const auto own = static_cast<Eigen::Index>(4 * tone) + part;
      const auto other = static_cast<Eigen::Index>(4 * t) + part;
      const double variance =
          covariance(own, own) + covariance(other, other) - 2 * covariance(own, other);
      const double distance = part == 2 ? apart.real() : apart.imag();
      if (variance > 0) clearest = std::max(clearest, std::abs(distance) / std::sqrt(variance));
    }
    minimum = std::min(minimum, clearest);
  }
  return minimum;
}

bool plausible(const ToneFit& fit, const Tone& tone) {
  const double n = static_cast<double>(fit.grid->count());
  const double bin = tone.rate.imag() * bins_per_radian(fit);
  return tone.rate.real() < 3 / n && -tone.rate.real() < fit.fastest &&
         bin > static_cast<double>(fit.band.first) - narrow &&
         bin < static_cast<double>(fit.band.last) + narrow && bin > 0;
}

}  // namespace

BinRange reach_of(const ToneFit& fit, Complex rate) {
  const double centre = rate.imag() * bins_per_radian(fit);
  const double half = narrow + half_widths * std::abs(rate.real()) * bins_per_radian(fit);
  const auto first = static_cast<double>(fit.band.first);
  const auto last = static_cast<double>(fit.band.last);
  return {static_cast<std::size_t>(std::clamp(centre - half, first, last - 1)),
          static_cast<std::size_t>(std::clamp(centre + half + 1, first + 1, last))};
}

ToneGain gain_of(const ToneFit& fit, std::span<const Complex> rates,
                 std::span<const std::size_t> instead) {
  BinRange range = reach_of(fit, rates[0]);
  for (const Complex rate : rates) range = join(range, reach_of(fit, rate));
  Residual residual(fit, range);
  const double chi = instead.empty() ? 0 : residual.chi_squared();
  for (const std::size_t k : instead) residual.add(fit.tones[k], 1);
  const double without = instead.empty() ? 0 : residual.chi_squared();
  std::vector<Tone> units;
  for (const Complex rate : rates) units.push_back({1, rate});
  const auto [information, slope] =
      normal_equations(jacobian_of(residual, units, 2), residual.weighted());
  const Vector scale = information.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const Eigen::LDLT<Matrix> factor(scale.asDiagonal() * information * scale.asDiagonal());
  if (!(factor.vectorD().minCoeff() > 1e-11)) return {std::vector<Complex>(rates.size()), 0};
  const Vector solution = scale.asDiagonal() * factor.solve(scale.asDiagonal() * slope);
  ToneGain gain;
  for (Eigen::Index t = 0; t < solution.size(); t += 2) {
    gain.amplitudes.emplace_back(solution(t), solution(t + 1));
  }
  gain.gain = solution.dot(slope) - (without - chi);
  return gain;
}

std::vector<std::size_t> neighbours(const ToneFit& fit, Complex rate, std::size_t maximum,
                                    double alike) {
  const double scale = bins_per_radian(fit);
  std::vector<std::pair<double, std::size_t>> near;
  for (std::size_t k = 0; k < fit.tones.size(); ++k) {
    const Complex other = fit.tones[k].rate;
    // Much broader and much narrower ones have their own turn: together they would need the bins of
    // the one at the distances of the other.
    const double own_width = 3 + std::abs(rate.real()) * scale;
    const double its_width = 3 + std::abs(other.real()) * scale;
    if (own_width > alike * its_width || its_width > alike * own_width) continue;
    const double apart = std::abs(other.imag() - rate.imag()) * scale;
    const double width = 3 + 2 * (std::abs(rate.real()) + std::abs(other.real())) * scale;
    if (apart < width) near.emplace_back(apart / width, k);
  }
  std::sort(near.begin(), near.end());
  if (near.size() > maximum) near.resize(maximum);
  std::vector<std::size_t> block;
  for (const auto& [distance, k] : near) block.push_back(k);
  return block;
}

namespace {

/// Moves tones to where chi squared is least: Levenberg-Marquardt on the normal equations, which
/// are summed over the bins, where Eigen's factors the Jacobian of all bins at each step.
/// @param bare      the residual without them
/// @param residual  with them
void minimise(const Residual& bare, std::vector<Tone>& tones, Residual& residual, int max_steps) {
  double chi = residual.chi_squared(), damping = 1e-4;
  Normal normal;
  bool fresh = false;
  for (int step = 0; step < max_steps; ++step) {
    if (!fresh) normal = normal_equations(residual, tones);
    fresh = true;
    const Vector scale = normal.information.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
    Matrix system = scale.asDiagonal() * normal.information * scale.asDiagonal();
    system.diagonal().array() += damping;
    const Vector move = scale.asDiagonal() * system.ldlt().solve(scale.asDiagonal() * normal.slope);
    std::vector<Tone> candidate = tones;
    bool fine = move.allFinite();
    for (std::size_t t = 0; t < candidate.size() && fine; ++t) {
      const auto at = static_cast<Eigen::Index>(4 * t);
      candidate[t].amplitude += Complex(move(at), move(at + 1));
      candidate[t].rate += Complex(move(at + 2), move(at + 3));
      fine = plausible(*bare.fit, candidate[t]);
    }
    double chi_new = std::numeric_limits<double>::infinity();
    Residual next = bare;
    if (fine) {
      for (const Tone& tone : candidate) next.add(tone, -1);
      chi_new = next.chi_squared();
    }
    if (!(chi_new <= chi)) {
      damping = std::max(damping, 1e-4) * 10;
      if (damping > 1e8) break;
      continue;
    }
    const double fallen = chi - chi_new;
    chi = chi_new;
    tones = std::move(candidate);
    residual = std::move(next);
    damping = std::max(damping * 0.1, 1e-12);
    if (fallen < 1e-4 + 1e-6 * chi) break;
    fresh = false;
  }
}

/// Bins that can be skipped: eight are left for half the width of the narrowest line.
std::size_t coarse_step(const ToneFit& fit, std::span<const Tone> tones) {
  double narrowest = std::numeric_limits<double>::infinity();
  for (const Tone& tone : tones) narrowest = std::min(narrowest, -tone.rate.real());
  return std::max<std::size_t>(
      1, static_cast<std::size_t>(std::max(0.0, narrowest) * bins_per_radian(fit) / 8));
}

}  // namespace

Proposal propose(const ToneFit& fit, std::span<const std::size_t> replaced,
                 std::span<const Tone> start, int max_steps, Fineness fineness) {
  Proposal proposal;
  proposal.replaced.assign(replaced.begin(), replaced.end());
  proposal.tones.assign(start.begin(), start.end());
  BinRange& range = proposal.range;
  range = reach_of(fit, start[0].rate);
  for (const Tone& tone : start) range = join(range, reach_of(fit, tone.rate));
  for (const std::size_t k : replaced) range = join(range, reach_of(fit, fit.tones[k].rate));
  std::vector<Tone>& tones = proposal.tones;
  const auto bare_on = [&](const BinRange& bins) {
    Residual bare(fit, bins);
    for (const std::size_t k : replaced) bare.add(fit.tones[k], 1);
    return bare;
  };
  const auto with_tones = [&](Residual residual) {
    for (const Tone& tone : tones) residual.add(tone, -1);
    return residual;
  };
  // Broad lines are smooth: most of the way goes on few bins, and the end on all.
  constexpr int last_steps = 3;
  BinRange coarse = range;
  coarse.step = coarse_step(fit, start);
  Normal normal;
  if (coarse.step > 1) {
    const Residual bare = bare_on(coarse);
    Residual residual = with_tones(bare);
    minimise(bare, tones, residual, max_steps);
    max_steps = fineness == Fineness::all_bins ? last_steps : 0;
    if (max_steps == 0) normal = normal_equations(residual, tones);
  }
  const Residual bare = bare_on(range);
  Residual residual = with_tones(bare);
  if (max_steps > 0) {
    minimise(bare, tones, residual, max_steps);
    normal = normal_equations(residual, tones);
  }
  const double chi = residual.chi_squared();
  proposal.gain = Residual(fit, range).chi_squared() - chi;
  proposal.misfit = std::max(1.0, chi / (2 * static_cast<double>(range.size())));

  // In standard errors of each by itself, which are smaller than those of the block.
  for (std::size_t t = 0; t < tones.size(); ++t) {
    const auto at = static_cast<Eigen::Index>(4 * t + 2);
    proposal.shift = std::max(proposal.shift, std::abs(tones[t].rate - start[t].rate) *
                                                  std::sqrt(normal.information(at, at)));
  }
  const Matrix covariance = covariance_of(normal.information);
  for (std::size_t t = 0; t < tones.size(); ++t) {
    proposal.separation.push_back(separation_of(tones, covariance, t));
  }
  proposal.residual = std::move(residual.values);
  return proposal;
}

namespace {

/// Changes the residual outside of a range by what a tone in place of another (null: of none) makes
/// there, as far as it is more than a 30th of the noise's amplitude: skirts fall with their
/// distance.
void update_beyond(ToneFit& fit, const Tone* before, const Tone& after, const BinRange& range) {
  constexpr double minimum = 1e-3;  // of the noise's power
  double reach = 0;
  const double centre = after.rate.imag() * bins_per_radian(fit);
  for (const std::size_t edge : {range.first, range.last - 1}) {
    Complex change = 0;
    fit.grid->add_part(after, -1, {edge, edge + 1}, {&change, 1});
    if (before) fit.grid->add_part(*before, 1, {edge, edge + 1}, {&change, 1});
    const double ratio = std::sqrt(std::norm(change) / (minimum * fit.noise[edge]));
    if (ratio > 1) {
      reach = std::max(reach, ratio * (1 + std::abs(static_cast<double>(edge) - centre)));
    }
  }
  if (reach == 0) return;
  const auto first = static_cast<double>(fit.band.first), last = static_cast<double>(fit.band.last);
  const BinRange below{static_cast<std::size_t>(std::clamp(centre - reach, first, last)),
                       range.first};
  const BinRange above{range.last,
                       static_cast<std::size_t>(std::clamp(centre + reach, first, last))};
  for (const BinRange& part : {below, above}) {
    fit.grid->add(after, -1, part, fit.residual);
    if (before) fit.grid->add(*before, 1, part, fit.residual);
  }
}

}  // namespace

void commit(ToneFit& fit, const Proposal& proposal) {
  for (std::size_t t = 0; t < proposal.tones.size(); ++t) {
    const bool replaces = t < proposal.replaced.size();
    Tone* const before = replaces ? &fit.tones[proposal.replaced[t]] : nullptr;
    update_beyond(fit, before, proposal.tones[t], proposal.range);
    if (replaces) {
      *before = proposal.tones[t];
    } else {
      fit.tones.push_back(proposal.tones[t]);
    }
  }
  std::copy(proposal.residual.begin(), proposal.residual.end(),
            fit.residual.begin() + static_cast<std::ptrdiff_t>(proposal.range.first));
}

void remove_tone(ToneFit& fit, std::size_t tone) {
  fit.grid->add(fit.tones[tone], 1, fit.band, fit.residual);
  fit.tones.erase(fit.tones.begin() + static_cast<std::ptrdiff_t>(tone));
}

void renew(ToneFit& fit) {
  fit.residual = fit.spectrum;
  for (const Tone& tone : fit.tones) fit.grid->add(tone, -1, fit.band, fit.residual);
}

void refine_all(ToneFit& fit, int max_rounds, Fineness fineness, std::size_t from) {
  constexpr std::size_t max_together = 6;
  constexpr int max_steps = 12;
  std::vector<bool> moving(fit.tones.size(), false);
  for (std::size_t k = from; k < fit.tones.size(); ++k) {
    for (const std::size_t near : neighbours(fit, fit.tones[k].rate, max_together, alike_limit)) {
      moving[near] = true;
    }
  }
  for (int round = 0; round < max_rounds; ++round) {
    bool any = false;
    double gained = 0;
    std::vector<bool> next(fit.tones.size(), false);
    std::vector<bool> refined(fit.tones.size(), false);
    for (std::size_t i = 0; i < fit.tones.size(); ++i) {
      // There and back, so that blocks change.
      const std::size_t k = round % 2 == 0 ? i : fit.tones.size() - 1 - i;
      if (!moving[k] || refined[k]) continue;
      const auto block = neighbours(fit, fit.tones[k].rate, max_together, alike_limit);
      std::vector<Tone> tones;
      for (const std::size_t other : block) tones.push_back(fit.tones[other]);
      const Proposal proposal = propose(fit, block, tones, max_steps, fineness);
      // The nearest have had all that matters to them in this block.
      for (std::size_t near = 0; near < (block.size() + 1) / 2; ++near) refined[block[near]] = true;
      if (!(proposal.gain > 0)) continue;
      commit(fit, proposal);
      gained += proposal.gain;
      if (proposal.shift < 0.02 * std::sqrt(proposal.misfit) ||
          proposal.gain < 0.01 * proposal.misfit) {
        continue;
      }
      any = true;
      for (const std::size_t other : block) next[other] = true;
    }
    // Of what is no sum of damped sinusoids no last digits are sought.
    const double usual = 2 * static_cast<double>(fit.band.size());
    const double excess = Residual(fit, fit.band).chi_squared() - 1.1 * usual;
    if (!any || gained < 0.1 + 1e-4 * std::max(0.0, excess)) break;
    moving = next;
  }
  renew(fit);
}

ToneErrors errors_of(const ToneFit& fit, std::size_t tone) {
  constexpr std::size_t max_together = 10;
  // Itself first: nothing is nearer.
  const auto block = neighbours(fit, fit.tones[tone].rate, max_together);
  BinRange range = reach_of(fit, fit.tones[tone].rate);
  std::vector<Tone> tones = {fit.tones[tone]};
  for (const std::size_t k : block) {
    if (k == tone) continue;
    tones.push_back(fit.tones[k]);
    range = join(range, reach_of(fit, fit.tones[k].rate));
  }
  const Matrix covariance =
      covariance_of(normal_equations(Residual(fit, range), tones).information);

  ToneErrors errors;
  const Complex direction = fit.tones[tone].amplitude / std::abs(fit.tones[tone].amplitude);
  const double c = direction.real(), s = direction.imag();
  const double vr = covariance(0, 0), vi = covariance(1, 1), cov = covariance(0, 1);
  const auto root = [](double variance) { return std::sqrt(std::max(0.0, variance)); };
  const double along = c * c * vr + 2 * c * s * cov + s * s * vi;
  errors.amplitude_real = root(along);
  errors.amplitude_imag = root(s * s * vr - 2 * c * s * cov + c * c * vi);
  errors.rate_real = root(covariance(2, 2));
  errors.rate_imag = root(covariance(3, 3));
  errors.covariance = c * covariance(0, 2) + s * covariance(1, 2);
  errors.separation = separation_of(tones, covariance, 0);
  const BinRange own = reach_of(fit, fit.tones[tone].rate);
  errors.misfit =
      std::max(1.0, Residual(fit, own).chi_squared() / (2 * static_cast<double>(own.size())));
  return errors;
}

}  // namespace carillon::eval::features
