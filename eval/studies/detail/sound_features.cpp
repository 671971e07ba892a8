#include "eval/studies/detail/sound_features.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/error.hpp"
#include "core/files.hpp"
#include "core/hash.hpp"
#include "core/hdf5.hpp"
#include "core/json.hpp"
#include "core/revision.hpp"
#include "dataset/samples/samples_task.hpp"
#include "dataset/stored/sample_audio.hpp"
#include "eval/damping/reverberant_modes.hpp"

namespace carillon::eval::studies {

using core::Hdf5Group;
using features::Feature;

namespace {

/// So many sounds are lost at most by each rank of a run that is killed.
constexpr std::size_t sounds_per_block = 32;
/// The modes of an object are at hand for all of its sounds.
constexpr std::size_t truths_per_block = 256;
/// Of what is kept. Raise it when the same sound gives other features.
constexpr int revision = 9;

std::string text_of(const FeatureSource& source) {
  const features::FeatureOptions& o = source.options;
  return fmt::format("{} {} {} {} {} {} {} {} {} carillon {} revision {}", source.name,
                     o.contact_time, o.min_frequency, o.max_frequency,
                     o.min_decay_rate.value_or(-1), o.min_level, o.max_features, o.explained,
                     source.truth || o.keep_reverberant, core::version(), revision);
}

/// SHA-256 of the files of a dataset by their paths.
std::map<std::string, std::string> listed_files(const std::filesystem::path& dataset) {
  const auto path = dataset / "dataset.json";
  const nlohmann::json document = core::read_json(path);
  if (!document.is_object() || !document.contains("files")) {
    throw core::FileError(fmt::format("{} is no description of a dataset", path.string()),
                          "run the same command again after removing it");
  }
  std::map<std::string, std::string> files;
  for (const nlohmann::json& file : document.at("files")) {
    files[file.at("path")] = file.at("sha256").get<std::string>();
  }
  return files;
}

/// What the first listener hears in some rows of a shard, full scale 1.
std::vector<std::vector<double>> read_audio(const Hdf5Group& shard, std::size_t first,
                                            std::size_t count) {
  std::vector<std::vector<double>> audio;
  for (const core::AudioClip& clip : dataset::stored::SampleAudio(shard).read(first, count)) {
    std::vector<double>& samples = audio.emplace_back();
    for (std::size_t i = 0; i < clip.samples.size(); i += static_cast<std::size_t>(clip.channels)) {
      samples.push_back(static_cast<double>(clip.samples[i]));
    }
  }
  return audio;
}

/// Columns of a file of features.
struct Table {
  std::vector<std::int64_t> counts;  ///< features of each sound
  std::vector<std::string> nothing;
  std::vector<double> explained, onset;
  std::vector<double> frequency, decay_rate, amplitude, frequency_error, decay_rate_error;
  std::vector<std::uint8_t> reverberant;
  std::vector<double> rt60;  ///< of each sound's room, by octave; empty: no rooms

  void add(const features::FeatureSet& set) {
    counts.push_back(static_cast<std::int64_t>(set.features.size()));
    nothing.push_back(set.nothing);
    explained.push_back(set.explained);
    onset.push_back(set.onset);
    for (const Feature& feature : set.features) {
      frequency.push_back(feature.frequency);
      decay_rate.push_back(feature.decay_rate);
      amplitude.push_back(feature.amplitude);
      frequency_error.push_back(feature.frequency_error);
      decay_rate_error.push_back(feature.decay_rate_error);
      reverberant.push_back(feature.reverberant ? 1 : 0);
    }
  }
};

/// What a fit depends on.
std::string hash_of(const Table& table) {
  core::Sha256 hash;
  hash.add(std::span<const std::int64_t>(table.counts));
  for (const auto* column : {&table.frequency, &table.decay_rate, &table.decay_rate_error}) {
    hash.add(std::span<const double>(*column));
  }
  hash.add(std::span<const std::uint8_t>(table.reverberant));
  hash.add(std::span<const double>(table.rt60));
  return hash.hex();
}

void write_table(const SoundBlock& block, const FeatureSource& source,
                 const std::vector<std::string>& keys, const Table& table) {
  core::write_durably(block.file, [&](const std::filesystem::path& path) {
    const Hdf5Group file = Hdf5Group::create_file(path);
    file.write_attribute("sounds", block.key);
    file.write_attribute("extractor", source.name);
    file.write_attribute("content", hash_of(table));
    const core::Extent sounds = {table.counts.size()}, features = {table.frequency.size()};
    file.write<std::string>("key", keys, sounds);
    file.write<std::int64_t>("features", table.counts, sounds);
    file.write<std::string>("nothing", table.nothing, sounds);
    file.write<double>("explained", table.explained, sounds);
    file.write<double>("onset", table.onset, sounds);
    file.write<double>("frequency", table.frequency, features);
    file.write<double>("decay_rate", table.decay_rate, features);
    file.write<double>("amplitude", table.amplitude, features);
    file.write<double>("frequency_error", table.frequency_error, features);
    file.write<double>("decay_rate_error", table.decay_rate_error, features);
    file.write<std::uint8_t>("reverberant", table.reverberant, features);
    if (!table.rt60.empty()) {
      file.write<double>("room_rt60", table.rt60,
                         {table.counts.size(), table.rt60.size() / table.counts.size()});
      file.write_attribute("unit", "s", "room_rt60");
    }
    for (const char* name : {"frequency", "frequency_error"}) {
      file.write_attribute("unit", "Hz", name);
    }
    for (const char* name : {"decay_rate", "decay_rate_error"}) {
      file.write_attribute("unit", "1/s", name);
    }
    file.write_attribute("unit", "s", "onset");
    file.flush();
  });
}

/// The modes that ring in a sample, as features that nobody had to find; marked where the room that
/// they ring in decays slower.
features::FeatureSet true_features(const synth::modal::RingDown& rings, const FeatureSource& source,
                                   std::span<const double> rt60) {
  constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
  features::FeatureSet set;
  for (std::size_t i = 0; i < rings.eigenvalues.size(); ++i) {
    const double d = rings.decay_rates[i], rest = rings.eigenvalues[i] - d * d;
    if (!(rest > 0)) continue;
    Feature feature;
    feature.frequency = std::sqrt(rest) / (2 * std::numbers::pi);
    if (feature.frequency < source.options.min_frequency ||
        feature.frequency > source.options.max_frequency) {
      continue;
    }
    feature.decay_rate = d;
    feature.reverberant = !rt60.empty() && 2 * d >= damping::room_ceiling(rt60, feature.frequency);
    feature.amplitude = unknown;
    feature.frequency_error = feature.decay_rate_error = unknown;
    set.features.push_back(feature);
  }
  return set;
}

/// What an extractor finds in a sound of a room, or of none.
features::FeatureSet found_features(std::span<const double> samples, double sample_rate,
                                    const FeatureSource& source, std::span<const double> rt60) {
  features::FeatureOptions options = source.options;
  options.rt60.assign(rt60.begin(), rt60.end());
  const bool by_room = source.name == room_likelihood && features::reverberates(rt60);
  return by_room ? damping::reverberant_modes(samples, sample_rate, options)
                 : features::extract_features(samples, sample_rate, options);
}

}  // namespace

std::vector<SoundBlock> sound_blocks(const EvaluatedDatasets& datasets,
                                     const std::vector<FeatureSource>& sources,
                                     const std::filesystem::path& folder) {
  std::vector<SoundBlock> blocks;
  for (std::size_t c = 0; c < datasets.conditions().size(); ++c) {
    const Condition& condition = datasets.conditions()[c];
    const dataset::plan::BuildPlan& plan = condition.build->plan;
    const auto files = listed_files(condition.folder);
    for (std::size_t t = 0; t < plan.tasks.size(); ++t) {
      const dataset::plan::BuildTask& task = plan.tasks[t];
      const auto listed = files.find(task.key + ".h5");
      if (task.kind != dataset::plan::TaskKind::samples || listed == files.end()) continue;
      const bool in_room = Hdf5Group::open_file(condition.folder / listed->first).has("room_rt60");
      for (std::size_t s = 0; s < sources.size(); ++s) {
        FeatureSource computed = sources[s];
        // Without a room it is the same, and is not computed twice.
        if (computed.name == room_likelihood && !in_room) computed.name = "esprit";
        const std::size_t size = sources[s].truth ? truths_per_block : sounds_per_block;
        for (std::size_t first = 0; first < task.count; first += size) {
          SoundBlock block{
              c,  s, t, first, std::min(size, task.count - first), condition.folder / listed->first,
              "", ""};
          block.key = fmt::format("{}/{}/{}+{}", sources[s].name, condition.name, task.key, first);
          const std::string name = core::sha256(
              fmt::format("{}\n{} {}\n{}", listed->second, first, block.count, text_of(computed)));
          block.file = folder / (name.substr(0, 32) + ".h5");
          blocks.push_back(std::move(block));
        }
      }
    }
  }
  return blocks;
}

void compute_features(const SoundBlock& block, const Condition& condition,
                      const FeatureSource& source, const std::filesystem::path& cache) {
  const dataset::plan::BuildPlan& plan = condition.build->plan;
  const dataset::plan::BuildTask& task = plan.tasks[block.task];
  Table table;
  std::vector<std::string> keys;
  for (std::size_t k = 0; k < block.count; ++k) {
    keys.push_back(plan.samples[task.first + block.first + k].key);
  }
  const Hdf5Group shard = Hdf5Group::open_file(block.shard);
  if (shard.has("room_rt60")) {
    table.rt60 = shard.read_rows<double>("room_rt60", block.first, block.count);
  }
  const std::size_t octaves = table.rt60.size() / std::max<std::size_t>(block.count, 1);
  const auto room_of = [&](std::size_t k) {
    return std::span<const double>(table.rt60).subspan(k * octaves, octaves);
  };
  if (source.truth) {
    core::Trace trace;
    dataset::samples::SampleMaker maker(condition.build->config, plan.shapes[task.shape],
                                        {condition.folder, cache}, trace);
    for (std::size_t k = 0; k < block.count; ++k) {
      const dataset::plan::Sample& sample = plan.samples[task.first + block.first + k];
      table.add(true_features(maker.ring(sample), source, room_of(k)));
    }
    write_table(block, source, keys, table);
    return;
  }
  const double rate = shard.number_attribute("sample_rate_hz");
  const auto audio = read_audio(shard, block.first, block.count);
  for (std::size_t k = 0; k < block.count; ++k) {
    table.add(found_features(audio[k], rate, source, room_of(k)));
  }
  write_table(block, source, keys, table);
}

std::vector<SoundFeatures> read_features(const std::filesystem::path& path, bool keep_reverberant) {
  const Hdf5Group file = Hdf5Group::open_file(path);
  const auto counts = file.read<std::int64_t>("features");
  const auto frequency = file.read<double>("frequency");
  const auto decay_rate = file.read<double>("decay_rate");
  const auto frequency_error = file.read<double>("frequency_error");
  const auto decay_rate_error = file.read<double>("decay_rate_error");
  const auto reverberant = file.read<std::uint8_t>("reverberant");
  const auto times = file.has("room_rt60") && !keep_reverberant ? file.read<double>("room_rt60")
                                                                : std::vector<double>{};
  const std::size_t octaves = times.size() / std::max<std::size_t>(counts.size(), 1);
  const bool in_room = file.has("room_rt60") && file.text_attribute("extractor") == room_likelihood;
  std::vector<SoundFeatures> sounds;
  std::size_t next = 0;
  for (const std::int64_t count : counts) {
    SoundFeatures sound;
    std::vector<Feature> features(static_cast<std::size_t>(count));
    for (Feature& feature : features) {
      feature.frequency = frequency.at(next);
      feature.decay_rate = decay_rate.at(next);
      feature.frequency_error = frequency_error.at(next);
      feature.decay_rate_error = decay_rate_error.at(next);
      feature.reverberant = reverberant.at(next) != 0;
      if (feature.reverberant) ++sound.reverberant;
      if (keep_reverberant) feature.reverberant = false;
      ++next;
    }
    sound.there = true;
    sound.found = features.size();
    sound.data = in_room ? damping::reverberant_data(features)
                         : damping::damping_data(features, std::span(times).subspan(
                                                               sounds.size() * octaves, octaves));
    sounds.push_back(std::move(sound));
  }
  return sounds;
}

std::string content_of(const std::filesystem::path& path) {
  return Hdf5Group::open_file(path).text_attribute("content");
}

}  // namespace carillon::eval::studies
