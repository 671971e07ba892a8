#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <span>
#include <string>
#include <vector>

#include "core/base64.hpp"
#include "core/columns.hpp"
#include "core/error.hpp"
#include "core/hdf5.hpp"
#include "core/hdf5_rows.hpp"
#include "core/image.hpp"
#include "core/json.hpp"
#include "core/numbers.hpp"
#include "dataset/stored/sample_audio.hpp"
#include "report/report.hpp"

namespace carillon::report {

using core::Hdf5Group;
using nlohmann::ordered_json;

namespace {

/// Columns that tell a listener what there is to hear, as far as a dataset has them.
constexpr const char* told[] = {"material",      "size",        "split_shape",     "impulse",
                                "contact_time",  "striker",     "support_damping", "room_size",
                                "room_response", "noise_ratio", "modes",           "pitch_error",
                                "strikes",       "peak"};
constexpr std::uint64_t largest_voxels = 64;
constexpr int largest_picture = 256;

/// A value as the column's row has it, with its unit in the name.
void add_label(const Hdf5Group& index, const std::string& column, std::uint64_t row,
               ordered_json& labels) {
  if (!index.has(column)) return;
  if (index.is_text(column)) {
    labels[column] = index.read_rows<std::string>(column, row, 1).front();
    return;
  }
  const std::string unit = index.text_attribute("unit", column);
  const std::string name = unit == "1" ? column : fmt::format("{} [{}]", column, unit);
  const auto values = index.read_rows<double>(column, row, 1);
  if (values.size() == 1) {
    labels[name] = core::number_or_null(values.front());
  } else if (values.size() <= core::longest_shown) {
    std::string text;
    for (const double value : values)
      text += fmt::format("{}{:.3g}", text.empty() ? "" : " × ", value);
    labels[name] = text;
  }
}

/// As many bytes as a picture needs at the most: every so many-th pixel of a large one.
core::Image small(core::Image image) {
  const int step = (std::max(image.width, image.height) + largest_picture - 1) / largest_picture;
  if (step <= 1) return image;
  core::Image less{image.width / step, image.height / step, image.channels, {}};
  for (int y = 0; y < less.height; ++y) {
    for (int x = 0; x < less.width; ++x) {
      const auto from =
          static_cast<std::ptrdiff_t>((y * step * image.width + x * step) * image.channels);
      less.pixels.insert(less.pixels.end(), image.pixels.begin() + from,
                         image.pixels.begin() + from + image.channels);
    }
  }
  return less;
}

std::string picture(std::span<const std::uint8_t> pixels, std::uint64_t height,
                    std::uint64_t width) {
  const core::Image image{
      static_cast<int>(width), static_cast<int>(height), 3, {pixels.begin(), pixels.end()}};
  return core::base64(core::png_bytes("frame", small(image)));
}

/// The object's frame in its material, its first view, or of a simulation the one in the middle of
/// its movie.
void add_picture(const Hdf5Group& index, std::uint64_t row, ordered_json& sample) {
  if (index.has("frames")) {
    const core::Extent extent = index.extent("frames");
    const auto all = index.read_rows<std::uint8_t>("frames", row, 1);
    const std::size_t size = extent[2] * extent[3] * 3;
    sample["picture"] =
        picture(std::span(all).subspan(extent[1] / 2 * size, size), extent[2], extent[3]);
    return;
  }
  const std::string path = "appearances/frame";
  if (!index.has(path) || !index.has("appearance_index")) return;
  const auto own = index.read_rows<std::uint64_t>("appearance_index", row, 1).front();
  const core::Extent extent = index.extent(path);
  const auto views = index.read_rows<std::uint8_t>(path, own, 1);
  sample["picture"] =
      picture(std::span(views).first(extent[2] * extent[3] * 3), extent[2], extent[3]);
}

/// Cells as bits, the first one the highest of its byte.
void add_voxels(const Hdf5Group& index, std::uint64_t row, ordered_json& sample) {
  if (index.has("frames") || !index.has("shapes/voxels")) return;
  const std::uint64_t resolution = index.extent("shapes/voxels").back();
  if (resolution > largest_voxels) return;
  const auto shape = index.read_rows<std::uint64_t>("shape_index", row, 1).front();
  const auto cells = index.read_rows<std::uint8_t>("shapes/voxels", shape, 1);
  const std::uint64_t count = resolution * resolution * resolution;  // of the first of its copies
  std::string bits((count + 7) / 8, '\0');
  for (std::size_t i = 0; i < count; ++i) {
    if (cells[i] != 0) bits[i / 8] = static_cast<char>(bits[i / 8] | (0x80 >> (i % 8)));
  }
  sample["voxels"] = {{"resolution", resolution}, {"cells", core::base64(bits)}};
}

/// The first two listeners, and the beginning, as far as it fits into `bytes` of base64.
core::AudioClip beginning(const core::AudioClip& whole, std::size_t bytes, ordered_json& labels) {
  constexpr std::size_t header = 44;
  const auto channels = static_cast<std::size_t>(whole.channels);
  const std::size_t heard = std::min<std::size_t>(channels, 2);
  const std::size_t all = whole.samples.size() / channels;
  const std::size_t room = bytes / 4 * 3;
  const std::size_t frames =
      std::min(all, (room - std::min(room, header)) / (heard * sizeof(std::int16_t)));
  core::AudioClip clip{{}, static_cast<int>(heard), whole.sample_rate};
  for (std::size_t i = 0; i < frames; ++i) {
    const auto frame = whole.samples.begin() + static_cast<std::ptrdiff_t>(i * channels);
    clip.samples.insert(clip.samples.end(), frame, frame + static_cast<std::ptrdiff_t>(heard));
  }
  if (heard < channels) labels["listeners"] = fmt::format("2 of {}", channels);
  if (frames < all) {
    labels["beginning [s]"] =
        fmt::format("{:.3g} of {:.3g}", static_cast<double>(frames) / clip.sample_rate,
                    static_cast<double>(all) / clip.sample_rate);
  }
  return clip;
}

/// The clip with its peak at half of full scale, so that every one can be heard.
void add_audio(const dataset::stored::SampleAudio& audio, std::uint64_t row, std::size_t bytes,
               ordered_json& sample) {
  core::AudioClip clip = beginning(audio.read(row, 1).front(), bytes, sample["labels"]);
  const auto peak = static_cast<float>(core::peak(clip.samples));
  if (peak > 0) {
    for (float& value : clip.samples) value *= 0.5F / peak;
    sample["labels"]["played at [dB]"] = core::amplitude_decibels(0.5 / static_cast<double>(peak));
  }
  sample["sample_rate_hz"] = clip.sample_rate;
  sample["channels"] = clip.channels;
  sample["audio"] = core::base64(core::wav_bytes("audio", clip, core::SampleFormat::int16));
}

ordered_json heard(const Hdf5Group& index, const dataset::stored::SampleAudio& audio,
                   std::uint64_t row, std::size_t bytes) {
  ordered_json sample = {{"key", index.read_rows<std::string>("key", row, 1).front()},
                         {"object", index.read_rows<std::string>("shape", row, 1).front()},
                         {"labels", ordered_json::object()}};
  for (const char* column : told) add_label(index, column, row, sample["labels"]);
  try {
    add_picture(index, row, sample);
    add_voxels(index, row, sample);
  } catch (const core::FileError&) {
    // An object's file is lost, which the gallery says; its sounds are there.
  }
  const std::size_t used = sample.dump().size();
  add_audio(audio, row, bytes - std::min(bytes, used), sample);
  return sample;
}

/// Files of samples, relative to the folder: those of the tasks that ended last, the newest first.
std::vector<std::string> newest_shards(const std::filesystem::path& folder, std::size_t count) {
  constexpr std::streamoff tail = 1 << 20;
  std::ifstream journal(folder / "journal.jsonl", std::ios::ate);
  journal.seekg(std::max<std::streamoff>(0, journal.tellg() - tail));
  std::vector<std::string> shards;
  for (std::string line; std::getline(journal, line);) {
    const auto entry = nlohmann::json::parse(line, nullptr, /*allow_exceptions=*/false);
    if (!entry.is_object() || !entry.value("ok", false)) continue;
    const std::string task = entry.value("task", "");
    if (!task.starts_with("samples/")) continue;
    const std::string shard = "samples/" + std::filesystem::path(task).filename().string() + ".h5";
    std::erase(shards, shard);
    shards.push_back(shard);
  }
  std::reverse(shards.begin(), shards.end());
  shards.resize(std::min(shards.size(), count));
  return shards;
}

/// The object's frame in its material, from its modes file: an index may not have it yet.
void add_picture_of_modes(const std::filesystem::path& folder, ordered_json& sample) {
  const std::filesystem::path object(sample.at("object").get<std::string>());
  const std::filesystem::path path = folder / "modes" / (object.filename().string() + ".h5");
  if (sample.contains("picture") || !std::filesystem::is_regular_file(path)) return;
  const Hdf5Group modes = Hdf5Group::open_file(path);
  const std::string frames = "appearances/frame";
  if (!modes.has(frames)) return;
  const auto materials = modes.read<std::string>("appearances/material");
  const auto own = std::find(materials.begin(), materials.end(), sample["labels"]["material"]);
  if (own == materials.end()) return;
  const core::Extent extent = modes.extent(frames);
  const auto views =
      modes.read_rows<std::uint8_t>(frames, static_cast<std::uint64_t>(own - materials.begin()), 1);
  sample["picture"] =
      picture(std::span(views).first(extent[2] * extent[3] * 3), extent[2], extent[3]);
}

}  // namespace

void require_shards(const std::filesystem::path& folder) {
  const std::filesystem::path path = folder / "index.h5";
  if (!std::filesystem::is_regular_file(path)) return;
  const Hdf5Group index = Hdf5Group::open_file(path);
  if (index.has("id")) core::Hdf5Rows(index, "id").require_files();
}

ordered_json heard_samples(const std::filesystem::path& folder, ReportShare share) {
  ordered_json samples = ordered_json::array();
  const std::filesystem::path path = folder / "index.h5";
  if (share.count == 0 || !std::filesystem::is_regular_file(path)) return samples;
  const Hdf5Group index = Hdf5Group::open_file(path);
  if (!index.has("key")) return samples;
  const dataset::stored::SampleAudio audio(index);
  const std::uint64_t rows = index.extent("key").front();
  const std::uint64_t count = std::min<std::uint64_t>(share.count, rows);
  const auto ids = index.read<std::uint64_t>("id");
  for (std::uint64_t i = 0; i < count; ++i) {
    // Of as many equal stretches; within one by the ids, which are random and always the same.
    const auto place = [&](std::uint64_t k) {
      return ids.begin() + static_cast<std::ptrdiff_t>(k * rows / count);
    };
    const auto row = std::min_element(place(i), place(i + 1)) - ids.begin();
    samples.push_back(
        heard(index, audio, static_cast<std::uint64_t>(row), share.bytes / (count - i)));
    share.bytes -= std::min(share.bytes, samples.back().dump().size());
  }
  return samples;
}

ordered_json newest_samples(const std::filesystem::path& folder, ReportShare share) {
  ordered_json samples = ordered_json::array();
  const std::vector<std::string> shards = newest_shards(folder, share.count);
  for (std::size_t s = 0; s < shards.size(); ++s) {
    const std::size_t wanted = (share.count - samples.size()) / (shards.size() - s);
    try {
      const Hdf5Group shard = Hdf5Group::open_file(folder / shards[s]);
      const dataset::stored::SampleAudio audio(shard);
      const std::uint64_t rows = shard.extent("key").front();
      for (std::uint64_t i = 0; i < std::min<std::uint64_t>(wanted, rows); ++i) {
        ordered_json sample = heard(shard, audio, rows - 1 - i, share.bytes / share.count);
        add_picture_of_modes(folder, sample);
        samples.push_back(std::move(sample));
      }
    } catch (const core::Error&) {
      // It is being made anew, or was deleted: the others can be heard.
    }
  }
  return samples;
}

}  // namespace carillon::report
