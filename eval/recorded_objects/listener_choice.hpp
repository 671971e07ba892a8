#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "eval/recorded_objects/impact_folder.hpp"

namespace carillon::eval::recorded_objects {

/// Which microphone is compared, the same way for every vertex: the one nearest to the object of
/// those that are not ruled out.
struct ListenerChoice {
  std::optional<std::uint64_t> number;  ///< among the rows of a vertex, from 0
  std::optional<double> angle;          ///< [degrees]
  std::optional<double> distance;       ///< [mm]
  std::optional<double> microphone;
};

/// `nearest`, a number, or `angle=80,distance=333,mic=8` of which some may be left out.
/// @throws InputError
ListenerChoice parse_listener_choice(const std::string& text);

/// A strike and the recording of it that is compared.
struct RecordedStrike {
  std::int64_t vertex = 0;
  std::size_t row = 0;
};

/// One row for each vertex, in the order in which vertices come first.
/// @param wanted  vertices; empty: all
/// @throws InputError  a vertex that was not struck, no row that fits, or a label without file
std::vector<RecordedStrike> choose_rows(const ImpactFolder& folder, const ListenerChoice& choice,
                                        std::span<const std::int64_t> wanted);

}  // namespace carillon::eval::recorded_objects
