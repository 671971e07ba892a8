#include "dataset/run/expected_bytes.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>
#include <vector>

#include "core/progress.hpp"
#include "dataset/plan/disk.hpp"
#include "dataset/run/expected_shapes.hpp"
#include "scene/columns.hpp"

namespace carillon::dataset::run {

namespace {

// Fractions of their size that values take once they are compressed, and what HDF5 and JSON take
// beside them, as counted in datasets of configs/smoke.yaml, kitchen.yaml and rsaudio.yaml
// (docs/scaling.md). Mantissas are noise to zlib; exponents are not.
constexpr double float_sound = 0.77, noisy_float_sound = 0.8, int_sound = 0.31, mel_values = 0.84;
constexpr double wav_head = 58;  ///< of a WAV file

/// Whether a word stands in a list "a|b".
bool is_among(std::string_view word, std::string_view list) {
  while (!list.empty()) {
    const std::size_t bar = std::min(list.find('|'), list.size());
    if (list.substr(0, bar) == word) return true;
    list.remove_prefix(std::min(bar + 1, list.size()));
  }
  return false;
}

/// Columns of a row beside `audio` and `mel`.
struct NarrowColumns {
  double texts = 0, numbers = 0;  ///< columns
  double bytes = 0;               ///< of a row, texts as references
};

/// Values of a row that a rule's `inner` stands for; what a simulation keeps many of is
/// plan::SampleBytes::motion.
double values_of(std::string_view inner, const scene::Scene& scene) {
  if (inner == "listeners") return static_cast<double>(scene.rows());
  const bool is_number = !inner.empty() && std::all_of(inner.begin(), inner.end(),
                                                       [](char c) { return c >= '0' && c <= '9'; });
  return is_number ? std::stod(std::string(inner)) : 1;
}

NarrowColumns narrow_columns(const configuration::BuildConfig& config) {
  NarrowColumns found;
  const auto is_there = [&](std::string_view when) {
    if (when == "always") return true;
    if (when == "struck") return !config.motion;
    if (constexpr std::string_view struck = "struck:"; when.starts_with(struck)) {
      return !config.motion && config.scene.runs(when.substr(struck.size()));
    }
    return std::any_of(config.scene.effects.begin(), config.scene.effects.end(),
                       [&](const scene::EffectDecision& effect) {
                         return effect.enabled && is_among(effect.effect->name, when);
                       });
  };
  for (const core::ColumnRule& rule : scene::columns()) {
    const std::string_view name = rule.name, type = rule.type;
    if (!is_there(rule.when) || name == "audio" || name == "mel") continue;
    const double values = (name == "alpha" ? 2 : 1) * values_of(rule.inner, config.scene);
    (type == "text" ? found.texts : found.numbers) += name == "alpha" ? 2 : 1;
    found.bytes += values * (type == "text" ? 16 : 8);
  }
  const auto labels = static_cast<double>(configuration::named_labels(config).size());
  found.texts += labels;
  found.bytes += 16 * labels;
  return found;
}

/// Of a row's texts.
double text_bytes(const plan::BuildPlan& plan) {
  constexpr double others = 30;  // splits, damping model and what effects tell
  double sum = 0;
  for (const plan::Sample& sample : plan.samples) {
    const plan::Shape& shape = plan.shapes[sample.shape];
    sum += static_cast<double>(sample.key.size() + shape.id.size() + shape.family.size() +
                               shape.variants[sample.variant].material.size()) +
           others;
  }
  return sum;
}

/// The modes file of a shape but for its views.
double modes_bytes(const ExpectedShape& shape) {
  constexpr double file = 3e3, set = 15e3, mode = 60;
  const ExpectedSurface& surface = shape.surface;
  const double per_face = (surface.order + 1) * (surface.order + 2) / 2.0;
  const double shapes = 12 * surface.rows * surface.compressed;
  double bytes = file;
  for (const double modes : shape.modes)
    bytes += set + 24 * surface.nodes + 4 * surface.faces * per_face + modes * (mode + shapes);
  return bytes;
}

void add_views(const configuration::BuildConfig& config, const plan::BuildPlan& plan,
               ExpectedBytes& bytes) {
  const auto shapes = static_cast<double>(plan.shapes.size());
  constexpr double dataset = 5e3, voxel = 0.7, pixel = 0.05, png_pixel = 0.048;
  if (config.voxels) {
    const double surface = config.voxels->turns * std::pow(config.voxels->resolution, 2);
    bytes.voxels = shapes * (dataset + voxel * surface);
  }
  if (config.cameras.empty()) return;
  const render::Camera& camera = config.cameras.front();
  const auto frames = static_cast<double>(plan::pictures(plan) * config.cameras.size());
  const double values = 3.0 * camera.width * camera.height;
  bytes.pictures = shapes * dataset + frames * (pixel + (config.png ? png_pixel : 0)) * values;
}

void add_shards(const configuration::BuildConfig& config, const plan::BuildPlan& plan,
                ExpectedBytes& bytes) {
  const plan::SampleBytes each = plan::sample_bytes(config);
  const NarrowColumns columns = narrow_columns(config);
  const auto samples = static_cast<double>(plan.samples.size());
  const auto shards = static_cast<double>(std::count_if(
      plan.tasks.begin(), plan.tasks.end(),
      [](const plan::BuildTask& task) { return task.kind == plan::TaskKind::samples; }));
  const double sound = config.scene.audio.dtype == core::SampleFormat::int16 ? int_sound
                       : config.scene.runs("noise")                          ? noisy_float_sound
                                                                             : float_sound;
  // HDF5's heads of columns and its heaps of texts; B-trees of chunks.
  constexpr double column = 400, heap = 1500, in_heap = 20, chunk = 50, pixel = 0.05;
  const double texts = in_heap * columns.texts * samples + text_bytes(plan);
  const double all = columns.texts + columns.numbers + 2;
  bytes.sounds = samples * (sound * each.audio + mel_values * each.mel + each.motion +
                            columns.bytes + 2 * chunk) +
                 shards * (column * all + heap * columns.texts) + texts;
  bytes.movies = samples * pixel * each.pixels;
  if (config.wav) bytes.wav = samples * (each.wav + wav_head);

  // The index copies texts, and names the shard of every other column's rows.
  constexpr double index_column = 500, source = 100, reference = 16;
  const double of_objects = (config.voxels ? 3 : 0) + (config.cameras.empty() ? 0 : 1);
  bytes.index = texts + reference * columns.texts * samples +
                source * (columns.numbers + 3 + of_objects) * shards +
                index_column * (all + 5 + of_objects);
}

void add_records(const configuration::BuildConfig& config, const plan::BuildPlan& plan,
                 ExpectedBytes& bytes) {
  // JSON of a file in dataset.json and the journal, of one in croissant.json, and so on.
  constexpr double file = 160 + 137, described = 330, column = 390, shape = 900, variant = 100,
                   material = 450, task = 940 + 313, fixed = 9e3;
  const NarrowColumns columns = narrow_columns(config);
  const auto shapes = static_cast<double>(plan.shapes.size());
  const auto samples = static_cast<double>(plan.samples.size());
  const auto tasks = static_cast<double>(plan.tasks.size());
  const double files =
      tasks + (config.wav ? samples : 0) +
      (config.png ? static_cast<double>(plan::pictures(plan) * config.cameras.size()) : 0);
  double variants = 0;
  for (const plan::Shape& one : plan.shapes) variants += static_cast<double>(one.variants.size());
  bytes.records = fixed + 2 * static_cast<double>(config.resolved.size()) +
                  (file + described) * files + task * tasks +
                  column * (columns.texts + columns.numbers + 3) + shape * shapes +
                  variant * variants +
                  material * static_cast<double>(configuration::named_materials(config).size());
}

}  // namespace

double ExpectedBytes::total() const {
  return sounds + modes + voxels + pictures + movies + wav + index + records;
}

ExpectedBytes expected_bytes(const LoadedBuild& build) {
  ExpectedBytes bytes;
  for (const ExpectedShape& shape : expected_shapes(build.config, build.plan))
    bytes.modes += modes_bytes(shape);
  add_views(build.config, build.plan, bytes);
  add_shards(build.config, build.plan, bytes);
  add_records(build.config, build.plan, bytes);
  return bytes;
}

namespace {

std::vector<std::pair<const char*, double>> listed(const ExpectedBytes& bytes) {
  return {{"sounds", bytes.sounds},     {"modes", bytes.modes},    {"voxels", bytes.voxels},
          {"pictures", bytes.pictures}, {"movies", bytes.movies},  {"wav", bytes.wav},
          {"index", bytes.index},       {"records", bytes.records}};
}

}  // namespace

nlohmann::json to_json(const ExpectedBytes& bytes) {
  nlohmann::json out = nlohmann::json::object();
  for (const auto& [kind, size] : listed(bytes)) out[kind] = size;
  return out;
}

std::string bytes_text(const ExpectedBytes& bytes) {
  std::vector<std::string> parts;
  for (const auto& [kind, size] : listed(bytes)) {
    if (size > 0) parts.push_back(fmt::format("{} {}", kind, core::human_bytes(size)));
  }
  return fmt::format("{}", fmt::join(parts, ", "));
}

}  // namespace carillon::dataset::run
