#include "eval/learning/selected_source.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "core/error.hpp"
#include "core/hash.hpp"

namespace carillon::eval::learning {

namespace {

std::string name_of_part(Part part) {
  return part == Part::train ? "train" : part == Part::validation ? "validation" : "test";
}

class SelectedSource final : public SampleSource {
 public:
  SelectedSource(std::vector<SampleSource*> sources, std::vector<Selection> selected,
                 std::vector<std::string> names)
      : sources_(std::move(sources)), selected_(std::move(selected)), names_(std::move(names)) {
    std::sort(selected_.begin(), selected_.end());
    const auto twice = std::adjacent_find(selected_.begin(), selected_.end(),
                                          [](const Selection& a, const Selection& b) {
                                            return a.source == b.source && a.row == b.row;
                                          });
    if (selected_.empty() || twice != selected_.end()) {
      throw core::InputError(selected_.empty() ? "no samples are selected"
                                               : "a sample is selected twice");
    }
    core::Sha256 all;
    for (const SampleSource* source : sources_) {
      name_ += (name_.empty() ? "" : " + ") + source->name();
      all.add(source->content()).add("\n");
      // Shared entries of one source come after those of the ones before it.
      for (const Modality modality : all_modalities) {
        const auto layout = source->layout(modality);
        Numbering& numbering = shared_[modality];
        numbering.first.push_back(numbering.count);
        if (layout && layout->shared) numbering.count += layout->entries;
      }
    }
    for (const Selection& one : selected_) {
      all.add(fmt::format("{} {} {}\n", one.source, one.row,
                          one.part ? static_cast<int>(*one.part) : -1));
    }
    for (const std::string& name : names_) all.add(name).add("\n");
    content_ = all.hex();
  }

  const std::string& name() const override { return name_; }
  std::size_t size() const override { return selected_.size(); }
  std::string content() const override { return content_; }
  std::optional<ClipFormat> clip_format() const override { return sources_[0]->clip_format(); }

  std::vector<std::string> keys() const override {
    return gathered<std::string>([](const SampleSource& source) { return source.keys(); },
                                 [](const std::string& key, std::uint32_t source) {
                                   return fmt::format("{}:{}", source, key);
                                 });
  }

  std::vector<std::string> object_names() const override {
    return gathered<std::string>([](const SampleSource& source) { return source.object_names(); },
                                 [](const std::string& name, std::uint32_t) { return name; });
  }
  std::vector<std::string> strike_names() const override {
    return gathered<std::string>([](const SampleSource& source) { return source.strike_names(); },
                                 [](const std::string& name, std::uint32_t) { return name; });
  }

  std::vector<std::string> labels(const std::string& column) const override {
    std::vector<std::string> labels;
    if (column == "dataset" && !names_.empty()) {
      for (const Selection& one : selected_) labels.push_back(names_[one.source]);
      return labels;
    }
    const bool split = column == "split_shape" || column == "split_strike";
    const bool own_parts = std::all_of(selected_.begin(), selected_.end(),
                                       [](const Selection& one) { return one.part.has_value(); });
    if (split && own_parts) {
      for (const Selection& one : selected_) labels.push_back(name_of_part(*one.part));
      return labels;
    }
    return gathered<std::string>([&](const SampleSource& source) { return source.labels(column); },
                                 [](const std::string& label, std::uint32_t) { return label; });
  }

  std::optional<ModalityLayout> layout(Modality modality) const override {
    std::optional<ModalityLayout> common = sources_[0]->layout(modality);
    for (const SampleSource* source : sources_) {
      const auto own = source->layout(modality);
      if (!common || !own || own->extent != common->extent || own->shared != common->shared) {
        return std::nullopt;
      }
      // Equal extents may be of other rates, lengths and bands.
      const bool heard = modality == Modality::spectrogram || modality == Modality::waveform;
      if (heard && source->clip_format() && sources_[0]->clip_format() &&
          to_json(*source->clip_format()) != to_json(*sources_[0]->clip_format())) {
        return std::nullopt;
      }
    }
    common->entries = common->shared ? shared_.at(modality).count : size();
    return common;
  }

  std::vector<std::uint32_t> entries_of(Modality modality) const override {
    const std::vector<std::size_t>& first = shared_.at(modality).first;
    return gathered<std::uint32_t>(
        [&](const SampleSource& source) { return source.entries_of(modality); },
        [&](std::uint32_t entry, std::uint32_t source) {
          return entry + static_cast<std::uint32_t>(first[source]);
        });
  }

  std::vector<bool> read(Modality modality, std::span<const std::uint32_t> entries,
                         std::span<float> values) override {
    if (entries.empty()) return {};
    const std::size_t each = values.size() / entries.size();
    const bool shared = layout(modality).value().shared;
    std::vector<bool> heard;
    for (std::size_t first = 0; first < entries.size();) {
      const auto [source, row] = place_of(modality, entries[first], shared);
      std::vector<std::uint32_t> rows = {row};
      while (first + rows.size() < entries.size()) {
        const auto [next_source, next_row] =
            place_of(modality, entries[first + rows.size()], shared);
        if (next_source != source) break;
        rows.push_back(next_row);
      }
      const std::vector<bool> some =
          sources_[source]->read(modality, rows, values.subspan(first * each, rows.size() * each));
      heard.insert(heard.end(), some.begin(), some.end());
      first += rows.size();
    }
    return heard;
  }

 private:
  /// A value of each sample, from its source.
  template <class T, class Column, class Change>
  std::vector<T> gathered(const Column& column, const Change& change) const {
    std::vector<std::vector<T>> columns;
    for (const SampleSource* source : sources_) columns.push_back(column(*source));
    std::vector<T> values;
    for (const Selection& one : selected_) {
      values.push_back(change(columns[one.source][one.row], one.source));
    }
    return values;
  }

  /// Source of an entry, and the entry there.
  std::pair<std::size_t, std::uint32_t> place_of(Modality modality, std::uint32_t entry,
                                                 bool shared) const {
    if (!shared) return {selected_[entry].source, selected_[entry].row};
    const std::vector<std::size_t>& starts = shared_.at(modality).first;
    const auto after = std::upper_bound(starts.begin(), starts.end(), entry);
    const auto source = static_cast<std::size_t>(after - starts.begin()) - 1;
    return {source, entry - static_cast<std::uint32_t>(starts[source])};
  }

  /// Shared entries of all sources.
  struct Numbering {
    std::vector<std::size_t> first;  ///< of each source
    std::size_t count = 0;
  };

  std::vector<SampleSource*> sources_;
  std::vector<Selection> selected_;
  std::vector<std::string> names_;
  std::string name_, content_;
  std::map<Modality, Numbering> shared_;
};

}  // namespace

std::unique_ptr<SampleSource> select_samples(std::vector<SampleSource*> sources,
                                             std::vector<Selection> selected,
                                             std::vector<std::string> names) {
  return std::make_unique<SelectedSource>(std::move(sources), std::move(selected),
                                          std::move(names));
}

}  // namespace carillon::eval::learning
