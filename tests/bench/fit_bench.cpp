// Damping fits to a table of features, again and again: scripts/bench_fits sets them beside other
// routes to the same numbers. Prints one JSON object. Without a table: the bias of each estimator
// on features drawn from the model, as in docs/damping-fits.md.
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <ctime>
#include <vector>

#include "core/numbers.hpp"
#include "eval/damping/law_text.hpp"
#include "eval/features/feature_table.hpp"
#include "tests/eval/drawn_features.hpp"

namespace carillon::bench {
namespace {

using eval::damping::Estimator;
constexpr Estimator estimators[] = {Estimator::mixture, Estimator::emg, Estimator::least_squares,
                                    Estimator::lower_bound};

/// Processor time of this process [s]: other programs do not count.
double now() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

void time_fits(const std::string& table, const std::string& model, int repeat) {
  const eval::damping::DampingData data =
      eval::damping::damping_data(eval::features::read_feature_table(table));
  const eval::damping::DampingLaw law = eval::damping::damping_law(model);
  const char* comma = "";
  fmt::print("{{");
  for (const Estimator estimator : estimators) {
    for (const bool confidence : {false, true}) {
      std::vector<double> seconds;
      eval::damping::DampingFit fit;
      for (int k = 0; k < repeat; ++k) {
        const double begin = now();
        fit = eval::damping::fit_damping(data, law, {estimator, confidence, false});
        seconds.push_back(now() - begin);
      }
      fmt::print("{}\"{}{}\": {{\"seconds\": {}, \"iterations\": {}, \"log_likelihood\": {}", comma,
                 eval::damping::name_of(estimator), confidence ? " with intervals" : "",
                 core::median(seconds), fit.iterations, fit.log_likelihood);
      for (std::size_t k = 0; k < fit.model.parameters.size(); ++k) {
        fmt::print(", \"{}\": {}", synth::damping::parameter_name(k), fit.model.parameters[k]);
      }
      fmt::print("}}");
      comma = ", ";
    }
  }
  fmt::print("}}\n");
}

/// Mean error of the fitted d at 500 Hz, 2 kHz and 8 kHz [%], and the median of its size at 500 Hz.
void print_bias(const eval::Draw& draw) {
  constexpr std::uint64_t repetitions = 200;
  constexpr double hertz[] = {500, 2000, 8000};
  std::string medians;
  fmt::print("| {} | {} | {} |", draw.points, draw.sigma, draw.tau);
  for (const Estimator estimator :
       {Estimator::least_squares, Estimator::lower_bound, Estimator::emg, Estimator::mixture}) {
    double bias[3] = {};
    std::vector<double> sizes;
    for (std::uint64_t repetition = 0; repetition < repetitions; ++repetition) {
      const auto fit = eval::damping::fit_damping(eval::drawn_features(draw, repetition), {},
                                                  {estimator, false, false});
      const auto c = synth::damping::damping_function(fit.model);
      for (int i = 0; i < 3; ++i) {
        const double omega = 2 * std::numbers::pi * hertz[i];
        const double error = 100 * (c(omega * omega) / 2 / eval::true_decay_rate(hertz[i]) - 1);
        bias[i] += error / static_cast<double>(repetitions);
        if (i == 0) sizes.push_back(std::abs(error));
      }
    }
    fmt::print(" {:+.0f} / {:+.0f} / {:+.0f} |", bias[0], bias[1], bias[2]);
    medians += fmt::format(" {:.0f} /", core::median(sizes));
  }
  fmt::print("{} |\n", medians.substr(0, medians.size() - 2));
}

}  // namespace
}  // namespace carillon::bench

int main(int argc, char** argv) {
  using namespace carillon;
  std::string table, model = "rayleigh";
  int repeat = 21;
  CLI::App program{"Times damping fits, or measures their bias"};
  program.add_option("features", table, "table; none: bias");
  program.add_option("--model", model);
  program.add_option("--repeat", repeat);
  CLI11_PARSE(program, argc, argv);
  if (!table.empty()) {
    bench::time_fits(table, model, repeat);
    return 0;
  }
  fmt::print(
      "| features | sigma | tau | least squares | lower bound | EMG | mixture | median error |\n");
  fmt::print("|---|---|---|---|---|---|---|---|\n");
  for (const eval::Draw& draw :
       {eval::Draw{100, 1, 10}, eval::Draw{30, 1, 10}, eval::Draw{15, 1, 10}, eval::Draw{30, 5, 10},
        eval::Draw{30, 1, 1}, eval::Draw{30, 3, 40}, eval::Draw{30, 2, 0}}) {
    bench::print_bias(draw);
  }
  return 0;
}
