// Features of a clip of doubles in full precision: scripts/bench_features sets their time and
// errors beside another route's. Prints one JSON object.
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <ctime>
#include <fstream>
#include <vector>

#include "eval/features/extract_features.hpp"

namespace {

/// Processor time of this process [s]: other programs do not count.
double now() {
  timespec time{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

std::vector<double> read_doubles(const std::string& path) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  std::vector<double> values(static_cast<std::size_t>(file.tellg()) / sizeof(double));
  file.seekg(0);
  file.read(reinterpret_cast<char*>(values.data()),
            static_cast<std::streamsize>(values.size() * sizeof(double)));
  return values;
}

}  // namespace

int main(int argc, char** argv) {
  using namespace carillon;
  std::string path;
  double rate = 44100;
  CLI::App program{"Times the features of a clip"};
  program.add_option("clip", path, "file of doubles")->required()->check(CLI::ExistingFile);
  program.add_option("--rate", rate, "sample rate [Hz]");
  CLI11_PARSE(program, argc, argv);
  const std::vector<double> samples = read_doubles(path);
  carillon::eval::features::FeatureOptions options;
  options.onset = 0;
  const double begin = now();
  const carillon::eval::features::FeatureSet set =
      carillon::eval::features::extract_features(samples, rate, options);
  fmt::print("{{\"seconds\": {}, \"features\": [", now() - begin);
  const char* comma = "";
  for (const carillon::eval::features::Feature& feature : set.features) {
    fmt::print("{}[{}, {}, {}]", comma, feature.frequency, feature.decay_rate, feature.amplitude);
    comma = ", ";
  }
  fmt::print("]}}\n");
  return 0;
}
