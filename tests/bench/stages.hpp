#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace carillon::bench {

/// One stage of a route as it was measured.
struct Stage {
  std::string name;
  double seconds = 0;      ///< processor time of this process: other programs do not count
  std::int64_t bytes = 0;  ///< most memory resident during the stage, whatever held it
};

/// Runs a stage and appends what it took.
void measure_stage(std::vector<Stage>& stages, const std::string& name,
                   const std::function<void()>& work);

double total_seconds(const std::vector<Stage>& stages);

/// "AMD EPYC ..., 2 cores", from /proc/cpuinfo.
std::string machine();

}  // namespace carillon::bench
