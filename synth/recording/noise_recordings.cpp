#include "synth/recording/noise_recordings.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "core/audio.hpp"
#include "core/error.hpp"
#include "synth/recording/recording_file.hpp"
#include "synth/signal/cross_fade.hpp"
#include "synth/signal/resample.hpp"

namespace carillon::synth::recording {

namespace {

constexpr double fade_time = 0.02;       // [s]
constexpr double shortest_run = 0.001;   // [s]
constexpr double min_sound = 0.1;        // [s] of audio that a part must have
constexpr std::size_t named_files = 20;  // in an error

/// A run of a recording that belongs to one part.
struct Piece {
  std::size_t recording = 0;
  Run run;
  double seconds = 0;
  std::size_t within = 0;  ///< number among the recording's pieces
};

/// The pieces of each part, and which of them belong to each recording.
struct Division {
  bool by_file = true;
  std::vector<std::vector<Piece>> parts;
  std::vector<std::vector<Run>> of_recording;
  std::vector<double> seconds;  ///< of each part
};

struct Loaded {
  std::vector<std::vector<float>> pieces;  ///< resampled, at the common level
  std::size_t bytes = 0;
  std::uint64_t used = 0;
};

std::uint64_t number_of(const std::string& hash) {
  return std::stoull(hash.substr(0, 16), nullptr, 16);
}

void add_piece(Division& division, std::size_t part, std::size_t recording, Run run,
               double sample_rate) {
  const double seconds = static_cast<double>(run.size()) / sample_rate;
  if (seconds < shortest_run) return;
  auto& runs = division.of_recording[recording];
  division.parts[part].push_back({recording, run, seconds, runs.size()});
  division.seconds[part] += seconds;
  runs.push_back(run);
}

bool all_have_sound(const Division& division) {
  return std::all_of(division.seconds.begin(), division.seconds.end(),
                     [](double seconds) { return seconds >= min_sound; });
}

}  // namespace

void check_noise_folder(const std::filesystem::path& folder, std::size_t parts) {
  if (!std::filesystem::is_directory(folder)) {
    throw core::InputError(fmt::format("{} is no folder", folder.string()),
                           "paths are meant from where the configuration lies");
  }
  double seconds = 0;
  std::size_t readable = 0;
  std::string unreadable;
  const auto files = files_in_folder(folder);
  for (const auto& name : files) {
    try {
      seconds += core::read_audio_header(folder / name).seconds;
      ++readable;
    } catch (const core::FileError& error) {
      if (unreadable.empty()) unreadable = error.message();
    }
  }
  const std::string remedy = "any format that libsndfile reads (WAV, FLAC, Ogg ...) will do";
  if (files.empty()) {
    throw core::InputError(fmt::format("{}: the folder has no files", folder.string()), remedy);
  }
  if (readable == 0) {
    throw core::InputError(fmt::format("{}: none of {} files can be used as noise; the first: {}",
                                       folder.string(), files.size(), unreadable),
                           remedy);
  }
  if (seconds < min_sound * static_cast<double>(parts)) {
    throw core::InputError(
        fmt::format("{}: {:.3g} s in {} recordings are less than {} s for each of {} parts that "
                    "share no noise",
                    folder.string(), seconds, readable, min_sound, parts),
        "add recordings, or longer ones");
  }
}

struct NoiseFolder::Impl {
  std::filesystem::path folder;
  RecordingOptions options;
  std::vector<Recording> recordings;
  std::vector<std::vector<Run>> runs;  ///< what is audible in each
  std::vector<std::string> left_out;
  std::map<std::size_t, Division> divisions;  ///< by the number of parts

  std::vector<std::optional<Loaded>> loaded;
  std::size_t loaded_parts = 0;  ///< the division that `loaded` belongs to
  std::size_t bytes = 0;
  std::uint64_t uses = 0;

  void add(const std::filesystem::path& name, std::map<std::string, std::string>& contents) {
    MonoRecording mono;
    try {
      mono = read_mono(folder / name, options.channel);
    } catch (const core::InputError& error) {
      left_out.push_back(fmt::format("{}: {}", name.generic_string(), error.message()));
      return;
    } catch (const core::FileError& error) {
      // The message begins with the whole path; the list has one folder for all.
      std::string reason = error.message();
      const std::string path = (folder / name).string() + ": ";
      if (reason.starts_with(path)) reason.erase(0, path.size());
      left_out.push_back(fmt::format("{}: {}", name.generic_string(), reason));
      return;
    }
    const std::vector<Run> audible = audible_runs(mono.samples, mono.sample_rate);
    if (audible.empty()) {
      left_out.push_back(fmt::format("{}: silent (nothing above -100 dB of full scale{})",
                                     name.generic_string(),
                                     options.channel == 0 ? " in the mean of its channels" : ""));
      return;
    }
    Recording recording;
    recording.name = name.generic_string();
    recording.content = content_hash(mono);
    const auto [first, is_new] = contents.emplace(recording.content, recording.name);
    if (!is_new) {
      left_out.push_back(fmt::format("{}: the same as {}", recording.name, first->second));
      return;
    }
    recording.sample_rate = mono.sample_rate;
    recording.frames = mono.samples.size();
    double sum = 0;
    std::size_t count = 0;
    for (const Run& run : audible) {
      for (std::size_t i = run.begin; i < run.end; ++i) {
        sum += static_cast<double>(mono.samples[i]) * mono.samples[i];
      }
      count += run.size();
    }
    recording.rms = std::sqrt(sum / static_cast<double>(count));
    recording.audible_seconds = static_cast<double>(count) / mono.sample_rate;
    recordings.push_back(std::move(recording));
    runs.push_back(audible);
  }

  Division divide(std::size_t parts, bool by_file) const {
    Division division;
    division.by_file = by_file;
    division.parts.resize(parts);
    division.seconds.assign(parts, 0.0);
    division.of_recording.resize(recordings.size());
    for (std::size_t r = 0; r < recordings.size(); ++r) {
      const Recording& recording = recordings[r];
      if (by_file) {
        const std::size_t part = number_of(recording.content) % parts;
        for (const Run& run : runs[r]) {
          add_piece(division, part, r, run, recording.sample_rate);
        }
        continue;
      }
      const auto border = [&](std::size_t part) {
        return static_cast<std::size_t>(static_cast<double>(recording.frames) *
                                        static_cast<double>(part) / static_cast<double>(parts));
      };
      for (std::size_t part = 0; part < parts; ++part) {
        for (const Run& run : runs[r]) {
          const Run cut{std::max(run.begin, border(part)), std::min(run.end, border(part + 1))};
          if (cut.begin < cut.end) add_piece(division, part, r, cut, recording.sample_rate);
        }
      }
    }
    return division;
  }

  const Division& division(std::size_t parts) {
    if (parts == 0) throw core::InputError("noise for 0 parts of a data set");
    const auto known = divisions.find(parts);
    if (known != divisions.end()) return known->second;
    Division division = divide(parts, true);
    if (!all_have_sound(division)) division = divide(parts, false);
    if (!all_have_sound(division)) {
      const double minimum = *std::min_element(division.seconds.begin(), division.seconds.end());
      throw core::InputError(
          fmt::format("{}: {} recordings leave {:.3g} s for one of {} parts that share no noise; "
                      "{} s is the least",
                      folder.string(), recordings.size(), minimum, parts, min_sound),
          "add recordings, or longer ones");
    }
    return divisions.emplace(parts, std::move(division)).first->second;
  }

  /// Resampled pieces of a recording; read again when they were let go.
  const Loaded& load(const Division& division, std::size_t parts, std::size_t recording) {
    if (loaded_parts != parts) {
      loaded.assign(recordings.size(), std::nullopt);
      loaded_parts = parts;
      bytes = 0;
    }
    std::optional<Loaded>& entry = loaded[recording];
    if (!entry) {
      const Recording& known = recordings[recording];
      const MonoRecording mono = read_mono(folder / known.name, options.channel);
      if (content_hash(mono) != known.content) {
        throw core::InputError(
            fmt::format("{} changed while it was in use", (folder / known.name).string()),
            "recordings must stay as they are until the build has ended");
      }
      entry.emplace();
      // Each piece by itself, so that no sample of one part reaches another through the filter.
      for (const Run& run : division.of_recording[recording]) {
        std::vector<double> level(run.size());
        for (std::size_t i = 0; i < level.size(); ++i) {
          level[i] = mono.samples[run.begin + i] / known.rms;
        }
        const auto made = signal::resample(level, known.sample_rate, options.sample_rate);
        entry->pieces.emplace_back(made.begin(), made.end());
        entry->bytes += made.size() * sizeof(float);
      }
      bytes += entry->bytes;
    }
    entry->used = ++uses;
    let_go(recording);
    return *entry;
  }

  /// Those that were not used for longest, until the rest fits; never `keep`.
  void let_go(std::size_t keep) {
    while (bytes > options.memory) {
      std::optional<Loaded>* oldest = nullptr;
      for (std::size_t r = 0; r < loaded.size(); ++r) {
        if (r == keep || !loaded[r]) continue;
        if (oldest == nullptr || loaded[r]->used < (*oldest)->used) oldest = &loaded[r];
      }
      if (oldest == nullptr) return;
      bytes -= (*oldest)->bytes;
      oldest->reset();
    }
  }
};

NoiseFolder::NoiseFolder(const std::filesystem::path& folder, const RecordingOptions& options)
    : impl_(std::make_unique<Impl>()) {
  impl_->folder = folder;
  impl_->options = options;
  if (options.channel < 0) {
    throw core::InputError(fmt::format("noise of channel {}", options.channel),
                           "channels count from 1; 0 is the mean of all");
  }
  std::map<std::string, std::string> contents;
  for (const auto& name : files_in_folder(folder)) impl_->add(name, contents);
  if (impl_->recordings.empty()) {
    const auto& all = impl_->left_out;
    const std::size_t named = std::min(all.size(), named_files);
    std::string list;
    for (std::size_t i = 0; i < named; ++i) list += "\n  " + all[i];
    if (named < all.size()) list += fmt::format("\n  and {} more", all.size() - named);
    throw core::InputError(all.empty() ? fmt::format("{}: the folder has no files", folder.string())
                                       : fmt::format("{}: none of {} files can be used as noise:{}",
                                                     folder.string(), all.size(), list),
                           "any format that libsndfile reads (WAV, FLAC, Ogg ...) will do");
  }
}

NoiseFolder::~NoiseFolder() = default;
NoiseFolder::NoiseFolder(NoiseFolder&&) noexcept = default;

const std::vector<Recording>& NoiseFolder::recordings() const {
  return impl_->recordings;
}

const std::vector<std::string>& NoiseFolder::left_out() const {
  return impl_->left_out;
}

NoiseDraw NoiseFolder::draw(std::size_t count, std::size_t part, std::size_t parts,
                            core::RandomStream& random) {
  const Division& division = impl_->division(parts);
  if (part >= parts) throw core::InputError(fmt::format("noise of part {} of {}", part, parts));
  const std::vector<Piece>& pieces = division.parts[part];
  const double rate = impl_->options.sample_rate;
  NoiseDraw draw;
  draw.samples.reserve(count);
  std::size_t last_length = 0;
  while (draw.samples.size() < count) {
    double place = random.uniform() * division.seconds[part];
    auto piece = pieces.begin();
    while (place >= piece->seconds && piece + 1 != pieces.end()) place -= (piece++)->seconds;
    const Loaded& loaded = impl_->load(division, parts, piece->recording);
    const std::span<const float> sound = loaded.pieces[piece->within];
    if (sound.empty()) continue;

    const bool first = draw.samples.empty();
    const std::size_t fade = first ? 0
                                   : std::min({static_cast<std::size_t>(fade_time * rate),
                                               sound.size() / 4, last_length / 2});
    const std::size_t wanted = count - draw.samples.size() + fade;
    // A short one never comes twice in the same length, which would be heard as a pitch.
    const std::size_t minimum = sound.size() - sound.size() / 2;
    const std::size_t length =
        sound.size() >= wanted ? wanted : minimum + random.index(sound.size() - minimum + 1);
    const std::size_t start = random.index(sound.size() - length + 1);
    signal::append_cross_faded(draw.samples, sound.subspan(start, length), fade);
    last_length = length;
    const Recording& recording = impl_->recordings[piece->recording];
    draw.segments.push_back({recording.name,
                             static_cast<double>(piece->run.begin) / recording.sample_rate +
                                 static_cast<double>(start) / rate,
                             static_cast<double>(length) / rate});
  }
  return draw;
}

}  // namespace carillon::synth::recording
