// Damping fits to a table of features, again and again: scripts/bench_fits sets them beside other
// routes to the same numbers. Prints one JSON object.
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <ctime>
#include <vector>

#include "eval/damping/law_text.hpp"
#include "eval/features/feature_table.hpp"

namespace carillon::bench {
namespace {

/// Processor time of this process [s]: other programs do not count.
double now() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

}  // namespace
}  // namespace carillon::bench

int main(int argc, char** argv) {
  using namespace carillon;
  std::string table, model = "rayleigh";
  int repeat = 21;
  CLI::App program{"Times damping fits"};
  program.add_option("features", table)->required();
  program.add_option("--model", model);
  program.add_option("--repeat", repeat);
  CLI11_PARSE(program, argc, argv);
  const eval::DampingData data = eval::damping_data(eval::read_feature_table(table));
  const eval::DampingLaw law = eval::damping_law(model);
  fmt::print("{{");
  for (const auto estimator :
       {eval::Estimator::emg, eval::Estimator::least_squares, eval::Estimator::lower_bound}) {
    for (const bool confidence : {false, true}) {
      std::vector<double> seconds;
      eval::DampingFit fit;
      for (int k = 0; k < repeat; ++k) {
        const double begin = bench::now();
        fit = eval::fit_damping(data, law, {estimator, confidence, false});
        seconds.push_back(bench::now() - begin);
      }
      std::nth_element(seconds.begin(), seconds.begin() + repeat / 2, seconds.end());
      fmt::print("\"{}{}\": {{\"seconds\": {}, \"iterations\": {}, \"log_likelihood\": {}",
                 eval::name_of(estimator), confidence ? " with intervals" : "",
                 seconds[std::size_t(repeat / 2)], fit.iterations, fit.log_likelihood);
      for (std::size_t k = 0; k < fit.model.parameters.size(); ++k) {
        fmt::print(", \"{}\": {}", synth::parameter_name(k), fit.model.parameters[k]);
      }
      const bool last = estimator == eval::Estimator::lower_bound && confidence;
      fmt::print("}}{}", last ? "}\n" : ", ");
    }
  }
  return 0;
}
