#include "eval/learning/dataset_source.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <utility>

#include "core/error.hpp"
#include "core/hash.hpp"
#include "core/hdf5.hpp"
#include "core/hdf5_rows.hpp"
#include "core/json.hpp"

namespace carillon::eval::learning {

namespace {

/// Where a modality lies in index.h5.
struct Column {
  std::string name;
  std::string entry_of = {};  ///< column of each sample's row in it; "": samples' own
};

/// The sounds of a dataset, with the spectrograms that it stores, else the papers'.
ClipFormat format_of(const core::Hdf5Group& file, const std::filesystem::path& folder) {
  if (!file.has("audio")) {
    throw core::InputError(fmt::format("{} has no samples", folder.string()),
                           "failures.json in it tells why none could be made");
  }
  const core::Extent audio = file.extent("audio");
  ClipFormat format = paper_format(audio.back(), file.number_attribute("sample_rate_hz"));
  if (!file.has("mel")) return format;
  const core::Extent mel = file.extent("mel");
  format.mel.bands = static_cast<int>(mel[mel.size() - 2]);
  format.mel.fft_size = static_cast<int>(file.number_attribute("fft_size", "mel"));
  format.mel.hop = static_cast<int>(file.number_attribute("hop", "mel"));
  format.mel.min_frequency = file.number_attribute("min_frequency_hz", "mel");
  format.mel.max_frequency = file.number_attribute("max_frequency_hz", "mel");
  const auto frames = static_cast<int>(mel[mel.size() - 1]);
  if (synth::signal::mel_extent(format.samples, format.mel).frames != frames) {
    format.mel.resized_frames = frames;
  }
  if (!file.attributes("mel").contains("computed_bands")) return format;  // of earlier versions
  if (const auto computed = static_cast<int>(file.number_attribute("computed_bands", "mel"));
      computed != format.mel.bands) {
    format.mel.resized_bands = std::exchange(format.mel.bands, computed);
  }
  return format;
}

class DatasetSource final : public SampleSource {
 public:
  DatasetSource(const std::filesystem::path& folder, std::size_t listener)
      : name_(folder.string()),
        file_(core::Hdf5Group::open_file(folder / "index.h5")),
        listener_(listener),
        preparer_(format_of(file_, folder)) {
    const std::filesystem::path description = folder / "dataset.json";
    const bool described = std::filesystem::exists(description);
    content_ = core::sha256_file(described ? description : folder / "index.h5");
    core::Hdf5Rows(file_, "audio").require_files();
    keys_ = file_.read<std::string>("key");
    if (described) describe(core::read_json(description));
    if (file_.has("shape_index")) objects_ = file_.read<std::uint32_t>("shape_index");
    const core::Extent audio = file_.extent("audio");
    listeners_ = audio.size() == 3 ? static_cast<std::size_t>(audio[1]) : 1;
    if (listener_ >= listeners_) {
      throw core::InputError(fmt::format("{}: there is no listener {}", name_, listener_),
                             fmt::format("it has {}, counted from 0", listeners_));
    }
  }

  const std::string& name() const override { return name_; }
  std::size_t size() const override { return keys_.size(); }
  std::vector<std::string> keys() const override { return keys_; }
  std::vector<std::string> object_names() const override {
    std::vector<std::string> names = labels("shape");
    // Simulations are of all objects that play in them, which a seed draws.
    const bool of_simulations = !file_.has("shape_index");
    for (std::size_t i = 0; i < names.size(); ++i) {
      if (of_simulations) {
        names[i].insert(0, seed_);
      } else if (!shapes_.empty()) {
        names[i] = shapes_.at(objects_[i]);
      }
    }
    return names;
  }
  std::vector<std::string> strike_names() const override {
    std::vector<std::string> names;
    if (!file_.has("strike")) {
      for (const std::string& key : keys_) names.push_back(seed_ + key);
      return names;
    }
    const std::vector<std::string> objects = object_names(), shapes = labels("shape");
    const auto strikes = file_.read<std::int64_t>("strike");
    for (std::size_t i = 0; i < keys_.size(); ++i) {
      names.push_back(fmt::format("{}{} {} {}", seed_, shapes[i], strikes[i], objects[i]));
    }
    return names;
  }
  std::string content() const override {
    return fmt::format("{} listener {}", content_, listener_);
  }

  std::optional<ClipFormat> clip_format() const override { return preparer_.format(); }

  std::vector<std::string> labels(const std::string& column) const override {
    if (file_.has(column) && !file_.is_group(column) && file_.is_text(column)) {
      return file_.read<std::string>(column);
    }
    std::vector<std::string> there;
    for (const std::string& other : file_.names()) {
      if (!file_.is_group(other) && file_.is_text(other)) there.push_back(other);
    }
    throw core::InputError(fmt::format("{}: no column of texts \"{}\"", name_, column),
                           fmt::format("there are {}", fmt::join(there, ", ")));
  }

  std::optional<ModalityLayout> layout(Modality modality) const override {
    const std::optional<Column> column = column_of(modality);
    if (!column) return std::nullopt;
    const core::Extent stored = file_.extent(column->name);
    return ModalityLayout{extent_of(modality, stored), static_cast<std::size_t>(stored[0]),
                          !column->entry_of.empty()};
  }

  std::vector<std::uint32_t> entries_of(Modality modality) const override {
    return file_.read<std::uint32_t>(column_of(modality).value().entry_of);
  }

  std::vector<bool> read(Modality modality, std::span<const std::uint32_t> entries,
                         std::span<float> values) override {
    if (entries.empty()) return {};
    const Column column = column_of(modality).value();
    const std::vector<std::uint64_t> rows(entries.begin(), entries.end());
    const auto prepare_all = [&](const auto& raw, const auto& prepare_row) {
      std::vector<bool> heard(rows.size(), true);
      const std::size_t width = raw.size() / rows.size(), each = values.size() / rows.size();
      for (std::size_t i = 0; i < rows.size(); ++i) {
        heard[i] = prepare_row(entries[i], std::span(raw).subspan(i * width, width),
                               values.subspan(i * each, each));
      }
      return heard;
    };
    if (is_of_bytes(modality)) {
      return prepare_all(raw_rows<std::uint8_t>(column, rows),
                         [&](std::size_t, std::span<const std::uint8_t> row, std::span<float> to) {
                           prepare_bytes(modality, column, row, to);
                           return true;
                         });
    }
    return prepare_all(raw_rows<float>(column, rows),
                       [&](std::size_t sample, std::span<const float> row, std::span<float> to) {
                         return prepare_named(modality, column, sample, row, to);
                       });
  }

 private:
  static bool is_of_bytes(Modality modality) {
    return modality == Modality::voxels || modality == Modality::image;
  }

  /// Rows of a column, whose files stay open.
  template <class T>
  std::vector<T> raw_rows(const Column& column, std::span<const std::uint64_t> rows) {
    auto opened = columns_.find(column.name);
    if (opened == columns_.end())
      opened = columns_.emplace(column.name, core::Hdf5Rows(file_, column.name)).first;
    std::vector<T> raw(rows.size() * opened->second.width());
    opened->second.template read<T>(rows, raw);
    return raw;
  }

  /// What a modality is made from.
  std::optional<Column> column_of(Modality modality) const {
    switch (modality) {
      case Modality::spectrogram:
        return Column{file_.has("mel") ? "mel" : "audio"};
      case Modality::waveform:
        return Column{"audio"};
      case Modality::touch:
        if (file_.has("touch")) return Column{"touch"};
        return std::nullopt;
      case Modality::voxels:
      case Modality::image:
        break;
    }
    const std::string own = modality == Modality::voxels ? "voxels" : "frames";
    if (file_.has(own)) return Column{own};
    const Column shared = modality == Modality::voxels
                              ? Column{"shapes/voxels", "shape_index"}
                              : Column{"appearances/frame", "appearance_index"};
    if (file_.has(shared.entry_of) && file_.has(shared.name)) return shared;
    return std::nullopt;
  }

  ModalityExtent extent_of(Modality modality, const core::Extent& stored) const {
    const auto side = [&](std::size_t from_last) {
      return static_cast<std::int64_t>(stored[stored.size() - from_last]);
    };
    switch (modality) {
      case Modality::spectrogram:
      case Modality::waveform:
        return preparer_.extent(modality);
      case Modality::voxels:
        return {stored.size() == 5 ? side(4) : 1, side(3), side(2), side(1)};
      case Modality::image:
        return image_extent(stored);
      case Modality::touch:
        return {3, side(2)};
    }
    return {};
  }

  /// Of objects every view, of simulations the first frame.
  ModalityExtent image_extent(const core::Extent& stored) const {
    ModalityExtent extent = {3, prepare::image_side, prepare::image_side};
    const bool has_views = !file_.has("frames") && stored[1] > 1;
    if (has_views) extent.insert(extent.begin(), static_cast<std::int64_t>(stored[1]));
    return extent;
  }

  void prepare_bytes(Modality modality, const Column& column, std::span<const std::uint8_t> row,
                     std::span<float> values) const {
    if (modality == Modality::voxels) {
      std::transform(row.begin(), row.end(), values.begin(),
                     [](std::uint8_t cell) { return cell != 0 ? 1.0F : -1.0F; });
      return;
    }
    const core::Extent stored = file_.extent(column.name);
    const std::size_t height = stored[stored.size() - 3], width = stored[stored.size() - 2];
    constexpr std::size_t prepared = 3 * prepare::image_side * prepare::image_side;
    for (std::size_t v = 0; v * prepared < values.size(); ++v) {
      prepare::image(row.subspan(v * height * width * 3, height * width * 3), height, width,
                     values.subspan(v * prepared, prepared));
    }
  }

  bool prepare_named(Modality modality, const Column& column, std::size_t sample,
                     std::span<const float> row, std::span<float> values) {
    try {
      return prepare_one(modality, column, row, values);
    } catch (const core::InputError& error) {
      throw core::InputError(
          fmt::format("{}: sample {}: {}", name_, keys_[sample], error.message()),
          "carillon check tells whether the dataset is whole");
    }
  }

  /// The part of a row that a listener hears.
  std::span<const float> heard_by_listener(std::span<const float> row) const {
    const std::size_t each = row.size() / listeners_;
    return row.subspan(listener_ * each, each);
  }

  bool prepare_one(Modality modality, const Column& column, std::span<const float> row,
                   std::span<float> values) {
    if (modality == Modality::touch) {
      prepare::touch(row, values);
      return std::any_of(values.begin(), values.end(), [](float value) { return value != 0; });
    }
    const std::span<const float> own = heard_by_listener(row);
    if (column.name == "audio") return preparer_.prepare(modality, own, values);
    std::copy(own.begin(), own.end(), values.begin());
    return prepare::spectrogram(values);
  }

  /// What other datasets may have, too: objects of the same parameters or mesh, and strikes of the
  /// same seed.
  void describe(const nlohmann::json& description) {
    seed_ = fmt::format("seed {}: ", description.at("seed").dump());
    for (const nlohmann::json& shape : description.at("shapes")) {
      const nlohmann::json& request = shape.at("request");
      shapes_.push_back(request.at("shape").dump() + shape.value("sha256", ""));
    }
  }

  std::string name_;
  core::Hdf5Group file_;
  std::map<std::string, core::Hdf5Rows> columns_;
  std::string seed_;
  std::vector<std::string> shapes_;  ///< names of objects
  std::size_t listener_;
  std::size_t listeners_ = 1;
  std::string content_;
  std::vector<std::string> keys_;
  std::vector<std::uint32_t> objects_;  ///< rows of shapes_; empty of simulations
  ClipPreparer preparer_;
};

}  // namespace

std::unique_ptr<SampleSource> open_dataset_source(const std::filesystem::path& folder,
                                                  std::size_t listener) {
  return std::make_unique<DatasetSource>(folder, listener);
}

}  // namespace carillon::eval::learning
