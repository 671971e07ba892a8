#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "eval/learning/clip.hpp"
#include "eval/learning/modality.hpp"

namespace carillon::eval::learning {

/// What a source has of one modality.
struct ModalityLayout {
  ModalityExtent extent;
  std::size_t entries = 0;
  /// Many samples have one entry: an object's voxels, its frames in a material. Else samples are
  /// the entries.
  bool shared = false;
};

/// Samples that networks learn from: a dataset, or recordings with labels.
class SampleSource {
 public:
  virtual ~SampleSource() = default;

  /// For messages.
  virtual const std::string& name() const = 0;
  virtual std::size_t size() const = 0;
  virtual std::vector<std::string> keys() const = 0;
  /// What tells each sample's object from every other one's: equal for one object in several
  /// sources.
  virtual std::vector<std::string> object_names() const = 0;
  /// Likewise its strike's: sounds of one strike, of the same object in several materials or by
  /// several microphones, are heard rightly or wrongly together.
  virtual std::vector<std::string> strike_names() const = 0;
  /// A column of texts: labels and splits.
  /// @throws InputError  there is none; names those that there are
  virtual std::vector<std::string> labels(const std::string& column) const = 0;

  /// Nothing where the source has no such modality.
  virtual std::optional<ModalityLayout> layout(Modality modality) const = 0;
  /// Entry of each sample in a modality whose entries are shared.
  virtual std::vector<std::uint32_t> entries_of(Modality modality) const = 0;
  /// Some entries, prepared.
  /// @param entries  ascending
  /// @param values   entries x extent
  /// @return of each whether anything is in it: silent clips are not refused
  /// @throws InputError  a value is not finite; names the sample
  ///         FileError   not readable
  virtual std::vector<bool> read(Modality modality, std::span<const std::uint32_t> entries,
                                 std::span<float> values) = 0;

  /// What its sounds are; nothing where it has none.
  virtual std::optional<ClipFormat> clip_format() const = 0;

  /// Hash of what the values are made of: equal for equal contents.
  virtual std::string content() const = 0;
};

/// What a source has of a modality that is needed.
/// @throws InputError  nothing; says how to get it
ModalityLayout require_layout(const SampleSource& source, Modality modality);

}  // namespace carillon::eval::learning
