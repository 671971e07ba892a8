#include "synth/room/measured_responses.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <numeric>

#include "core/audio.hpp"
#include "core/error.hpp"
#include "core/hash.hpp"
#include "synth/recording/recording_file.hpp"
#include "synth/signal/resample.hpp"

namespace carillon::synth::room {

namespace fs = std::filesystem;

namespace {

constexpr double onset_fraction = 0.1;      // -20 dB of the largest magnitude
constexpr double unheard_fraction = 1e-5;   // of the energy
constexpr double resampler_seconds = 0.01;  // about the length of the resampler's filter
constexpr double shortest_lead = 64;        // samples before the onset that the filter has
constexpr double lowest_file_rate = 1e3;
constexpr double highest_file_rate = 1e6;
constexpr std::size_t named_at_most = 20;  // files in an error

std::size_t onset_of(std::span<const double> samples, double peak) {
  const auto first = std::find_if(samples.begin(), samples.end(), [&](double value) {
    return std::abs(value) >= onset_fraction * peak;
  });
  return static_cast<std::size_t>(first - samples.begin());
}

double energy_of(std::span<const double> samples) {
  return std::inner_product(samples.begin(), samples.end(), samples.begin(), 0.0);
}

std::size_t largest_at(std::span<const double> samples) {
  const auto largest = std::max_element(
      samples.begin(), samples.end(), [](double a, double b) { return std::abs(a) < std::abs(b); });
  return static_cast<std::size_t>(largest - samples.begin());
}

/// Samples before the onset, so many that the onset stays on a sample at the other rate.
std::size_t lead_of(double from, double to) {
  const auto period = static_cast<double>(std::llround(from)) /
                      static_cast<double>(std::gcd(std::llround(from), std::llround(to)));
  return static_cast<std::size_t>(period * std::ceil(shortest_lead / period));
}

/// The part that a clip hears, at the clips' rate, from the onset on.
std::vector<double> resampled(std::span<const double> samples, std::size_t onset, double rate,
                              const MeasuredOptions& options) {
  const std::size_t lead = lead_of(rate, options.sample_rate);
  const double heard = static_cast<double>(options.count) / options.sample_rate + resampler_seconds;
  const auto length = static_cast<std::size_t>(std::ceil(heard * rate));
  const auto rest = samples.subspan(onset, std::min(length, samples.size() - onset));
  const std::size_t before = std::min(lead, onset);
  // Silence where there is nothing, for the filter to ring in.
  std::vector<double> padded(lead - before, 0.0);
  padded.insert(padded.end(), samples.begin() + static_cast<std::ptrdiff_t>(onset - before),
                samples.begin() + static_cast<std::ptrdiff_t>(onset + rest.size()));
  padded.insert(padded.end(), lead + static_cast<std::size_t>(std::ceil(resampler_seconds * rate)),
                0.0);
  const std::vector<double> made = signal::resample(padded, rate, options.sample_rate);
  const double kept = energy_of(made) / options.sample_rate;
  if (!(kept > unheard_fraction * energy_of(padded) / rate)) {
    throw core::InputError(fmt::format("nothing of it is below {:g} Hz, half of the clips' rate",
                                       options.sample_rate / 2));
  }
  const std::size_t begin = onset_of(made, std::abs(made[largest_at(made)]));
  return {made.begin() + static_cast<std::ptrdiff_t>(begin), made.end()};
}

/// One channel of a file, and what can be seen of all of it.
struct ResponseFile {
  std::vector<std::vector<double>> channels;
  std::vector<int> numbers;  ///< from 1
  double rate = 0;           ///< [Hz]
  std::string content;
};

ResponseFile read_file(const fs::path& path, int channel) {
  const core::AudioClip clip = core::read_audio(path);
  ResponseFile file;
  file.rate = clip.sample_rate;
  if (!(file.rate >= lowest_file_rate && file.rate <= highest_file_rate)) {
    throw core::InputError(fmt::format("a rate of {} Hz, not between 1 kHz and 1 MHz", file.rate));
  }
  if (channel > clip.channels) {
    throw core::InputError(fmt::format("no channel {}: it has {}", channel, clip.channels));
  }
  const auto width = static_cast<std::size_t>(clip.channels);
  core::Sha256 hash;
  hash.add(std::span<const double>(&file.rate, 1));
  for (int c = 1; c <= clip.channels; ++c) {
    if (channel > 0 && c != channel) continue;
    std::vector<float> one;
    for (auto i = static_cast<std::size_t>(c - 1); i < clip.samples.size(); i += width) {
      one.push_back(clip.samples[i]);
    }
    hash.add(std::span<const float>(one));
    file.channels.emplace_back(one.begin(), one.end());
    file.numbers.push_back(c);
  }
  file.content = hash.hex();
  return file;
}

std::vector<fs::path> files_at(const fs::path& path) {
  if (fs::is_directory(path)) return recording::files_in_folder(path);
  return {path.filename()};
}

fs::path folder_of(const fs::path& path) {
  return fs::is_directory(path) ? path : path.parent_path();
}

/// The message of an error without the path that it begins with.
std::string reason_of(const core::Error& error, const fs::path& path) {
  std::string reason = error.message();
  const std::string begin = path.string() + ": ";
  if (reason.starts_with(begin)) reason.erase(0, begin.size());
  return reason;
}

/// "-1 2 ..." of everything that a reading depends on, but for what the files hold.
std::string key_of(const fs::path& path, const MeasuredOptions& options) {
  std::string key = fmt::format("{}\n{:a} {} {} {}\n", path.string(), options.sample_rate,
                                options.count, options.channel, options.parts);
  for (const fs::path& name : files_at(path)) {
    std::error_code ignored;
    const fs::path file = folder_of(path) / name;
    key += fmt::format("{} {} {}\n", name.generic_string(), fs::file_size(file, ignored),
                       fs::last_write_time(file, ignored).time_since_epoch().count());
  }
  return key;
}

}  // namespace

std::vector<float> from_direct_sound(std::span<const double> samples, double rate,
                                     const MeasuredOptions& options) {
  const auto wrong = std::find_if(samples.begin(), samples.end(),
                                  [](double value) { return !std::isfinite(value); });
  if (wrong != samples.end()) {
    throw core::InputError(
        fmt::format("sample {} is not a finite number", wrong - samples.begin()));
  }
  if (samples.empty()) throw core::InputError("it has no samples");
  const std::size_t largest = largest_at(samples);
  const double peak = std::abs(samples[largest]);
  if (!(peak > 0)) throw core::InputError("silent: no sample is other than 0");
  const auto end = static_cast<std::size_t>(std::ceil(direct_seconds * rate));
  if (largest >= end && samples.size() - largest <= end) {
    throw core::InputError(
        fmt::format("it is loudest at its end, {:.4g} of {:.4g} s: no response begins there",
                    static_cast<double>(largest) / rate,
                    static_cast<double>(samples.size()) / rate),
        "is it reversed, or does it end in a click?");
  }
  const std::size_t onset = onset_of(samples, peak);
  std::vector<double> heard =
      rate == options.sample_rate
          ? std::vector<double>(samples.begin() + static_cast<std::ptrdiff_t>(onset), samples.end())
          : resampled(samples, onset, rate, options);
  heard.resize(std::min(heard.size(), std::max<std::size_t>(1, options.count)));
  const auto direct = static_cast<std::size_t>(std::ceil(direct_seconds * options.sample_rate));
  const double scale =
      1 / std::sqrt(energy_of(std::span(heard).first(std::min(direct, heard.size()))));
  std::vector<float> made(heard.size());
  std::transform(heard.begin(), heard.end(), made.begin(),
                 [&](double value) { return static_cast<float>(scale * value); });
  return made;
}

void MeasuredResponses::read(const fs::path& folder, const fs::path& name,
                             const MeasuredOptions& options) {
  const ResponseFile file = read_file(folder / name, options.channel);
  File entry{file.content, responses_.size(), file.channels.size()};
  const auto same = std::find_if(files_.begin(), files_.end(),
                                 [&](const File& other) { return other.content == entry.content; });
  if (same != files_.end()) {
    left_out_.push_back(
        fmt::format("{}: the same as {}", name.generic_string(), responses_[same->first].name));
    return;
  }
  std::vector<MeasuredResponse> made;
  for (std::size_t c = 0; c < file.channels.size(); ++c) {
    try {
      made.push_back({name.generic_string(), file.numbers[c],
                      from_direct_sound(file.channels[c], file.rate, options)});
    } catch (const core::InputError& error) {
      const std::string of_channel =
          file.channels.size() > 1 ? fmt::format("channel {}: ", file.numbers[c]) : "";
      throw core::InputError(of_channel + error.message(), error.hint());
    }
  }
  responses_.insert(responses_.end(), made.begin(), made.end());
  files_.push_back(entry);
}

void MeasuredResponses::divide(const std::string& folder, std::size_t parts) {
  if (files_.size() < parts) {
    throw core::InputError(
        fmt::format("{}: {} {} for {} parts of the dataset, which share no response", folder,
                    files_.size(), files_.size() == 1 ? "response" : "different responses", parts),
        "add responses, hold out less (split), or name one file, which all parts then share");
  }
  const auto number = [&](std::size_t f) {
    return std::stoull(files_[f].content.substr(0, 16), nullptr, 16);
  };
  parts_.assign(parts, {});
  for (std::size_t f = 0; f < files_.size(); ++f) parts_[number(f) % parts].push_back(f);
  const bool all_have =
      std::none_of(parts_.begin(), parts_.end(), [](const auto& files) { return files.empty(); });
  if (all_have) return;
  std::vector<std::size_t> order(files_.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return files_[a].content < files_[b].content; });
  parts_.assign(parts, {});
  for (std::size_t i = 0; i < order.size(); ++i) parts_[i % parts].push_back(order[i]);
}

MeasuredResponses::MeasuredResponses(const fs::path& path, const MeasuredOptions& options) {
  if (!fs::exists(path)) {
    throw core::InputError(fmt::format("{}: no such folder or file", path.string()),
                           "paths are meant from where the configuration lies");
  }
  const fs::path folder = folder_of(path);
  const std::vector<fs::path> names = files_at(path);
  std::vector<std::string> unusable;
  for (const fs::path& name : names) {
    try {
      read(folder, name, options);
    } catch (const core::Error& error) {
      const std::string hint = error.hint().empty() ? "" : fmt::format(" ({})", error.hint());
      unusable.push_back(
          fmt::format("{}: {}{}", name.generic_string(), reason_of(error, folder / name), hint));
    }
  }
  if (!unusable.empty()) {
    std::string list;
    for (std::size_t i = 0; i < std::min(unusable.size(), named_at_most); ++i) {
      list += "\n  " + unusable[i];
    }
    if (unusable.size() > named_at_most) {
      list += fmt::format("\n  and {} more", unusable.size() - named_at_most);
    }
    throw core::InputError(
        fmt::format("{}: {} of {} files cannot be used as responses:{}", path.string(),
                    unusable.size(), names.size(), list),
        "mend these files, or take them out of the folder; those whose names begin with a dot are "
        "passed over");
  }
  if (files_.empty()) {
    throw core::InputError(fmt::format("{}: the folder has no files", path.string()),
                           "any format that libsndfile reads (WAV, FLAC, Ogg ...) will do");
  }
  if (fs::is_directory(path)) {
    divide(path.string(), std::max<std::size_t>(1, options.parts));
  } else {
    parts_ = {{0}};
  }
}

const MeasuredResponse& MeasuredResponses::draw(std::size_t part,
                                                core::RandomStream& random) const {
  const std::vector<std::size_t>& files = parts_.size() == 1 ? parts_.front() : parts_.at(part);
  const File& file = files_[files[random.index(files.size())]];
  return responses_[file.first + random.index(file.count)];
}

std::shared_ptr<const MeasuredResponses> shared_responses(const fs::path& path,
                                                          const MeasuredOptions& options) {
  static std::mutex mutex;
  static std::string last_key;
  static std::shared_ptr<const MeasuredResponses> last;
  const std::lock_guard lock(mutex);
  const std::string key = key_of(path, options);
  if (!last || key != last_key) {
    last.reset();
    last = std::make_shared<const MeasuredResponses>(path, options);
    last_key = key;
  }
  return last;
}

MeasuredSize measured_size(const fs::path& path, const MeasuredOptions& options) {
  MeasuredSize size;
  if (!fs::exists(path)) return size;
  for (const fs::path& name : files_at(path)) {
    try {
      const core::AudioHeader header = core::read_audio_header(folder_of(path) / name);
      const int channels = options.channel > 0 ? 1 : header.channels;
      const double samples =
          std::min(header.seconds * options.sample_rate, static_cast<double>(options.count));
      size.responses += static_cast<std::size_t>(channels);
      size.bytes += channels * samples * sizeof(float);
    } catch (const core::Error&) {
      continue;  // told when it is read
    }
  }
  return size;
}

}  // namespace carillon::synth::room
