#pragma once

#include <memory>
#include <string>
#include <vector>

#include "eval/learning/sample_source.hpp"
#include "eval/learning/selected_source.hpp"
#include "eval/learning/task.hpp"

namespace carillon::eval::studies {

/// A source that is open, and its samples of a task.
struct OpenCondition {
  std::unique_ptr<learning::SampleSource> source;
  learning::LabelledSamples samples;

  /// @param number  of the source among those that are selected from
  std::vector<learning::Selection> part(learning::Part part, std::uint32_t number) const;
  /// So many of a part's samples, in an order that is the same wherever these strikes are computed:
  /// those of less are always among them. All where it has fewer.
  std::vector<learning::Selection> first_of(learning::Part part, std::size_t count,
                                            std::uint32_t number) const;
  /// The same from the other end: beside the first of another condition they repeat no strike.
  std::vector<learning::Selection> last_of(learning::Part part, std::size_t count,
                                           std::uint32_t number) const;
};

/// Keys of so many of the sounds that both have, evenly chosen from the target's part that is
/// tested.
std::vector<std::string> common_keys(const OpenCondition& target, const OpenCondition& other,
                                     std::size_t maximum);

}  // namespace carillon::eval::studies
