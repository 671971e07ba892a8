#include "mpi/launcher.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdlib>
#include <string_view>
#include <utility>

namespace carillon::mpi {

namespace {

std::optional<int> number_in(const char* variable) {
  const char* const value = std::getenv(variable);
  if (value == nullptr) return std::nullopt;
  const std::string_view text = value;
  int number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return number;
}

bool is_set(const char* variable) {
  return std::getenv(variable) != nullptr;
}

}  // namespace

std::optional<int> launcher_rank() {
  for (const char* variable : {"OMPI_COMM_WORLD_RANK", "PMIX_RANK", "PMI_RANK"}) {
    if (const auto rank = number_in(variable)) return rank;
  }
  // A batch script and `srun --mpi=none` have a number too, and no ranks.
  constexpr std::array pmi = {"PMI_FD", "PMI_PORT", "PMI_SIZE", "PMI_JOBID", "PMIX_NAMESPACE"};
  if (std::any_of(pmi.begin(), pmi.end(), is_set)) return number_in("SLURM_PROCID");
  return std::nullopt;
}

AloneSettings::AloneSettings() {
  if (launcher_rank()) return;
  constexpr std::pair<const char*, const char*> settings[] = {
      // No daemon beside the process, which could start others for it: 0.1 s.
      {"OMPI_MCA_ess_singleton_isolated", "1"},
      // Messages by the plain layer; it looks for no fast networks (UCX, libfabric): 0.25 s.
      {"OMPI_MCA_pml", "ob1"},
      // Messages to this process alone, no shared memory and no sockets: 0.01 s.
      {"OMPI_MCA_btl", "self"}};
  for (const auto& [variable, value] : settings) {
    if (is_set(variable)) continue;
    setenv(variable, value, 1);
    added_.emplace_back(variable);
  }
}

AloneSettings::~AloneSettings() {
  for (const std::string& variable : added_) unsetenv(variable.c_str());
}

}  // namespace carillon::mpi
