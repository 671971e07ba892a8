#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "eval/learning/sample_source.hpp"

namespace carillon::eval::learning {

/// Sounds of one's own: files with labels, from a table or out of their names.
struct RecordingsSpec {
  std::filesystem::path folder;
  /// CSV with a header: `file` (from the folder) and any columns of labels; empty: `names`.
  std::filesystem::path table;
  /// How files lie in the folder: `{material}/{shape}-*.wav`. A name in braces is a label without a
  /// slash, a star anything without one, as little as can be; the extension may be left out. Case
  /// does not count. Names that can be read in two ways are refused.
  std::string names;
  double seconds = 1;          ///< of each sound from its strike on
  double sample_rate = 44100;  ///< [Hz]
  /// Column whose values are the objects that were struck. Empty: `shape`, where there is none each
  /// file is an object.
  std::string object;
  /// Column whose values tell an object's strikes apart, where one was recorded by several
  /// microphones or is there in several versions. Empty: each file is a strike of its own.
  std::string strike;
  /// Shares of objects and of strikes where the table has no column `split`, `split_shape` or
  /// `split_strike`.
  double validation = 0.1, test = 0.1;
  std::uint64_t seed = 0;
};

/// Recordings as samples. Their keys are the files' names. Of columns of splits that are not in the
/// table, an object's or strike's part depends on its name (of a file's: what it holds) and the
/// seed alone: more files move none.
///
/// `labels` of a split throws InputError where an object (`split_shape`), a strike, or the same
/// sound under two names, is in two parts.
/// @param format  of their clips; none: the spec's length and rate with the papers' spectrograms
/// @throws FileError   the folder or the table cannot be read
///         InputError  no files, one that the table or the pattern does not fit; names it
std::unique_ptr<SampleSource> open_recordings(const RecordingsSpec& spec,
                                              const std::optional<ClipFormat>& format = {});

}  // namespace carillon::eval::learning
