#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace carillon::dataset::sweep {

/// More than so many variants are refused: mostly slips in a grid.
constexpr std::size_t max_variants = 10000;

/// `{from: 0.2 s, to: 1 s, count: 5, spacing: log}`: numbers in one unit.
struct SweepRange {
  double from = 0, to = 0;
  std::string unit;  ///< as it was written; "" for bare numbers
  bool logarithmic = false;
  std::int64_t count = 0;  ///< of values, both ends included; 0: by step
  double step = 0;         ///< 0: by count; 0 and no count: anything between the ends
  bool continuous() const { return count == 0 && step == 0; }
};

/// One value of a swept key.
struct SweepValue {
  std::string text;   ///< as --set takes it
  std::string label;  ///< for people and folders; the text where it has no name
  bool operator<(const SweepValue& other) const { return text < other.text; }
};

/// What a swept key takes.
struct SweepAxis {
  std::vector<SweepValue> values{};   ///< empty for a continuous range
  std::optional<SweepRange> range{};  ///< where it was written as one
};

/// One build of a sweep: the configuration with these values in place of its own.
struct SweepVariant {
  std::string folder;                  ///< below the sweep's: `order=3,rt60=0.5s`
  std::vector<std::string> values;     ///< one per swept key: its name, or YAML on one line
  std::vector<std::string> overrides;  ///< `key=value`, as --set takes them
};

/// What `sweep:` in a configuration asks for.
struct Sweep {
  std::string mode;                    ///< grid, zip or random; parzen where it may be
  std::vector<std::string> keys;       ///< dotted, in the order of the file
  std::vector<SweepVariant> variants;  ///< in order: the last key of a grid changes fastest
  std::vector<SweepAxis> axes;         ///< of the keys
  std::int64_t count = 0;              ///< of random and parzen
  std::uint64_t seed = 0;
  /// Where an override was written, `file:line:column`, for messages.
  std::map<std::string, std::string> places;
};

/// Where variants are written.
struct SweepPlace {
  std::vector<std::string> path = {"sweep"};  ///< keys from the root
  std::string prefix{};                       ///< put before the names of swept keys
  std::vector<std::string> others{};          ///< keys beside the sweep's, of another reader
  /// `mode: parzen` is taken: a search, of which the outcomes say what is tried next. It has no
  /// variants of its own.
  bool is_search = false;

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

/// The variant of a place: of each axis the number of a value, or 0 to 1 along a continuous range.
SweepVariant variant_at(const Sweep& sweep, const std::vector<double>& place);

}  // namespace carillon::dataset::sweep
