#include "eval/recorded_objects/listener_choice.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>

#include "core/error.hpp"
#include "core/text.hpp"
#include "core/units.hpp"

namespace carillon::eval::recorded_objects {

namespace {

using core::InputError;
using Labels = std::optional<std::vector<double>>;

/// Rows of each vertex, in order.
struct StruckVertex {
  std::int64_t vertex;
  std::vector<std::size_t> rows;
};

std::vector<StruckVertex> struck_vertices(const ImpactFolder& folder) {
  std::vector<StruckVertex> all;
  for (std::size_t row = 0; row < folder.rows(); ++row) {
    const auto same = [&](const StruckVertex& other) {
      return other.vertex == folder.vertices[row];
    };
    const auto known = std::find_if(all.begin(), all.end(), same);
    if (known != all.end()) {
      known->rows.push_back(row);
    } else {
      all.push_back({folder.vertices[row], {row}});
    }
  }
  return all;
}

/// Leaves the rows with a label.
void keep(std::vector<std::size_t>& rows, const Labels& labels, const std::optional<double>& value,
          const char* key, const char* file) {
  if (!value) return;
  if (!labels) {
    throw InputError(fmt::format("--listener {}: there is no {}", key, file),
                     "--listener nearest, or the number of a row among those of a vertex");
  }
  std::set<double> there;
  for (const std::size_t row : rows) there.insert((*labels)[row]);
  std::erase_if(rows, [&](std::size_t row) { return (*labels)[row] != *value; });
  if (rows.empty()) {
    throw InputError(fmt::format("--listener {}={}: no such recording", key, *value),
                     fmt::format("there are {}", fmt::join(there, ", ")));
  }
}

std::size_t choose(const ImpactFolder& folder, const ListenerChoice& choice,
                   const StruckVertex& struck) {
  if (choice.number) {
    if (*choice.number < struck.rows.size()) return struck.rows[*choice.number];
    throw InputError(fmt::format("--listener {}: vertex {} has recordings 0 to {}", *choice.number,
                                 struck.vertex, struck.rows.size() - 1));
  }
  std::vector<std::size_t> rows = struck.rows;
  keep(rows, folder.angles, choice.angle, "angle", "angle.npy");
  keep(rows, folder.distances, choice.distance, "distance", "distance.npy");
  keep(rows, folder.microphones, choice.microphone, "mic", "micID.npy");
  // To a tenth of a millimetre, so that rounding does not choose among equals: the first does.
  const auto distance = [&](std::size_t row) {
    return std::lround(1e4 * (folder.listeners[row] - folder.centre).norm());
  };
  return *std::min_element(rows.begin(), rows.end(),
                           [&](std::size_t a, std::size_t b) { return distance(a) < distance(b); });
}

}  // namespace

ListenerChoice parse_listener_choice(const std::string& text) {
  ListenerChoice choice;
  if (text == "nearest") return choice;
  const auto number = core::number_in<std::int64_t>(text);
  if (number && *number >= 0) {
    choice.number = static_cast<std::uint64_t>(*number);
    return choice;
  }
  for (const auto& [key, value] : core::parse_assignments(text)) {
    std::optional<double>* label = key == "angle"      ? &choice.angle
                                   : key == "distance" ? &choice.distance
                                   : key == "mic"      ? &choice.microphone
                                                       : nullptr;
    if (label == nullptr) {
      throw InputError(fmt::format("--listener {}: no such label", key),
                       "nearest, a number, or angle=0,distance=0,mic=7");
    }
    *label = core::parse_quantity(value, core::Dimension::none);
  }
  return choice;
}

std::vector<RecordedStrike> choose_rows(const ImpactFolder& folder, const ListenerChoice& choice,
                                        std::span<const std::int64_t> wanted) {
  const std::vector<StruckVertex> all = struck_vertices(folder);
  for (const std::int64_t vertex : wanted) {
    const auto is = [&](const StruckVertex& struck) { return struck.vertex == vertex; };
    if (std::any_of(all.begin(), all.end(), is)) continue;
    std::vector<std::int64_t> there;
    for (const StruckVertex& struck : all) there.push_back(struck.vertex);
    throw InputError(fmt::format("--vertex {}: it was not struck", vertex),
                     fmt::format("there are {}", fmt::join(there, ", ")));
  }
  std::vector<RecordedStrike> strikes;
  for (const StruckVertex& struck : all) {
    if (wanted.empty() || std::find(wanted.begin(), wanted.end(), struck.vertex) != wanted.end()) {
      strikes.push_back({struck.vertex, choose(folder, choice, struck)});
    }
  }
  return strikes;
}

}  // namespace carillon::eval::recorded_objects
