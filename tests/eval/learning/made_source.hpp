#pragma once

#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "core/random.hpp"
#include "eval/learning/method.hpp"
#include "eval/learning/sample_source.hpp"
#include "eval/learning/task.hpp"

namespace carillon::eval {

/// Samples that are made as they are asked for: each class has bands and voxels of its own, under
/// noise. Every class has as many samples, one after the other in turn; each object is one class.
class MadeSource final : public learning::SampleSource {
 public:
  MadeSource(std::size_t samples, std::size_t classes, double noise = 0.3)
      : samples_(samples), classes_(classes), noise_(noise) {}

  const std::string& name() const override { return name_; }
  std::size_t size() const override { return samples_; }
  std::vector<std::string> keys() const override {
    std::vector<std::string> keys;
    for (std::size_t i = 0; i < samples_; ++i) keys.push_back("sample-" + std::to_string(i));
    return keys;
  }
  std::vector<std::uint32_t> entries_of(learning::Modality) const override {
    std::vector<std::uint32_t> objects;
    for (std::size_t i = 0; i < samples_; ++i) {
      objects.push_back(static_cast<std::uint32_t>(i % classes_));
    }
    return objects;
  }
  std::vector<std::string> object_names() const override { return labels("object"); }
  std::vector<std::string> strike_names() const override { return keys(); }
  std::vector<std::string> labels(const std::string& column) const override {
    if (const auto own = columns.find(column); own != columns.end()) return own->second;
    std::vector<std::string> labels;
    for (std::size_t i = 0; i < samples_; ++i) {
      if (column == "split") {
        const std::size_t round = i / classes_ % 5;
        labels.push_back(round == 3 ? "validation" : round == 4 ? "test" : "train");
      } else {
        labels.push_back("class-" + std::to_string(i % classes_));
      }
    }
    return labels;
  }
  std::optional<learning::ClipFormat> clip_format() const override { return std::nullopt; }
  std::optional<learning::ModalityLayout> layout(learning::Modality modality) const override {
    switch (modality) {
      case learning::Modality::spectrogram:
        return learning::ModalityLayout{{1, 16, 6}, samples_, false};
      case learning::Modality::voxels:
        return learning::ModalityLayout{{1, 12, 12, 12}, classes_, true};
      case learning::Modality::waveform:
        return learning::ModalityLayout{{1, 8192}, samples_, false};
      default:
        return std::nullopt;
    }
  }
  std::vector<bool> read(learning::Modality modality, std::span<const std::uint32_t> entries,
                         std::span<float> values) override {
    const std::size_t each = values.size() / entries.size();
    std::vector<bool> heard(entries.size(), true);
    for (std::size_t i = 0; i < entries.size(); ++i) {
      const std::uint32_t entry = entries[i];
      if (entry == not_finite) throw core::InputError("sample-" + std::to_string(entry) + " NaN");
      core::RandomStream random(5, entry, learning::name_of(modality));
      const std::size_t of_class = entry % classes_;
      heard[i] = !all_silent && entry != silent;
      ++reads;
      for (std::size_t v = 0; v < each; ++v) {
        values[i * each + v] = static_cast<float>(noise_ * random.normal());
        if (modality == learning::Modality::spectrogram && v / 6 % classes_ == of_class)
          values[i * each + v] += 1;
        if (modality == learning::Modality::voxels)
          values[i * each + v] = v / 144 % classes_ == of_class ? 1 : -1;
        if (modality == learning::Modality::waveform) {
          values[i * each + v] +=
              static_cast<float>(std::sin(0.02 * static_cast<double>((of_class + 1) * v)));
        }
      }
      if (!heard[i])
        std::fill_n(values.begin() + static_cast<std::ptrdiff_t>(i * each), each, 0.0F);
    }
    return heard;
  }
  std::string content() const override { return name_; }

  std::map<std::string, std::vector<std::string>> columns;  ///< in place of what is made
  std::uint32_t silent = static_cast<std::uint32_t>(-1);
  bool all_silent = false;
  std::uint32_t not_finite = static_cast<std::uint32_t>(-1);
  std::size_t reads = 0;  ///< entries

 private:
  std::string name_ = "made";
  std::size_t samples_, classes_;
  double noise_;
};

inline learning::TaskSpec made_task() {
  return {.name = "made", .column = "label", .split = "split", .classes = {}};
}

inline learning::Method made_method(std::vector<learning::Branch> branches,
                                    learning::Fusion fusion = learning::Fusion::concatenate) {
  learning::Method method;
  method.name = "made";
  method.branches = std::move(branches);
  method.fusion = fusion;
  for (const learning::Branch branch : method.branches)
    method.modalities.push_back(learning::modality_of(branch));
  method.spectrogram.scale = learning::SpectrogramScale::power;  // as MadeSource gives them
  method.sizes = {.width = 16,
                  .layers = {{.filters = 8, .kernel_bands = 6, .kernel_frames = 2}},
                  .dropout = 0.2,
                  .fused = 12,
                  .factors = 3};
  method.learning.epochs = 8;
  method.learning.batch = 20;
  method.learning.seed = 4;
  return method;
}

}  // namespace carillon::eval
