#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "eval/learning/sample_source.hpp"
#include "eval/learning/task.hpp"

namespace carillon::eval::learning {

/// One sample of one of several sources, and the part that it is put into, if not its own.
struct Selection {
  std::uint32_t source = 0;
  std::uint32_t row = 0;
  std::optional<Part> part{};

  // NOLINTNEXTLINE(modernize-use-nullptr): the zero is the language's own
  auto operator<=>(const Selection&) const = default;
};

/// Some samples of several sources as one: trained with one condition, tested on another, or mixed.
///
/// Keys are `SOURCE:KEY`, the source counted from 0. Every column that is asked for must be in all
/// sources; a column of splits (`split_shape`, `split_strike`) says the parts of the selection
/// where it has them; the column `dataset` says the source's name. A modality is there where all
/// have it in one extent, those of hearing of sounds that are alike.
/// @param sources   outlive the result
/// @param selected  in any order, each sample at most once; they are kept by source and row
/// @param names     of the sources; empty: there is no column `dataset` but their own
/// @throws InputError  no samples, or one twice
std::unique_ptr<SampleSource> select_samples(std::vector<SampleSource*> sources,
                                             std::vector<Selection> selected,
                                             std::vector<std::string> names = {});

}  // namespace carillon::eval::learning
