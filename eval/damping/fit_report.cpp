#include "eval/damping/fit_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/error.hpp"
#include "core/json.hpp"
#include "core/numbers.hpp"
#include "core/trace.hpp"
#include "eval/damping/detail/information.hpp"
#include "eval/damping/detail/remarks.hpp"
#include "eval/damping/fitted_alphas.hpp"
#include "eval/damping/law_text.hpp"

namespace carillon::eval::damping {

namespace {

using nlohmann::json;

json to_json(const DampingFit& fit) {
  json document = {{"estimator", name_of(fit.estimator)},
                   {"parameters", alphas_json(fit.model, fit.confidence95)},
                   {"formula", synth::damping::formula_of(fit.model)},
                   {is_in_proportion(fit.estimator) ? "sigma_of_c" : "sigma_per_s", fit.sigma},
                   {"eta_s", core::number_or_null(fit.eta)},
                   {"log_likelihood", core::number_or_null(fit.log_likelihood)},
                   {"aic", core::number_or_null(akaike(fit))},
                   {"bic", core::number_or_null(bayesian(fit))},
                   {"points", fit.points},
                   {"iterations", fit.iterations},
                   {"converged", fit.converged},
                   {"remarks", fit.remarks}};
  if (fit.estimator != Estimator::mixture) return document;
  document["excess"] = json::array();
  for (const ExcessPart& part : fit.excess) {
    document["excess"].push_back({{"share", part.share}, {"mean_per_s", part.mean}});
  }
  document["outliers"] = fit.outliers;
  return document;
}

/// The law between two frequencies of its data, for pictures.
json curve_of(const DampingFit& fit, double low, double high) {
  constexpr int points = 200;
  const auto c = synth::damping::damping_function(fit.model);
  json frequencies = json::array();
  json rates = json::array();
  for (int i = 0; i < points; ++i) {
    const double f = low * std::pow(high / low, i / (points - 1.0));
    frequencies.push_back(f);
    rates.push_back(core::number_or_null(c(std::pow(2 * std::numbers::pi * f, 2)) / 2));
  }
  return {{"frequency_hz", frequencies}, {"decay_rate_per_s", rates}};
}

/// The least and the greatest frequency of all features.
std::pair<double, double> band_of(const std::vector<FitSource>& sources) {
  double low = std::numeric_limits<double>::infinity(), high = 0;
  for (const features::Feature& feature : joined_features(sources)) {
    low = std::min(low, feature.frequency);
    high = std::max(high, feature.frequency);
  }
  return {low, high};
}

json to_json(const FitSource& source) {
  json entry = {{"name", source.name}, {"features", source.features.size()}};
  if (!source.nothing.empty()) entry["nothing"] = source.nothing;
  if (!source.remarks.empty()) entry["remarks"] = source.remarks;
  return entry;
}

/// The formula with as many digits as a reader wants.
std::string short_formula(synth::damping::DampingModel model) {
  for (double& alpha : model.parameters) alpha = std::stod(fmt::format("{:.5g}", alpha));
  return synth::damping::formula_of(model);
}

void print_fit(const DampingFit& fit) {
  fmt::print("\n{}: {}\n", name_of(fit.estimator), short_formula(fit.model));
  for (std::size_t k = 0; k < fit.model.parameters.size(); ++k) {
    fmt::print("  {:<8} {:>12.5g} {:<16} {}\n", synth::damping::parameter_name(k),
               fit.model.parameters[k], synth::damping::parameter_unit(fit.model.kind, k),
               fit.confidence95.empty() ? "" : interval_text(fit.confidence95[k]));
  }
  if (fit.sigma > 0) {
    fmt::print("  {:<8} {:>12.5g} {}\n", "sigma", fit.sigma,
               is_in_proportion(fit.estimator) ? "of c" : "1/s");
  }
  for (const ExcessPart& part : fit.excess) {
    fmt::print("  excess   {:>12.5g} 1/s in the mean of {:.0f} % of the features\n", part.mean,
               100 * part.share);
  }
  if (std::isfinite(fit.eta) && fit.excess.empty()) {
    fmt::print("  {:<8} {:>12.5g} s{:16}mean excess {:.5g} 1/s\n", "eta", fit.eta, "", 1 / fit.eta);
  }
  const double aic = akaike(fit);
  fmt::print("  log-likelihood {:.2f}, {}, BIC {:.1f}, {} iterations\n", fit.log_likelihood,
             std::isfinite(aic) ? fmt::format("AIC {:.1f}", aic)
                                : fmt::format("too few features for an AIC ({} for {} numbers)",
                                              fit.points, fitted_numbers(fit)),
             bayesian(fit), fit.iterations);
  for (const std::string& remark : fit.remarks) fmt::print("  - {}\n", remark);
}

/// The laws by their AIC, lowest first.
void print_compared(std::vector<ComparedLaw> laws) {
  std::stable_sort(laws.begin(), laws.end(),
                   [](const auto& a, const auto& b) { return a.aic < b.aic; });
  for (const ComparedLaw& law : laws) {
    if (!law.nothing.empty()) {
      fmt::print("  {:<12} {}\n", law.named.name, law.nothing);
      continue;
    }
    fmt::print("  {:<12} {:<24} {}\n", law.named.name,
               std::isfinite(law.aic)
                   ? fmt::format("AIC {:.1f} ({:+.1f})", law.aic, law.aic - laws.front().aic)
                   : "too few features for an AIC",
               short_formula(law.fit.model));
    for (const std::string& remark : law.fit.remarks) fmt::print("    - {}\n", remark);
  }
}

}  // namespace

std::string useless_sources(const std::vector<FitSource>& sources) {
  std::string reasons;
  for (const FitSource& source : sources) {
    const bool room = std::all_of(source.features.begin(), source.features.end(),
                                  [](const features::Feature& f) { return f.reverberant; });
    if (room && !source.features.empty()) {
      reasons += fmt::format("\n  {}: all of its {} modes may be the room's (--rt60)", source.name,
                             source.features.size());
    }
    if (source.nothing.empty()) continue;
    // Some reasons begin with the file's name themselves.
    const bool named = source.nothing.starts_with(source.name);
    reasons +=
        named ? "\n  " + source.nothing : fmt::format("\n  {}: {}", source.name, source.nothing);
  }
  return reasons;
}

namespace {

/// All laws by one estimator; what cannot be fitted says why.
std::vector<ComparedLaw> compare_laws(const DampingData& data, std::span<const NamedLaw> laws,
                                      Estimator estimator) {
  std::vector<ComparedLaw> compared;
  for (const NamedLaw& named : laws) {
    ComparedLaw law{named, {}, core::infinity, ""};
    try {
      law.fit = fit_damping(data, named.law, {estimator, true, false});
      law.aic = akaike(law.fit);
    } catch (const core::Error& error) {
      law.nothing = error.message();
    }
    compared.push_back(std::move(law));
  }
  return compared;
}

/// The one of the lowest AIC that stays positive; of those without an AIC the first.
const ComparedLaw& chosen_of(const std::vector<ComparedLaw>& compared, const DampingData& data) {
  const ComparedLaw* chosen = nullptr;
  std::string reasons;
  for (const ComparedLaw& law : compared) {
    if (!law.nothing.empty()) {
      reasons += fmt::format("\n  {}: {}", law.named.name, law.nothing);
      continue;
    }
    if (negative_band(law.fit.model, data).is) continue;
    if (chosen == nullptr || law.aic < chosen->aic) chosen = &law;
  }
  if (chosen == nullptr) {
    throw core::InputError("none of the laws can be fitted and stays positive" + reasons,
                           "give more sounds, or --model rayleigh");
  }
  return *chosen;
}

}  // namespace

FitReport fit_sources(std::vector<FitSource> sources, std::span<const NamedLaw> laws,
                      std::span<const Estimator> estimators, bool with_history) {
  if (sources.empty()) {
    throw core::InputError("nothing to fit", "name recordings, or tables with --features FILE.csv");
  }
  FitReport report;
  report.sources = std::move(sources);
  const double begin = core::monotonic_seconds();
  const DampingData data = fitted_data(report.sources);
  if (data.size() == 0) {
    throw core::InputError("no usable feature" + useless_sources(report.sources));
  }
  report.law = laws.front().law;
  if (laws.size() > 1) {
    report.compared = compare_laws(data, laws, estimators.front());
    report.law = chosen_of(report.compared, data).named.law;
  }
  for (const Estimator estimator : estimators) {
    report.fits.push_back(fit_damping(data, report.law, {estimator, true, with_history}));
  }
  report.least_squares = fit_damping(data, report.law, {Estimator::least_squares, false, false});
  report.fit_seconds = core::monotonic_seconds() - begin;
  return report;
}

json to_json(const FitReport& report) {
  const DampingFit& first = report.fits.front();
  json document = to_json(first);
  document["model"] = synth::damping::form_of(report.law.kind).name;
  document["model_formula"] = formula_of(report.law);
  json units = json::object();
  for (std::size_t k = 0; k < first.model.parameters.size(); ++k) {
    units[synth::damping::parameter_name(k)] = synth::damping::parameter_unit(report.law.kind, k);
  }
  document["units"] = units;
  json fits = json::object();
  const auto [low, high] = band_of(report.sources);
  for (const DampingFit& fit : report.fits) {
    json entry = to_json(fit);
    entry["curve"] = curve_of(fit, low, high);
    fits[name_of(fit.estimator)] = entry;
  }
  document["fits"] = fits;
  for (const ComparedLaw& law : report.compared) {
    json entry = {{"name", law.named.name}, {"model_formula", formula_of(law.named.law)}};
    if (law.nothing.empty()) {
      entry.update(to_json(law.fit));
      entry["curve"] = curve_of(law.fit, low, high);
    } else {
      entry["nothing"] = law.nothing;
    }
    document["models"].push_back(entry);
  }
  const auto criteria = [](const DampingFit& fit) {
    return json{{"aic", core::number_or_null(akaike(fit))},
                {"bic", core::number_or_null(bayesian(fit))}};
  };
  document["information"] = {{"least_squares", criteria(report.least_squares)}};
  const DampingFit* lowest = &report.least_squares;
  for (const DampingFit& fit : report.fits) {
    if (!has_excess(fit.estimator)) continue;
    document["information"][name_of(fit.estimator)] = criteria(fit);
    if (akaike(fit) < akaike(*lowest)) lowest = &fit;
    document["information"]["lowest_aic"] = name_of(lowest->estimator);
  }
  document["sources"] = json::array();
  document["features"] = json::array();
  for (const FitSource& source : report.sources) {
    document["sources"].push_back(to_json(source));
    for (const features::Feature& feature : source.features) {
      document["features"].push_back(
          {{"frequency_hz", feature.frequency},
           {"decay_rate_per_s", feature.decay_rate},
           {"decay_rate_error_per_s", core::number_or_null(feature.decay_rate_error)},
           {"reverberant", feature.reverberant},
           {"source", document["sources"].size() - 1}});
    }
  }
  document["timing"] = {{"features_s", report.features_seconds}, {"fit_s", report.fit_seconds}};
  return document;
}

void print_report(const FitReport& report) {
  const auto [low, high] = band_of(report.sources);
  std::size_t features = 0, reverberant = 0;
  for (const FitSource& source : report.sources) {
    features += source.features.size();
    for (const features::Feature& feature : source.features)
      reverberant += feature.reverberant ? 1 : 0;
    for (const std::string& remark : source.remarks) fmt::print("{}: {}\n", source.name, remark);
  }
  fmt::print("{} features of {} file{}, {:.1f} to {:.1f} Hz", features, report.sources.size(),
             report.sources.size() == 1 ? "" : "s", low, high);
  if (reverberant > 0) fmt::print("; {} may be the room's and are left out", reverberant);
  fmt::print("\n{}, c = 2 d [1/s], lambda = omega^2 [rad^2/s^2]\n", formula_of(report.law));
  print_compared(report.compared);
  for (const DampingFit& fit : report.fits) print_fit(fit);
  fmt::print("\nfeatures {:.3f} s, fit {:.4f} s\n", report.features_seconds, report.fit_seconds);
}

std::string history_table(const std::vector<DampingFit>& fits) {
  std::string text = "estimator,start,step,log_likelihood,gradient";
  const std::size_t alphas = fits.front().model.parameters.size();
  for (std::size_t k = 0; k < alphas; ++k)
    text += fmt::format(",{}", synth::damping::parameter_name(k));
  text += ",sigma,eta\n";
  for (const DampingFit& fit : fits) {
    int start = -1, number = 0;
    for (const FitStep& step : fit.history) {
      number = step.start == start ? number + 1 : 0;
      start = step.start;
      text += fmt::format("{},{},{},{},{}", name_of(fit.estimator), start, number,
                          step.log_likelihood, step.gradient);
      for (std::size_t k = 0; k < alphas + 2; ++k) {
        text += k < step.parameters.size() ? fmt::format(",{}", step.parameters[k]) : ",";
      }
      text += '\n';
    }
  }
  return text;
}

}  // namespace carillon::eval::damping
