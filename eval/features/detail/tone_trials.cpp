#include "eval/features/detail/tone_trials.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "eval/features/detail/esprit.hpp"

namespace carillon::eval::features {

namespace {

using Complex = std::complex<double>;

constexpr double second_of_pair = 24, parted_anew = 6;
/// Standard errors by which the rates of two tones differ.
constexpr double min_separation = 2;
/// Of a neighbour's energy, in its line and beside it: what is weaker describes how that one fails
/// to be a damped sinusoid.
constexpr double min_fraction = 1e-2, min_fraction_beside = 1e-3;
/// Of a pair's chi squared, which a third tone in the same line must explain.
constexpr double third_fraction = 1e-4;
/// Of what a tone leaves more than usual around it: a pair that explains so much is taken before it
/// is known whether it can be told apart, as the noise that this is judged by holds what it left.
constexpr double max_of_misfit = 0.5, convincing_ratio = 4;
/// Periods that a mode needs to be one.
constexpr double min_quality = 2;
constexpr std::size_t together = 5;
constexpr int max_steps = 20;
/// Values of a band, steps of its window (as take_band has it), and sinusoids in it at most.
constexpr std::size_t band_values = 48, band_window = 8, max_orders = 12;

/// Bins for one radian per sample.
double scale_of(const ToneFit& fit) {
  return static_cast<double>(fit.grid->count()) / (2 * std::numbers::pi);
}

/// A beat that begins faint looks like a tone that grows, until it is found to be two.
bool is_mode_like(const ToneFit& fit, const Tone& tone) {
  const double growth = 3 / static_cast<double>(fit.grid->count());
  const double bin = tone.rate.imag() * scale_of(fit);
  return tone.rate.real() < growth && bin >= static_cast<double>(fit.band.first) &&
         bin <= static_cast<double>(fit.band.last) && -tone.rate.real() < 0.66 * fit.fastest &&
         -tone.rate.real() * min_quality < tone.rate.imag();
}

/// @param convincing  gain at which tones need not be told apart for now
bool acceptable(const ToneFit& fit, const Proposal& proposal, double threshold,
                double convincing = std::numeric_limits<double>::infinity()) {
  if (!(proposal.gain > threshold)) return false;
  const std::size_t count = fit.grid->count();
  const double bin = 1 / scale_of(fit);
  for (std::size_t t = 0; t < proposal.tones.size(); ++t) {
    const Tone& tone = proposal.tones[t];
    if (!is_mode_like(fit, tone)) return false;
    if (proposal.separation[t] < min_separation && proposal.gain < convincing) return false;
    for (const Tone& other : proposal.tones) {
      const double apart = std::abs(other.rate.imag() - tone.rate.imag());
      const double line = bin + std::abs(other.rate.real()) + std::abs(tone.rate.real());
      const double minimum = apart < line ? min_fraction : min_fraction_beside;
      if (energy(tone, count) < minimum * energy(other, count)) return false;
    }
  }
  return true;
}

/// chi squared where a tone is strongest, and what would be usual there: noise, or what lies beside
/// it. Skirts of tones that are not known yet are as high there.
struct Misfit {
  double own = 0;
  double usual = 0;
};
Misfit misfit_of(const ToneFit& fit, const Complex rate) {
  const double half = 4 + 1.5 * std::abs(rate.real()) * scale_of(fit);
  const double centre = rate.imag() * scale_of(fit);
  double own = 0, own_bins = 0, beside = 0, beside_bins = 0;
  const auto first = static_cast<std::size_t>(std::max(1.0, centre - 3 * half));
  const auto last = std::min(fit.residual.size(), static_cast<std::size_t>(centre + 3 * half) + 1);
  for (std::size_t bin = first; bin < last; ++bin) {
    const double chi = 2 * std::norm(fit.residual[bin]) / fit.noise[bin];
    const bool inside = std::abs(static_cast<double>(bin) - centre) < half;
    (inside ? own : beside) += chi;
    (inside ? own_bins : beside_bins) += 1;
  }
  const double mean = std::max(2.0, beside / std::max(1.0, beside_bins));
  // The deviation of chi squared is twice the root of half its mean.
  return {own, mean * (own_bins + 2 * std::sqrt(own_bins))};
}

/// Samples that a band around a tone is made of: six times its decay, or all there are.
std::size_t band_samples(Complex rate, std::size_t count) {
  const double span = std::min(static_cast<double>(count), -6 / std::min(rate.real(), -1e-12));
  constexpr std::size_t parts = band_values + band_window;
  const auto step = std::max<std::size_t>(2, static_cast<std::size_t>(span) / parts);
  return std::min(count, step * parts);
}

/// Rates of two tones that one may be.
std::vector<std::array<Complex, 2>> pairs_for(const ToneFit& fit, std::span<const double> signal,
                                              const Complex rate) {
  const double slowest = 1 / static_cast<double>(fit.grid->count());
  const double width = std::max(2 * std::numbers::pi * slowest, std::abs(rate.real()));
  std::vector<std::array<Complex, 2>> pairs;
  std::vector<Complex> near;
  for (const Complex found :
       rates_around(fit, signal, {std::min(rate.real(), -slowest), rate.imag()})) {
    if (std::abs(found.imag() - rate.imag()) < 4 * width && near.size() < 2) near.push_back(found);
  }
  if (near.size() == 2) pairs.push_back({near[0], near[1]});
  for (const double apart : {0.07, 0.2, 0.6}) {
    const Complex step(0, apart * width);
    pairs.push_back({rate - step, rate + step});
  }
  pairs.push_back({Complex(0.5 * rate.real(), rate.imag()), Complex(2 * rate.real(), rate.imag())});
  return pairs;
}

bool in_line(const ToneFit& fit, const Tone& tone, Complex rate) {
  return std::abs(tone.rate.imag() - rate.imag()) <
         std::max(1 / scale_of(fit), 0.7 * std::abs(tone.rate.real()));
}

/// By how much chi squared would rise without a tone, the others held.
double loss_of(const ToneFit& fit, std::size_t tone) {
  const BinRange range = reach_of(fit, fit.tones[tone].rate);
  std::vector<Complex> own(range.size());
  fit.grid->add_part(fit.tones[tone], 1, range, own);
  double sum = 0;
  for (std::size_t i = 0; i < own.size(); ++i) {
    sum += 2 * std::norm(own[i]) / fit.noise[range.first + i];
  }
  return sum;
}

/// What a tone has explained that is gone its neighbours explain as far as they can: left to be
/// refined later, it would count as noise until then.
void refine_near(ToneFit& fit, Complex rate) {
  const auto near = neighbours(fit, rate, together - 1);
  if (near.empty()) return;
  std::vector<Tone> tones;
  for (const std::size_t k : near) tones.push_back(fit.tones[k]);
  const Proposal proposal = propose(fit, near, tones, max_steps, Fineness::all_bins);
  if (proposal.gain > 0) commit(fit, proposal);
}

/// More than usual, and new since it was last tried as two.
bool leaves_more(const ToneFit& fit, std::size_t tone) {
  const Misfit misfit = misfit_of(fit, fit.tones[tone].rate);
  const double tried = fit.tones[tone].tried;
  return misfit.own > misfit.usual && !(misfit.own > 0.8 * tried && misfit.own < 1.25 * tried);
}

}  // namespace

bool beside_tone(const ToneFit& fit, Complex rate) {
  return std::any_of(fit.tones.begin(), fit.tones.end(),
                     [&](const Tone& tone) { return in_line(fit, tone, rate); });
}

std::vector<Complex> rates_around(const ToneFit& fit, std::span<const double> signal,
                                  Complex rate) {
  const std::size_t step = band_samples(rate, signal.size()) / (band_values + band_window);
  if (step == 0) return {};
  const Band band = take_band(signal, rate.imag(), step, band_values);
  const auto bin = static_cast<std::size_t>(rate.imag() * scale_of(fit));
  const double power =
      fit.noise[std::min(fit.noise.size() - 1, bin)] / static_cast<double>(fit.grid->count());
  // Mean square of the window: 0.258 of its length.
  const double noise = std::sqrt(power * 0.258 * static_cast<double>(band_window * step));
  return esprit_rates(band, noise, max_orders);
}

bool try_tone(ToneFit& fit, Complex rate, double threshold) {
  const ToneGain gain = gain_of(fit, {&rate, 1});
  // A start that is a little off shows less than the tone has.
  if (gain.gain < 0.4 * threshold) return false;
  const auto block = neighbours(fit, rate, together - 1);
  std::vector<Tone> tones;
  for (const std::size_t k : block) tones.push_back(fit.tones[k]);
  tones.push_back({gain.amplitudes[0], rate});
  const Proposal proposal = propose(fit, block, tones, max_steps, Fineness::few_bins);
  if (!acceptable(fit, proposal, threshold)) return false;
  commit(fit, proposal);
  return true;
}

bool misfits(ToneFit& fit, std::size_t tone) {
  if (!leaves_more(fit, tone)) return false;
  // Not where it fits best yet, it leaves more than it has to.
  refine_near(fit, fit.tones[tone].rate);
  return leaves_more(fit, tone);
}

bool try_pair(ToneFit& fit, std::size_t index, std::span<const double> residual) {
  const Tone tone = fit.tones[index];
  const auto near = neighbours(fit, tone.rate, together - 1);
  const std::size_t heard = band_samples(tone.rate, residual.size());
  std::vector<double> signal(residual.begin(),
                             residual.begin() + static_cast<std::ptrdiff_t>(heard));
  std::vector<std::size_t> replaced = {index};
  for (const std::size_t k : near) {
    add_tone(signal, fit.tones[k], 1);
    if (k != index) replaced.push_back(k);
  }
  const auto pairs = pairs_for(fit, signal, tone.rate);
  // A pair that was parted while the noise was not known may have been parted wrongly.
  for (std::size_t k = 1; k < replaced.size(); ++k) {
    if (!in_line(fit, fit.tones[replaced[k]], tone.rate)) continue;
    std::swap(replaced[1], replaced[k]);
    const ToneGain both = gain_of(fit, pairs.front(), {replaced.data(), 2});
    std::vector<Tone> tones = {{both.amplitudes[0], pairs.front()[0]},
                               {both.amplitudes[1], pairs.front()[1]}};
    for (std::size_t other = 2; other < replaced.size(); ++other) {
      tones.push_back(fit.tones[replaced[other]]);
    }
    const Proposal proposal = propose(fit, replaced, tones, max_steps, Fineness::all_bins);
    if (!acceptable(fit, proposal, parted_anew)) continue;
    commit(fit, proposal);
    return true;
  }
  // Two are a pair; a third is believed less easily.
  double threshold = second_of_pair;
  for (const std::size_t k : replaced) {
    if (k == index || !in_line(fit, fit.tones[k], tone.rate)) continue;
    threshold = std::max(threshold, third_fraction * (loss_of(fit, index) + loss_of(fit, k)));
  }
  const Misfit misfit = misfit_of(fit, tone.rate);
  const double convincing =
      std::max(max_of_misfit * (misfit.own - misfit.usual), convincing_ratio * threshold);
  std::optional<Proposal> best;
  for (const auto& rates : pairs) {
    const ToneGain both = gain_of(fit, rates, {&index, 1});
    std::vector<Tone> tones = {{both.amplitudes[0], rates[0]}};
    for (std::size_t k = 1; k < replaced.size(); ++k) tones.push_back(fit.tones[replaced[k]]);
    tones.push_back({both.amplitudes[1], rates[1]});
    Proposal proposal = propose(fit, replaced, tones, max_steps, Fineness::all_bins);
    if (!acceptable(fit, proposal, best ? best->gain : threshold, convincing)) continue;
    best = std::move(proposal);
  }
  if (!best) {
    fit.tones[index].tried = misfit.own;
    return false;
  }
  // Should one be pruned, the other is not tried again.
  best->tones.front().tried = best->tones.back().tried = misfit.own;
  commit(fit, *best);
  return true;
}

bool prune(ToneFit& fit) {
  bool any = false;
  for (std::size_t k = fit.tones.size(); k-- > 0;) {
    // What still grows and is no pair either is no mode.
    const bool grows = fit.tones[k].rate.real() * static_cast<double>(fit.grid->count()) > 0.5 &&
                       fit.tones[k].tried > 0;
    const bool fine = !grows && is_mode_like(fit, fit.tones[k]) && loss_of(fit, k) > new_tone &&
                      errors_of(fit, k).separation > min_separation;
    if (fine) continue;
    const Complex rate = fit.tones[k].rate;
    remove_tone(fit, k);
    refine_near(fit, rate);
    any = true;
  }
  return any;
}

}  // namespace carillon::eval::features
