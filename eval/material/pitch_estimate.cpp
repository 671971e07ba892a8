#include "eval/material/pitch_estimate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "eval/material/relative_fit.hpp"
#include "eval/material/room_fit.hpp"
#include "eval/material/room_sound.hpp"

namespace carillon::eval::material {

namespace {

constexpr double min_evidence = 3;
constexpr double max_chance = 0.01;
constexpr std::size_t min_matches = 3;
/// Candidates whose logarithms are further apart with nothing between them are rivals.
constexpr double gap = 0.02;
constexpr double one_place = 0.95;
/// Logarithm of the interval's ends: wider is no answer.
constexpr double widest = 0.4;
/// Points beside a law's parameters that must be more than a room's: as many as it has parameters
/// can be made a law's whatever they are.
constexpr double points_beside_room = 1;

/// Share of the posterior in the place around its median, places being parted by gaps.
double share_in_one_place(const PitchPosterior& posterior) {
  double best = 0;
  double sum = 0;
  for (std::size_t i = 0; i < posterior.log_moduli.size(); ++i) {
    if (i > 0 && posterior.log_moduli[i] - posterior.log_moduli[i - 1] > gap) sum = 0;
    sum += posterior.probabilities[i];
    best = std::max(best, sum);
  }
  return best;
}

/// Why a posterior is no answer; "" where it is one.
std::string fault_of(const PitchEstimate& estimate, const PitchPosterior& posterior,
                     std::size_t matched) {
  if (estimate.tones < min_matches) {
    return fmt::format("{} tone{} in the sound: the pitches of three modes at the least are needed",
                       estimate.tones, estimate.tones == 1 ? " is" : "s are");
  }
  if (!(estimate.log_evidence > min_evidence) || !(estimate.chance < max_chance)) {
    return "the tones match the modes of this object no better than chance would: is it this "
           "object, and is its mesh true to shape?";
  }
  if (matched < min_matches) {
    return fmt::format("{} tone{} a mode's: three at the least are needed", matched,
                       matched == 1 ? " is" : "s are");
  }
  if (share_in_one_place(posterior) < one_place ||
      std::log(posterior.confidence95.high / posterior.confidence95.low) > widest) {
    return "several specific moduli far apart match the tones as well as each other: more modes "
           "have to be heard, by another strike or microphone";
  }
  return "";
}

core::Range poisson_interval(const PitchPosterior& posterior) {
  const std::vector<double>& ratios = posterior.poisson_ratios;
  // A ratio stands for all around it.
  const double half = 0.5 * (ratios[1] - ratios[0]);
  core::Range range{ratios.front(), ratios.back()};
  double sum = 0;
  for (std::size_t i = 0; i < ratios.size() && sum < 0.975; ++i) {
    if (sum < 0.025) range.low = std::max(ratios.front(), ratios[i] - half);
    sum += posterior.poisson_probabilities[i];
    range.high = std::min(ratios.back(), ratios[i] + half);
  }
  return range;
}

/// Of points that were heard in a room; says where too few of them are not the room's.
void fit_law_in_room(PitchEstimate& estimate, const DampingPoints& points,
                     const damping::DampingLaw& law) {
  const RoomFit found = fit_in_room(points.data, points.rooms, law);
  const auto parameters = static_cast<double>(found.model.parameters.size());
  if (found.own < parameters + points_beside_room) {
    estimate.remarks.push_back(fmt::format(
        "damping is not determined: {:.1f} of {} matched tones decay otherwise than the room does, "
        "for {} parameters (--rt60 0: there is no room)",
        found.own, points.data.size(), law.parameters));
    return;
  }
  estimate.damping = FittedLaw{found.model, found.confidence95};
  estimate.remarks.push_back(
      fmt::format("a room of RT60 about {:.2g} s is heard: {:.1f} of {} matched tones decay "
                  "otherwise than it does (--rt60 gives the room's, 0: none)",
                  *points.rt60, found.own, points.data.size()));
}

void fit_law(PitchEstimate& estimate, const DampingPoints& points, const damping::DampingLaw& law) {
  const damping::DampingData& data = points.data;
  if (data.size() <= law.parameters) {
    estimate.remarks.push_back(
        fmt::format("damping is not determined: {} matched tone{} for {} parameters", data.size(),
                    data.size() == 1 ? "" : "s", law.parameters));
    return;
  }
  try {
    if (points.rt60) {
      fit_law_in_room(estimate, points, law);
    } else {
      const damping::DampingFit fit = fit_matched(data, law);
      estimate.damping = FittedLaw{fit.model, fit.confidence95};
    }
  } catch (const core::InputError& error) {
    estimate.remarks.push_back("damping is not determined: " + error.message());
  }
}

void remark(PitchEstimate& estimate, std::span<const HeardTone> tones,
            std::span<const ModePitches> modes, const PitchPosterior& posterior) {
  const double known = modes.front().complete_to_hz *
                       std::sqrt(posterior.best_modulus / modes.front().specific_modulus);
  const auto above = std::count_if(tones.begin(), tones.end(), [&](const HeardTone& tone) {
    return tone.log_frequency > std::log(known);
  });
  if (above > 0) {
    estimate.remarks.push_back(
        fmt::format("modes of this material are known up to {:.0f} Hz and {} tone{} above: assume "
                    "a material nearer to it, or raise --max-frequency",
                    known, above, above == 1 ? " lies" : "s lie"));
  }
  if (estimate.damping) {
    for (std::size_t k = 0; k < estimate.damping->confidence95.size(); ++k) {
      const core::Range& range = estimate.damping->confidence95[k];
      if (std::isfinite(range.low) && std::isfinite(range.high)) continue;
      estimate.remarks.push_back(
          fmt::format("{} is not bounded by what was heard", synth::damping::parameter_name(k)));
    }
  }
  estimate.remarks.emplace_back(
      "the specific modulus takes in the object's size: an object 1 % larger than its mesh comes "
      "out 2 % lower");
}

}  // namespace

PitchEstimate estimate_from_pitches(std::span<const features::FeatureSet> recordings,
                                    std::span<const ModePitches> modes,
                                    const damping::DampingLaw& law, std::span<const double> rt60,
                                    const PitchPrior& prior) {
  const std::vector<HeardTone> tones = heard_tones(recordings);
  PitchEstimate estimate;
  estimate.tones = tones.size();
  const PitchPosterior posterior = pitch_posterior(tones, modes, prior);
  estimate.log_evidence = posterior.log_evidence;
  if (estimate.tones >= min_matches && estimate.log_evidence > min_evidence) {
    estimate.chance = chance_of_match(tones, modes, posterior.best, prior);
  }
  const std::vector<ToneMatch> matches = match_tones(tones, modes, posterior, prior);
  estimate.undetermined = fault_of(estimate, posterior, matches.size());
  if (!estimate.undetermined.empty()) return estimate;

  estimate.specific_modulus = posterior.modulus;
  estimate.modulus95 = posterior.confidence95;
  const auto scale = [&](double modulus) {
    return std::sqrt(modulus / modes.front().specific_modulus);
  };
  estimate.frequency_scale = scale(posterior.modulus);
  estimate.scale95 = {scale(posterior.confidence95.low), scale(posterior.confidence95.high)};
  estimate.scatter_cents = posterior.best.scatter;
  estimate.sharpness = posterior.best.sharpness;
  if (modes.size() > 1) {
    estimate.poisson_ratio = posterior.best.poisson_ratio;
    estimate.poisson95 = poisson_interval(posterior);
  }
  const double ratio = scale(posterior.best_modulus);
  std::vector<std::vector<FeatureIndex>> heads;
  for (const ToneMatch& match : matches) {
    const std::vector<FeatureIndex>& own = tones[match.tone].heads;
    heads.push_back(own);
    const FeatureIndex& loudest = own.front();
    estimate.matches.push_back({recordings[loudest.recording].features[loudest.feature],
                                ratio * match.mode_frequency, match.probability});
  }
  const DampingPoints points = damping_points(recordings, heads, rt60);
  estimate.room_rt60 = points.rt60;
  fit_law(estimate, points, law);
  remark(estimate, tones, modes, posterior);
  return estimate;
}

}  // namespace carillon::eval::material
