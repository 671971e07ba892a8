#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.hpp"
#include "core/numbers.hpp"
#include "eval/material/pitch_estimate.hpp"
#include "eval/material/relative_fit.hpp"
#include "eval/recorded_objects/impact_study.hpp"

namespace carillon::eval::recorded_objects {

namespace {

/// Between moduli of one strike and of all: ten times what a good recording scatters.
constexpr double disagrees = 0.02;
/// Twice and six times what a single recording of a known level is fitted with (hybrid_metric.hpp).
constexpr double level_scale = 20, min_difference = 0.3;
/// A fit has so many times the pairs of chance within a quarter of the widest distance.
constexpr double beyond_chance = 1.5, near_limit = 0.25;
/// Log-likelihood by which 95 % of estimates are better than the truth, and a single recording's
/// from which it says something by itself.
constexpr double within_interval = 1.92, min_evidence = 3;

std::vector<features::FeatureSet> sets_of(const std::vector<StudiedStrike>& strikes) {
  std::vector<features::FeatureSet> sets;
  for (const StudiedStrike& strike : strikes) sets.push_back(strike.set);
  return sets;
}

/// Pitches of the object as given, heard as loudly as these strikes and microphones have them.
material::ModePitches struck_pitches(const HeardObject& given,
                                     const std::vector<ModelStrike>& model, double poisson_ratio) {
  material::ModePitches pitches =
      material::mode_pitches(given.modes, given.specific_modulus, poisson_ratio, std::nullopt);
  Eigen::MatrixXd amplitudes(static_cast<Eigen::Index>(given.modes.size()),
                             static_cast<Eigen::Index>(model.size()));
  for (std::size_t i = 0; i < model.size(); ++i) {
    const Eigen::VectorXd struck =
        (synth::modal::shapes_at(given.modes, model[i].point) * model[i].direction).cwiseAbs();
    const auto row = static_cast<Eigen::Index>(i);
    Eigen::VectorXd heard = struck;
    if (given.pressure) heard = given.pressure->pressure.row(row).transpose().cwiseAbs();
    amplitudes.col(row) = struck.cwiseProduct(heard);
  }
  pitches.weights = material::audibility(pitches.frequencies, amplitudes);
  return pitches;
}

/// What is known before of the specific modulus and of the band that is heard.
material::PitchPrior prior_of(const HeardObject& given, const StudyOptions& options) {
  return {.min_modulus = given.specific_modulus / options.modulus_range,
          .max_modulus = given.specific_modulus * options.modulus_range,
          .min_frequency = options.min_frequency,
          .max_frequency = options.max_frequency};
}

void fit_by_pitches(StudyFit& fit, const std::vector<StudiedStrike>& strikes,
                    const material::PitchEstimate& estimate, const material::ModePitches& pitches,
                    const material::PitchPrior& prior) {
  fit.specific_modulus = estimate.specific_modulus;
  fit.undetermined = estimate.undetermined;
  if (estimate.specific_modulus) fit.modulus95 = estimate.modulus95;
  for (const StudiedStrike& strike : strikes) {
    const material::PitchPosterior one = material::pitch_posterior(
        material::heard_tones(std::span(&strike.set, 1)), std::span(&pitches, 1), prior);
    const bool speaks = one.log_evidence > min_evidence;
    fit.alone.push_back(speaks ? std::optional(one.modulus) : std::nullopt);
  }
}

/// The contact time of all strikes, of which the joint estimate knows one [s]; says where they
/// differ.
double common_contact(const std::vector<ModelStrike>& model, StudyFit& fit) {
  constexpr double same = 1.25;
  std::vector<double> times;
  for (const ModelStrike& strike : model) times.push_back(strike.contact_time);
  const auto [shortest, longest] = std::minmax_element(times.begin(), times.end());
  const double middle = core::median(times);
  if (*longest > same * *shortest) {
    fit.remarks.push_back(
        fmt::format("contact times are from {:.3g} to {:.3g} ms: the hybrid metric takes {:.3g} ms "
                    "for all",
                    1e3 * *shortest, 1e3 * *longest, 1e3 * middle));
  }
  return middle;
}

void fit_by_sound(StudyFit& fit, const std::vector<StudiedStrike>& strikes,
                  const std::vector<ModelStrike>& model, const HeardObject& given,
                  const StudyOptions& options, const std::filesystem::path& cache) {
  material::MaterialOptions how;
  how.law = options.law;
  how.motion = material::HeardMotion::acceleration;
  how.contact_time = common_contact(model, fit);
  how.starts.min_modulus = given.specific_modulus / options.modulus_range;
  how.starts.max_modulus = given.specific_modulus * options.modulus_range;
  // Microphones, the mesh and a strike that is not quite straight change levels: they count for
  // less.
  how.metric.match.level = level_scale;
  how.metric.min_difference = min_difference;
  HeardObject heard = given;
  // What is radiated depends on the modulus that is sought: the second round knows it.
  for (int round = 0; round < 2; ++round) {
    std::vector<material::StruckRecording> recordings;
    for (std::size_t i = 0; i < strikes.size(); ++i) {
      recordings.push_back({strikes[i].samples, &strikes[i].set, struck_by(heard, model, i)});
    }
    fit.joint = material::estimate_jointly(recordings, how);
    const double found = fit.joint->candidate.specific_modulus;
    if (std::abs(std::log(found / heard.specific_modulus)) < 0.01 || !options.radiation) break;
    if (round == 0) {
      heard = hear_object(given.modes, given.specific_modulus, found, model, true, cache);
    }
  }
  fit.specific_modulus = fit.joint->candidate.specific_modulus;
  fit.remarks.insert(fit.remarks.end(), fit.joint->remarks.begin(), fit.joint->remarks.end());
  for (const auto& one : fit.joint->alone) {
    fit.alone.push_back(one ? std::optional(one->candidate.specific_modulus) : std::nullopt);
  }
}

/// What pitches alone have against a modulus that was found by the sound.
void remark_on_pitches(const material::PitchEstimate& estimate, StudyFit& fit) {
  if (!estimate.specific_modulus) {
    fit.remarks.push_back("by pitches alone the modulus is not determined: " +
                          estimate.undetermined);
  } else if (std::abs(std::log(*estimate.specific_modulus / *fit.specific_modulus)) > disagrees) {
    fit.remarks.push_back(fmt::format(
        "by pitches alone the specific modulus is {:.5g} m^2/s^2 (95 %: {:.5g} to {:.5g})",
        *estimate.specific_modulus, estimate.modulus95.low, estimate.modulus95.high));
  }
}

/// Takes back a modulus that the recorded pitches speak against more than against the one given.
void judge_modulus(StudyFit& fit, const std::vector<StudiedStrike>& strikes,
                   const material::ModePitches& pitches, const material::PitchPrior& prior) {
  const std::vector<material::HeardTone> tones = material::heard_tones(sets_of(strikes));
  fit.log_likelihood_given =
      material::best_log_likelihood(tones, pitches, pitches.specific_modulus, prior);
  if (!fit.specific_modulus) return;
  fit.log_likelihood = material::best_log_likelihood(tones, pitches, *fit.specific_modulus, prior);
  if (fit.log_likelihood >= fit.log_likelihood_given - within_interval) return;
  fit.undetermined = fmt::format(
      "the best fit, {:.4g} times the specific modulus given, explains the recorded pitches worse "
      "than the material as given does (log-likelihood {:.1f} against {:.1f})",
      *fit.specific_modulus / pitches.specific_modulus, fit.log_likelihood,
      fit.log_likelihood_given);
  fit.specific_modulus.reset();
  fit.modulus95.reset();
}

/// Decay rate by radiation of the mode nearest to a frequency [1/s].
double radiated_near(const HeardObject& object, double frequency) {
  if (object.radiated.empty()) return 0;
  std::size_t nearest = 0;
  for (std::size_t i = 1; i < object.modes.size(); ++i) {
    if (std::abs(object.modes.frequency(i) - frequency) <
        std::abs(object.modes.frequency(nearest) - frequency)) {
      nearest = i;
    }
  }
  return object.radiated[nearest];
}

/// Damping of the material at the recorded modes that have a partner.
/// @param radiating  gets how many decay no faster than the model radiates
damping::DampingData matched_damping(const std::vector<StudiedStrike>& strikes,
                                     const HeardObject& object,
                                     const recorded::RecordedComparison& comparison,
                                     std::size_t& radiating) {
  std::vector<features::Feature> matched;
  std::vector<double> radiated;
  for (std::size_t i = 0; i < strikes.size(); ++i) {
    for (const perception::MatchedMode& pair : comparison.strikes[i].matched) {
      const features::Feature& mode = strikes[i].set.features[pair.reference];
      const features::Feature& partner = comparison.synthetic[i][pair.other];
      const double rate = radiated_near(object, partner.frequency);
      if (mode.reverberant || !(mode.decay_rate > rate)) {
        ++radiating;
        continue;
      }
      matched.push_back(mode);
      radiated.push_back(rate);
    }
  }
  damping::DampingData data = damping::damping_data(matched);
  for (std::size_t i = 0; i < data.size(); ++i) data.coefficients[i] -= 2 * radiated[i];
  return data;
}

/// Mean distance of the damping of matched modes from a model's, as a factor's logarithm.
double distance_of(const damping::DampingData& data, const synth::damping::DampingModel& model) {
  const std::vector<double> values = synth::damping::damping_coefficients(model, data.eigenvalues);
  double sum = 0;
  for (std::size_t i = 0; i < data.size(); ++i) {
    if (!(values[i] > 0)) return std::numeric_limits<double>::infinity();
    sum += std::abs(std::log(values[i] / data.coefficients[i]));
  }
  return sum / static_cast<double>(std::max<std::size_t>(data.size(), 1));
}

/// Damping from the matched modes, where they determine one that is nearer to them than the one
/// given; else it stays as it is.
void fit_matched_damping(StudyFit& fit, const damping::DampingData& data,
                         const synth::damping::DampingModel& given, const StudyOptions& options) {
  const auto stays = [&](const std::string& why) {
    fit.remarks.push_back(fmt::format("damping is as {}: {}",
                                      fit.joint ? "the joint estimate has it" : "given", why));
  };
  if (data.size() <= options.law.parameters) {
    stays(fmt::format("{} matched mode{} for {} parameters", data.size(),
                      data.size() == 1 ? "" : "s", options.law.parameters));
    return;
  }
  try {
    const damping::DampingFit law =
        options.estimator
            ? damping::fit_damping(data, options.law, {.estimator = *options.estimator})
            : material::fit_matched(data, options.law);
    fit.remarks.insert(fit.remarks.end(), law.remarks.begin(), law.remarks.end());
    const double found = distance_of(data, law.model), before = distance_of(data, given);
    if (found > before) {
      fit.damping = given;
      fit.remarks.push_back(fmt::format(
          "damping is as given: the law fitted to {} matched modes is a factor of {:.2f} off them "
          "in the mean, the one given {:.2f}",
          data.size(), std::exp(found), std::exp(before)));
      return;
    }
    fit.damping = law.model;
    fit.points = data.size();
    fit.confidence95 = law.confidence95;
    if (!options.radiation) {
      fit.remarks.emplace_back(
          "without radiation (--radiation off) the damping holds what the "
          "object radiates, too");
    }
  } catch (const core::InputError& error) {
    stays(error.message());
  }
}

/// What a user should know of the modulus that was found.
void remark_on_modulus(const std::vector<StudiedStrike>& strikes, const HeardObject& fitted,
                       StudyFit& fit) {
  for (std::size_t i = 0; i < strikes.size(); ++i) {
    if (!fit.alone[i]) continue;
    const double ratio = *fit.alone[i] / *fit.specific_modulus;
    if (std::abs(std::log(ratio)) < disagrees) continue;
    fit.remarks.push_back(
        fmt::format("vertex {} alone would have a specific modulus {:.3f} times that of all",
                    strikes[i].recorded.vertex, ratio));
  }
  const double known = fitted.modes.certificate.complete_to_hz;
  std::size_t above = 0;
  for (const StudiedStrike& strike : strikes) {
    for (const features::Feature& mode : strike.set.features)
      above += mode.frequency > known ? 1U : 0U;
  }
  if (above > 0) {
    fit.remarks.push_back(
        fmt::format("modes of the fitted material are known up to {:.0f} Hz, and {} recorded "
                    "mode{} above: raise --max-frequency",
                    known, above, above == 1 ? " lies" : "s lie"));
  }
}

/// Whether chance would have matched as many modes as closely.
void remark_on_chance(const std::vector<StudiedStrike>& strikes,
                      const recorded::RecordedComparison& comparison, double widest,
                      StudyFit& fit) {
  const auto frequencies = [](const std::vector<features::Feature>& tones) {
    std::vector<double> all;
    for (const features::Feature& tone : tones) all.push_back(tone.frequency);
    return all;
  };
  std::size_t near = 0;
  double chance = 0;
  for (std::size_t i = 0; i < strikes.size(); ++i) {
    for (const perception::MatchedMode& pair : comparison.strikes[i].matched) {
      near += std::abs(pair.cents) <= near_limit * widest ? 1U : 0U;
    }
    chance += recorded::pairs_by_chance(frequencies(comparison.synthetic[i]),
                                        frequencies(strikes[i].set.features), near_limit * widest);
  }
  if (static_cast<double>(near) >= beyond_chance * chance) return;
  fit.remarks.push_back(
      fmt::format("the fit is not to be trusted: {} modes match within {:.3g} cents, and chance "
                  "makes {:.1f} such pairs",
                  near, near_limit * widest, chance));
}

}  // namespace

StudyFit fit_material(const std::vector<StudiedStrike>& strikes,
                      const std::vector<ModelStrike>& model, const HeardObject& given,
                      const synth::material::Material& material, std::optional<HeardObject>& fitted,
                      const StudyOptions& options, const std::filesystem::path& cache) {
  const material::ModePitches pitches =
      struck_pitches(given, model, material.elastic.poisson_ratio);
  const material::PitchPrior prior = prior_of(given, options);
  const material::PitchEstimate estimate = material::estimate_from_pitches(
      sets_of(strikes), std::span(&pitches, 1), options.law, {}, prior);
  StudyFit fit;
  if (options.metric == StudyMetric::pitches) {
    fit_by_pitches(fit, strikes, estimate, pitches, prior);
  } else {
    fit_by_sound(fit, strikes, model, given, options, cache);
    remark_on_pitches(estimate, fit);
  }
  judge_modulus(fit, strikes, pitches, prior);
  if (!fit.specific_modulus) return fit;

  fitted = hear_object(given.modes, given.specific_modulus, *fit.specific_modulus, model,
                       options.radiation, cache);
  remark_on_modulus(strikes, *fitted, fit);
  const std::vector<double> ones(strikes.size(), 1.0);
  const ModelVariant matched =
      make_variant("", strikes, model, *fitted, material.damping, ones, options);
  remark_on_chance(strikes, matched.modes, options.widest, fit);
  std::size_t radiating = 0;
  const damping::DampingData data = matched_damping(strikes, *fitted, matched.modes, radiating);
  if (radiating > 0) {
    fit.remarks.push_back(fmt::format(
        "{} matched mode{} no faster than the model radiates: left out of the damping's fit",
        radiating, radiating == 1 ? " decays" : "s decay"));
  }
  fit.damping = fit.joint ? fit.joint->candidate.damping : material.damping;
  fit_matched_damping(fit, data, material.damping, options);
  return fit;
}

}  // namespace carillon::eval::recorded_objects
