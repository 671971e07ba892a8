#include "eval/learning/selected_source.hpp"

#include <fmt/format.h>

#include <algorithm>

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
      // Objects of one source come after those of the ones before it; where a modality is of
      // objects its entries are counted alike.
      first_object_.push_back(objects_in_all_);
      std::size_t objects = 0;
      for (const std::uint32_t object : source->objects())
        objects = std::max<std::size_t>(objects, object + 1);
      for (const Modality modality : all_modalities) {
        const auto layout = source->layout(modality);
        if (layout && layout->of_objects) objects = std::max(objects, layout->entries);
      }
      objects_in_all_ += objects;
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

  std::vector<std::uint32_t> objects() const override {
    return gathered<std::uint32_t>([](const SampleSource& source) { return source.objects(); },
                                   [this](std::uint32_t object, std::uint32_t source) {
                                     return object +
                                            static_cast<std::uint32_t>(first_object_[source]);
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
      if (!common || !own || own->extent != common->extent ||
          own->of_objects != common->of_objects) {
        return std::nullopt;
      }
      // Equal extents may be of other rates, lengths and bands.
      const bool heard = modality == Modality::spectrogram || modality == Modality::waveform;
      if (heard && source->clip_format() && sources_[0]->clip_format() &&
          to_json(*source->clip_format()) != to_json(*sources_[0]->clip_format())) {
        return std::nullopt;
      }
    }
    common->entries = common->of_objects ? objects_in_all_ : size();
    return common;
  }

  std::vector<bool> read(Modality modality, std::span<const std::uint32_t> entries,
                         std::span<float> values) override {
    if (entries.empty()) return {};
    const std::size_t each = values.size() / entries.size();
    const bool of_objects = layout(modality).value().of_objects;
    std::vector<bool> heard;
    for (std::size_t first = 0; first < entries.size();) {
      const auto [source, row] = place_of(entries[first], of_objects);
      std::vector<std::uint32_t> rows = {row};
      while (first + rows.size() < entries.size()) {
        const auto [next_source, next_row] = place_of(entries[first + rows.size()], of_objects);
        if (next_source != source) break;
        rows.push_back(next_row);
      }
      const std::vector<bool> some = read_own(*sources_[source], modality, rows,
                                              values.subspan(first * each, rows.size() * each));
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
  std::pair<std::size_t, std::uint32_t> place_of(std::uint32_t entry, bool of_objects) const {
    if (!of_objects) return {selected_[entry].source, selected_[entry].row};
    const auto after = std::upper_bound(first_object_.begin(), first_object_.end(), entry);
    const auto source = static_cast<std::size_t>(after - first_object_.begin()) - 1;
    return {source, entry - static_cast<std::uint32_t>(first_object_[source])};
  }

  /// Objects are numbered up to the largest that any modality has; one that this modality lacks is
  /// empty.
  static std::vector<bool> read_own(SampleSource& source, Modality modality,
                                    const std::vector<std::uint32_t>& rows,
                                    std::span<float> values) {
    const std::size_t entries = source.layout(modality).value().entries;
    const auto end =
        std::find_if(rows.begin(), rows.end(), [&](std::uint32_t row) { return row >= entries; });
    const auto there = static_cast<std::size_t>(end - rows.begin());
    const std::size_t each = values.size() / rows.size();
    std::vector<bool> heard =
        source.read(modality, std::span(rows).first(there), values.first(there * each));
    std::fill(values.begin() + static_cast<std::ptrdiff_t>(there * each), values.end(), 0.0F);
    heard.resize(rows.size(), false);
    return heard;
  }

  std::vector<SampleSource*> sources_;
  std::vector<Selection> selected_;
  std::vector<std::string> names_;
  std::string name_, content_;
  std::vector<std::size_t> first_object_;
  std::size_t objects_in_all_ = 0;
};

}  // namespace

std::unique_ptr<SampleSource> select_samples(std::vector<SampleSource*> sources,
                                             std::vector<Selection> selected,
                                             std::vector<std::string> names) {
  return std::make_unique<SelectedSource>(std::move(sources), std::move(selected),
                                          std::move(names));
}

}  // namespace carillon::eval::learning
