#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "eval/damping/fitted_alphas.hpp"
#include "eval/recorded_objects/impact_report.hpp"

namespace carillon::eval::recorded_objects {

namespace {

/// A number, or a dash where there is none.
std::string figure(double value, int width, int digits) {
  return std::isnan(value) ? fmt::format("{:>{}}", "-", width)
                           : fmt::format("{:{}.{}f}", value, width, digits);
}

void print_peaks(const ImpactReport& report) {
  fmt::print("\nmodes and as many of the highest peaks, samples {} to {}, of all vertices:\n",
             report.options.stretch.first, report.options.stretch.end);
  fmt::print("  {:<28} {:>7} {:>11} {:>10} {:>20} {:>12}\n", "", "scale", "matched", "by chance",
             "cents: median, 90 %", "rms by rank");
  for (const ModelVariant& variant : report.variants) {
    const recorded::PeakMatch all = recorded::joined(variant.peaks);
    std::vector<double> distances;
    for (const double cents : all.cents) distances.push_back(std::abs(cents));
    const recorded::Spread spread = recorded::spread_of(distances);
    fmt::print("  {:<28} {:7.4f} {:>11} {:>10.1f} {} {} {} Hz\n", variant.name,
               recorded::spread_of(variant.scales).median,
               fmt::format("{} of {}", all.matched, all.modes), all.matched_by_chance,
               figure(spread.median, 11, 1), figure(spread.high, 8, 1),
               figure(all.rank_rms_hz, 9, 0));
  }
}

/// The middle and where most lie, or a dash.
std::string decay_text(const recorded::Spread& ratio) {
  if (std::isnan(ratio.median)) return fmt::format("{:>22}", "-");
  return fmt::format("{} ({} -{})", figure(ratio.median, 7, 3), figure(ratio.low, 5, 2),
                     figure(ratio.high, 5, 2));
}

void print_modes(const ImpactReport& report) {
  fmt::print("\nmodes of the whole recordings, of all vertices:\n");
  fmt::print("  {:<28} {:>13} {:>10} {:>8} {:>16} {:>22} {:>17}\n", "", "matched", "by chance",
             "energy", "cents: med, 90 %", "decay ratio (10-90 %)", "dB: med, 90 %");
  bool without = false;
  for (const ModelVariant& variant : report.variants) {
    const recorded::RecordedSummary& all = variant.modes.all;
    fmt::print("  {:<28} {:>13} {:>10.1f} {} % {} {} {} {} {}\n", variant.name,
               fmt::format("{} of {}, {}", all.matched, all.recorded, all.synthetic),
               all.matched_by_chance, figure(100 * all.recorded_fraction, 6, 1),
               figure(all.distance.median, 8, 1), figure(all.distance.high, 7, 1),
               decay_text(all.decay_ratio), figure(all.level_error.median, 8, 1),
               figure(all.level_error.high, 8, 1));
    without = without || variant.frequencies_alone;
  }
  fmt::print("  matched: of recorded and synthetic modes; energy: of what is recorded; dB: {}\n",
             report.options.radiation
                 ? "beside one gain of all recordings"
                 : "not physical, as the struck point is heard and not the sound");
  if (without) {
    fmt::print("  -: pressure goes with the frequencies, and is not known for scaled ones\n");
  }
}

void print_vertices(const ImpactReport& report) {
  const ModelVariant& variant = report.variants.back();
  fmt::print("\n{}, vertex by vertex:\n", variant.name);
  fmt::print("  {:>8} {:>6} {:>22} {:>10} {:>8} {:>16} {:>9} {:>9}\n", "vertex", "row",
             "microphone at [m]", "peaks", "chance", "modes matched", "cents", "level dB");
  for (std::size_t i = 0; i < report.strikes.size(); ++i) {
    const RecordedStrike& strike = report.strikes[i].recorded;
    const Vec3& ear = report.folder.listeners[strike.row];
    const perception::ModeComparison& modes = variant.modes.strikes[i];
    std::vector<double> distances;
    for (const perception::MatchedMode& pair : modes.matched) {
      distances.push_back(std::abs(pair.cents));
    }
    fmt::print(
        "  {:>8} {:>6} {:>22} {:>10} {:>8.1f} {:>16} {} {}\n", strike.vertex, strike.row,
        fmt::format("{:.3f},{:.3f},{:.3f}", ear.x(), ear.y(), ear.z()),
        fmt::format("{} of {}", variant.peaks[i].matched, variant.peaks[i].modes),
        variant.peaks[i].matched_by_chance,
        fmt::format("{} of {}, {}", modes.matched.size(), report.strikes[i].set.features.size(),
                    variant.modes.synthetic[i].size()),
        figure(recorded::spread_of(distances).median, 9, 1),
        figure(recorded::spread_of(levels_of(modes)).median, 9, 1));
  }
}

/// What single vertices would have in place of the modulus of all.
void print_moduli_alone(const StudyFit& fit) {
  std::vector<double> ratios;
  for (const auto& alone : fit.alone) {
    if (alone) ratios.push_back(*alone / *fit.specific_modulus);
  }
  if (ratios.size() < 2) return;
  const auto [minimum, maximum] = std::minmax_element(ratios.begin(), ratios.end());
  fmt::print("  {:<20} {:.4f} to {:.4f} of that, {} of {}\n", "each vertex alone", *minimum,
             *maximum, ratios.size(), fit.alone.size());
}

void print_fit(const ImpactReport& report) {
  const StudyFit& fit = *report.fit;
  if (!fit.specific_modulus) {
    fmt::print("\n{:<22} not determined: {}\n", "specific modulus", fit.undetermined);
    return;
  }
  const double modulus = *fit.specific_modulus;
  const double density = report.material.elastic.density;
  fmt::print("\n{:<22} {:.5g} m^2/s^2, {:.4f} of the one given\n", "specific modulus", modulus,
             modulus / report.given.specific_modulus);
  if (fit.modulus95) {
    fmt::print("  {:<20} {:.5g} to {:.5g}, at Poisson's ratio {:.3g}\n", "95 %", fit.modulus95->low,
               fit.modulus95->high, report.material.elastic.poisson_ratio);
  }
  print_moduli_alone(fit);
  fmt::print("  {:<20} {:.1f}, as given {:.1f}\n", "log-likelihood", fit.log_likelihood,
             fit.log_likelihood_given);
  fmt::print("{:<22} {:.5g} GPa at {:.5g} kg/m^3\n", "Young's modulus", 1e-9 * modulus * density,
             density);
  const synth::damping::DampingModel& damping = fit.damping;
  const std::string source = fit.points > 0 ? fmt::format("from {} matched modes", fit.points)
                             : fit.joint    ? "as the joint estimate has it"
                                            : "as given";
  fmt::print("{:<22} {}{}, {}\n", "damping",
             damping.kind == synth::damping::DampingKind::expression
                 ? "c = " + damping.expression
                 : synth::damping::form_of(damping.kind).formula,
             report.options.radiation ? " and what is radiated" : "", source);
  for (std::size_t k = 0; k < damping.parameters.size(); ++k) {
    fmt::print("  {:<20} {:.5g} {:<16} {}\n", synth::damping::parameter_name(k),
               damping.parameters[k], synth::damping::parameter_unit(damping.kind, k),
               fit.confidence95.empty() ? "" : damping::interval_text(fit.confidence95[k]));
  }
}

}  // namespace

void print_report(const ImpactReport& report) {
  fmt::print("{}: {} recordings of {} samples at {} Hz, {}; {}\n", report.folder.mesh.string(),
             report.folder.rows(), report.folder.samples(), report.options.sample_rate,
             report.folder.deconvolved ? "deconvolved" : "as recorded", report.material.name);
  fmt::print("{} modes, none missing below {:.0f} Hz; {}\n", report.given.modes.size(),
             report.given.modes.certificate.complete_to_hz,
             report.options.radiation ? "heard at the microphones by equivalent sources"
                                      : "heard at the struck point (acceleration)");
  print_peaks(report);
  print_modes(report);
  print_vertices(report);
  if (report.fit) print_fit(report);
  for (const std::string& remark : report.remarks) fmt::print("- {}\n", remark);
  if (report.fit) {
    for (const std::string& remark : report.fit->remarks) fmt::print("- {}\n", remark);
  }
  for (const auto& [stage, entry] : report.trace.stages) {
    fmt::print("{:<22} {:8.3f} s\n", stage, entry.seconds);
  }
}

}  // namespace carillon::eval::recorded_objects
