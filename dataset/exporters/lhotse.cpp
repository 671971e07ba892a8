#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <functional>
#include <numeric>
#include <span>

#include "core/error.hpp"
#include "core/files.hpp"
#include "dataset/exporters/export.hpp"
#include "dataset/stored/sample_audio.hpp"

namespace carillon::dataset::exporters {

using nlohmann::ordered_json;

namespace {

/// What all recordings of a dataset have in common.
struct RecordingFormat {
  int sample_rate = 0;
  std::uint64_t samples = 0;  ///< of each channel
  std::vector<std::size_t> channels;
  double seconds() const { return static_cast<double>(samples) / sample_rate; }
};

RecordingFormat recording_format(const core::Hdf5Group& index) {
  const stored::SampleAudio audio(index);
  RecordingFormat format{audio.sample_rate(), index.extent("audio").back(), {}};
  format.channels.resize(audio.listeners());
  std::iota(format.channels.begin(), format.channels.end(), std::size_t{0});
  return format;
}

/// A line of a RecordingSet.
ordered_json recording(const ExportedRows& rows, std::size_t row, const RecordingFormat& format) {
  const ordered_json source = {
      {"type", "file"}, {"channels", format.channels}, {"source", sound_path(rows, row)}};
  return {{"id", rows.key(row)},
          {"sources", ordered_json::array({source})},
          {"sampling_rate", format.sample_rate},
          {"num_samples", format.samples},
          {"duration", format.seconds()},
          {"channel_ids", format.channels}};
}

/// A line of a SupervisionSet. @param custom  not null
ordered_json supervision(const std::string& id, const std::string& recording_id, double start,
                         double duration, const std::string& text, ordered_json custom,
                         const RecordingFormat& format) {
  // One channel is a number, several are a list.
  const ordered_json channel =
      format.channels.size() == 1 ? ordered_json(0) : ordered_json(format.channels);
  return {{"id", id},
          {"recording_id", recording_id},
          {"start", start},
          {"duration", duration},
          {"channel", channel},
          {"text", text},
          {"custom", std::move(custom)}};
}

/// One event for a clip of one strike: it lasts as long as the clip, and has the clip's labels.
void write_clips(const Export& task, std::span<const std::size_t> rows,
                 const RecordingFormat& format, std::ostream& file) {
  LabelStream labels(task.rows, rows);
  for (const std::size_t row : rows) {
    ordered_json custom = labels.next();
    const std::string text =
        fmt::format("{} of {}", custom.value("shape", ""), custom.value("material", ""));
    const std::string& key = task.rows.key(row);
    file << supervision(key, key, 0.0, format.seconds(), text, std::move(custom), format).dump()
         << '\n';
  }
}

/// A body as the text of an event names it: "ball of glass"; a stylus has no material.
std::string body_text(const ordered_json& body) {
  const std::string name = body.value("name", "");
  return body.contains("material") ? name + " of " + body["material"].get<std::string>() : name;
}

/// The events of one simulation: its stored strikes, each as long as its contact.
void write_strikes(const Export& task, std::size_t row, const RecordingFormat& format,
                   std::ostream& file) {
  const core::Hdf5Group& index = task.index;
  const auto numbers = [&](const char* name) { return index.read_rows<double>(name, row, 1); };
  const ordered_json bodies =
      ordered_json::parse(index.read_rows<std::string>("bodies", row, 1).front());
  const auto pairs = index.read_rows<std::int64_t>("strike_bodies", row, 1);
  const auto times = numbers("strike_time"), durations = numbers("strike_duration"),
             speeds = numbers("strike_speed"), impulses = numbers("strike_impulse"),
             points = numbers("strike_point");
  const double shift = index.has("recording_shift") ? numbers("recording_shift").front() : 0.0;
  const double least = 1.0 / format.sample_rate;  // Lhotse refuses events that last no time
  const std::string& key = task.rows.key(row);
  for (std::size_t k = 0; k < times.size() && std::isfinite(times[k]); ++k) {
    const double start = times[k] + shift, left = format.seconds() - start;
    if (left < least) break;
    const double duration = std::fmin(std::fmax(durations[k], least), left);
    const auto vector = [&](const std::vector<double>& all) {
      return std::vector<double>(all.begin() + static_cast<std::ptrdiff_t>(3 * k),
                                 all.begin() + static_cast<std::ptrdiff_t>(3 * k + 3));
    };
    ordered_json custom = {{"strike", k},
                           {"bodies", ordered_json::array()},
                           {"shapes", ordered_json::array()},
                           {"materials", ordered_json::array()},
                           {"speed", speeds[k]},
                           {"impulse", vector(impulses)},
                           {"point", vector(points)}};
    std::string text;
    for (std::size_t side = 0; side < 2; ++side) {
      const ordered_json& body = bodies.at(static_cast<std::size_t>(pairs[2 * k + side]));
      custom["bodies"].push_back(body.value("name", ""));
      custom["shapes"].push_back(body.value("shape", ordered_json()));
      custom["materials"].push_back(body.value("material", ordered_json()));
      text += (side == 0 ? "" : " on ") + body_text(body);
    }
    file << supervision(fmt::format("{}-{:04}", key, k), key, start, duration, text,
                        std::move(custom), format)
                .dump()
         << '\n';
  }
}

/// A file of one JSON object a line.
ExportedFile write_manifest(const Export& task, const std::string& name,
                            const std::function<void(std::ostream&)>& write) {
  core::write_durably(task.output / name, [&](const std::filesystem::path& path) {
    std::ofstream file(path, std::ios::binary);
    write(file);
    file.close();
    if (!file) throw core::FileError(fmt::format("{}: cannot be written", path.string()));
  });
  return exported_file(task.output, name);
}

}  // namespace

std::vector<ExportedFile> write_lhotse(const Export& task) {
  std::vector<ExportedFile> files = write_audio_folder(task);
  if (task.rank != 0) return files;
  const RecordingFormat format = recording_format(task.index);
  const bool simulations = task.index.has("strike_time");
  for (const auto& [part, members] : task.rows.by_part()) {
    const std::span<const std::size_t> rows = members;
    files.push_back(
        write_manifest(task, fmt::format("recordings_{}.jsonl", part), [&](std::ostream& file) {
          for (const std::size_t row : rows) {
            file << recording(task.rows, row, format).dump() << '\n';
          }
        }));
    files.push_back(
        write_manifest(task, fmt::format("supervisions_{}.jsonl", part), [&](std::ostream& file) {
          if (!simulations) return write_clips(task, rows, format, file);
          for (const std::size_t row : rows) write_strikes(task, row, format, file);
        }));
  }
  return files;
}

}  // namespace carillon::dataset::exporters
