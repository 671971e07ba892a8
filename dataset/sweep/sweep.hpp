#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace carillon::dataset::sweep {

/// More than so many variants are refused: mostly slips in a grid.
constexpr std::size_t max_variants = 10000;

/// One build of a sweep: the configuration with these values in place of its own.
struct SweepVariant {
  std::string folder;                  ///< below the sweep's: `order=3,rt60=0.5s`
  std::vector<std::string> values;     ///< one per swept key: its name, or YAML on one line
  std::vector<std::string> overrides;  ///< `key=value`, as --set takes them
};

/// What `sweep:` in a configuration asks for.
struct Sweep {
  std::string mode;                    ///< grid, zip or random
  std::vector<std::string> keys;       ///< dotted, in the order of the file
  std::vector<SweepVariant> variants;  ///< in order: the last key of a grid changes fastest
  /// Where an override was written, `file:line:column`, for messages.
  std::map<std::string, std::string> places;
};

/// Where variants are written.
struct SweepPlace {
  std::vector<std::string> path = {"sweep"};  ///< keys from the root
  std::string prefix{};                       ///< put before the names of swept keys
  std::vector<std::string> others{};          ///< keys beside the sweep's, of another reader

  std::string text() const;  ///< dotted
};

/// Reads and expands `sweep:`; nothing where there is none (or `--set sweep=` takes it away).
/// A variant's folder depends on its own values alone: a sweep can grow, and its order change.
/// @param overrides  --set, applied before
/// @throws ConfigError  file:line:column: an unknown key in `sweep`, lists of unequal length in a
///                      zip, the same variant twice, too many of them, a swept key that --set sets
std::optional<Sweep> read_sweep(const std::string& text, const std::string& file_name,
                                const std::vector<std::string>& overrides,
                                const SweepPlace& place = {});

}  // namespace carillon::dataset::sweep
