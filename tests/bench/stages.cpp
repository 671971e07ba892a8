#include "stages.hpp"

#include <malloc.h>

#include <algorithm>
#include <ctime>
#include <fstream>
#include <set>
#include <thread>

namespace carillon::bench {
namespace {

double processor_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// The kernel's highest mark of resident memory starts anew from what is resident.
void reset_high_water() {
  malloc_trim(0);  // what earlier stages let go is not this one's
  std::ofstream("/proc/self/clear_refs") << "5";
}

std::int64_t high_water() {
  std::ifstream status("/proc/self/status");
  for (std::string word; status >> word;) {
    if (word == "VmHWM:") {
      std::int64_t kilobytes = 0;
      status >> kilobytes;
      return 1024 * kilobytes;
    }
  }
  return 0;
}

}  // namespace

void measure_stage(std::vector<Stage>& stages, const std::string& name,
                   const std::function<void()>& work) {
  reset_high_water();
  const double start = processor_seconds();
  work();
  stages.push_back({name, processor_seconds() - start, high_water()});
}

double total_seconds(const std::vector<Stage>& stages) {
  double sum = 0;
  for (const auto& stage : stages) sum += stage.seconds;
  return sum;
}

std::string machine() {
  std::ifstream info("/proc/cpuinfo");
  std::string model = "unknown processor";
  for (std::string line; std::getline(info, line);) {
    if (line.starts_with("model name")) {
      model = line.substr(line.find(':') + 2);
      break;
    }
  }
  return model + ", " + std::to_string(std::thread::hardware_concurrency()) + " cores";
}

}  // namespace carillon::bench
