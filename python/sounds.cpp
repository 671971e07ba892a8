#include <fmt/format.h>

#include <limits>
#include <nlohmann/json.hpp>

#include "core/error.hpp"
#include "core/trace.hpp"
#include "core/units.hpp"
#include "eval/damping/fit_report.hpp"
#include "eval/damping/law_text.hpp"
#include "eval/features/feature_json.hpp"
#include "eval/features/read_clip.hpp"
#include "eval/material/assumed_material.hpp"
#include "eval/material/estimate_report.hpp"
#include "eval/perception/compare_report.hpp"
#include "python/objects.hpp"
#include "scene/single_strike.hpp"
#include "synth/signal/mel.hpp"

namespace carillon::python {

namespace {

using core::InputError;
using eval::features::FeatureOptions;
using nlohmann::json;

using Samples = py::array_t<double, py::array::c_style | py::array::forcecast>;

/// One channel as a vector.
std::vector<double> channel_of(const Samples& samples, const std::string& what) {
  if (samples.ndim() != 1) {
    throw InputError(
        fmt::format("{} must be one channel [samples], not {} axes", what, samples.ndim()),
        "take one of several channels: sound[0]");
  }
  return {samples.data(), samples.data() + samples.size()};
}

/// Rows [channels, samples], or one channel.
std::vector<std::vector<double>> channels_of(const Samples& samples, const std::string& what) {
  if (samples.ndim() == 1) return {channel_of(samples, what)};
  if (samples.ndim() != 2) {
    throw InputError(fmt::format("{} must be [samples] or [channels, samples]", what));
  }
  std::vector<std::vector<double>> channels;
  for (py::ssize_t i = 0; i < samples.shape(0); ++i) {
    channels.emplace_back(samples.data(i, 0), samples.data(i, 0) + samples.shape(1));
  }
  return channels;
}

/// Options of features as a mapping of the keys that `carillon features` has as options.
FeatureOptions feature_options(const std::string& text) {
  core::ConfigNode node = core::ConfigNode::parse(text, "features()");
  FeatureOptions options;
  using core::Dimension;
  options.method = node.choice("method", {"esprit", "peaks"}, "esprit") == "peaks"
                       ? eval::features::FeatureMethod::peaks
                       : eval::features::FeatureMethod::esprit;
  if (node.has("onset")) options.onset = node.quantity("onset", Dimension::time);
  options.contact_time = node.not_negative("contact_time", Dimension::time, options.contact_time);
  options.min_frequency =
      node.not_negative("min_frequency", Dimension::frequency, options.min_frequency);
  options.max_frequency =
      node.positive("max_frequency", Dimension::frequency, options.max_frequency);
  options.min_decay_rate = node.quantity("min_decay_rate", Dimension::none, options.min_decay_rate);
  options.rt60 = node.quantities("rt60", Dimension::time, 0, std::vector<double>{});
  options.min_level = node.quantity("min_level", Dimension::none, options.min_level);
  options.max_features = static_cast<std::size_t>(
      node.integer("max_features", 1, 5000, static_cast<std::int64_t>(options.max_features)));
  node.finish();
  return options;
}

std::string features(const Samples& samples, double rate, const std::string& settings) {
  return interruptible([channels = channels_of(samples, "samples"), rate,
                        options = feature_options(settings)](const Waiting&) {
    std::vector<eval::features::FeatureSet> sets;
    for (const std::vector<double>& channel : channels) {
      sets.push_back(eval::features::extract_features(channel, rate, options));
    }
    return eval::features::to_json(
               sets.size() == 1 ? sets.front() : eval::features::merge_channels(std::move(sets)))
        .dump();
  });
}

double number_or_nan(const json& feature, const char* name) {
  const auto found = feature.find(name);
  return found == feature.end() || found->is_null() ? std::numeric_limits<double>::quiet_NaN()
                                                    : found->get<double>();
}

/// What features() gave, or rows of frequency and decay rate alone.
std::vector<eval::features::Feature> features_from(const json& rows) {
  std::vector<eval::features::Feature> features;
  for (const json& row : rows) {
    eval::features::Feature feature;
    feature.frequency = number_or_nan(row, "frequency_hz");
    feature.decay_rate = number_or_nan(row, "decay_rate_per_s");
    feature.amplitude = number_or_nan(row, "amplitude");
    feature.frequency_error = number_or_nan(row, "frequency_error_hz");
    feature.decay_rate_error = number_or_nan(row, "decay_rate_error_per_s");
    feature.amplitude_error = number_or_nan(row, "amplitude_error");
    feature.reverberant = row.value("reverberant", false);
    if (!(feature.frequency > 0) || !(feature.decay_rate > 0)) {
      throw InputError("a feature's frequency and decay rate must be positive numbers");
    }
    features.push_back(feature);
  }
  return features;
}

/// @param sources  a list of {name, features}
std::string fit(const std::string& sources, const std::string& model,
                const std::string& estimator) {
  eval::damping::FitReport report;
  report.law = eval::damping::damping_law(model);
  const eval::damping::Estimator chosen = eval::damping::estimator_named(estimator);
  for (const json& source : json::parse(sources)) {
    report.sources.push_back({source.at("name"), features_from(source.at("features")), {}, {}});
  }
  return interruptible([report = std::move(report), chosen](const Waiting&) mutable {
    const double begin = core::monotonic_seconds();
    const eval::damping::DampingData data =
        eval::damping::damping_data(eval::damping::joined_features(report.sources));
    if (data.size() == 0) {
      throw InputError("no usable feature", "features that may be the room's (rt60) are not used");
    }
    report.fits.push_back(eval::damping::fit_damping(data, report.law, {chosen, true, false}));
    report.least_squares = eval::damping::fit_damping(
        data, report.law, {eval::damping::Estimator::least_squares, false, false});
    report.fit_seconds = core::monotonic_seconds() - begin;
    return eval::damping::to_json(report).dump();
  });
}

std::string compare(const Samples& reference, double reference_rate, const Samples& other,
                    double other_rate, double loudest_level, double widest,
                    const std::string& settings) {
  eval::perception::SoundComparisonOptions how;
  how.loudest_level = loudest_level;
  how.modes.widest = widest;
  return interruptible([how, options = feature_options(settings),
                        one = channel_of(reference, "the reference"), reference_rate,
                        two = channel_of(other, "the other sound"), other_rate](const Waiting&) {
    const auto hear = [&](const std::vector<double>& samples, double rate) {
      return eval::perception::HeardSound{samples,
                                          eval::features::extract_features(samples, rate, options)};
    };
    eval::perception::ComparedFiles compared{
        "reference", "other", hear(one, reference_rate), hear(two, other_rate), {}};
    compared.comparison = eval::perception::compare_sounds(compared.reference, compared.other, how);
    return eval::perception::to_json(compared).dump();
  });
}

/// @return samples [rows, samples] and what carillon strike says of them
py::tuple strike(const SolvedPointer& solved, const std::string& configuration,
                 const std::optional<Triples>& at, const std::optional<Triples>& direction,
                 std::uint64_t seed, std::size_t repeat, double interval) {
  scene::Scene scene = scene::read_strike_scene(configuration, "strike()", {},
                                                solved->object.materials, "the object's material");
  scene::SingleStrike single{.seed = seed, .repeat = repeat, .interval = interval};
  if (at) single.known.position = vector_of(*at, "at");
  if (direction) {
    const Vec3 way = vector_of(*direction, "direction");
    if (!(way.norm() > 0)) throw InputError("direction has no length");
    single.known.direction = way.normalized();
  }
  struct Made {
    std::vector<float> audio;
    std::size_t rows;
    std::string description;
  };
  Made made = interruptible([solved, scene = std::move(scene), single](const Waiting&) {
    scene::StruckSound struck =
        scene::strike_once(scene, solved->name, solved->object, single, solved->cache);
    std::string description = scene::to_json(struck, scene).dump();
    return Made{std::move(struck.sound.audio), struck.sound.rows, std::move(description)};
  });
  const auto rows = static_cast<py::ssize_t>(made.rows);
  const auto samples = static_cast<py::ssize_t>(made.audio.size()) / rows;
  return py::make_tuple(array_of(std::move(made.audio), {rows, samples}), made.description);
}

/// A quantity that may be left out.
std::optional<double> known(const py::object& value) {
  if (value.is_none()) return std::nullopt;
  return value.cast<double>();
}

py::dict assumed_constants(const std::string& named, const py::object& poisson_ratio,
                           const py::object& density) {
  const synth::material::Material material =
      eval::material::assumed_material(named, known(poisson_ratio), known(density));
  py::dict constants;
  constants["youngs_modulus"] = material.elastic.youngs_modulus;
  constants["poisson_ratio"] = material.elastic.poisson_ratio;
  constants["density"] = material.elastic.density;
  return constants;
}

/// @return what carillon estimate says, and the recording made again [samples]
py::tuple estimate(const SolvedPointer& solved, const Samples& samples, double rate,
                   const Triples& at, const std::optional<Triples>& direction,
                   const py::object& density, const std::string& model, const std::string& heard,
                   const py::object& contact_time, std::size_t starts, std::uint64_t seed,
                   const std::string& settings) {
  eval::material::MaterialOptions options;
  options.law = eval::damping::damping_law(model);
  options.motion = eval::material::parse_heard_motion(heard);
  options.contact_time = known(contact_time);
  if (options.contact_time && !(*options.contact_time >= 0))
    throw InputError("contact_time must not be negative");
  options.searches = starts;
  options.starts.seed = seed;
  std::optional<Vec3> way;
  if (direction) way = vector_of(*direction, "direction");
  if (solved->object.materials.size() != 1) {
    throw InputError(
        fmt::format("{} has {} regions", solved->name, solved->object.materials.size()),
        "one material is estimated: give an object of one region");
  }
  auto made = interruptible([=, point = vector_of(at, "at"), density = known(density),
                             clip = channel_of(samples, "the recording"),
                             heard_options = feature_options(settings)](const Waiting&) {
    core::Trace trace = solved->object.trace;
    eval::features::FeatureSet set;
    {
      const core::ScopedTimer timer(trace.stages["features"]);
      set = eval::features::extract_features(clip, rate, heard_options);
    }
    if (set.features.empty()) {
      throw InputError("no modes can be heard: " + set.nothing,
                       "a material is estimated from a struck object's ringing");
    }
    const solvers::modes::Modes& modes = solved->object.modes;
    const auto& elastic = solved->object.materials.front().elastic;
    const double modulus = elastic.youngs_modulus / elastic.density;
    const synth::modal::Strike strike = eval::material::unit_strike(modes, point, way);
    eval::material::MaterialEstimate found;
    {
      const core::ScopedTimer timer(trace.stages["search"]);
      found = eval::material::estimate_material(
          clip, set, eval::material::struck_modes(modes, strike.point, strike.direction, modulus),
          options);
    }
    found.remarks.insert(found.remarks.begin(), set.remarks.begin(), set.remarks.end());
    core::AudioClip again = eval::material::resynthesis(clip, set, modes, strike, found.candidate,
                                                        modulus, options.motion);
    return std::pair(eval::material::to_json(found, set, density, trace).dump(),
                     std::move(again.samples));
  });
  return py::make_tuple(made.first, array_of(std::move(made.second)));
}

}  // namespace

void bind_sounds(py::module_& module) {
  module.def("write_wav", [](const std::string& path,
                             const py::array_t<float, py::array::c_style>& frames, int rate) {
    core::AudioClip clip;
    clip.channels = static_cast<int>(frames.shape(1));
    clip.sample_rate = rate;
    clip.samples.assign(frames.data(), frames.data() + frames.size());
    core::write_wav(path, clip, core::SampleFormat::float32);
  });
  module.def("features", &features);
  module.def("fit", &fit);
  module.def("compare", &compare);
  module.def("strike", &strike);
  module.def("assumed_constants", &assumed_constants);
  module.def("estimate", &estimate);
  module.def("mel", [](const Samples& samples, double rate, int bands, int fft_size, int hop,
                       double min_frequency, double max_frequency) {
    synth::signal::MelOptions options{.sample_rate = rate,
                                      .fft_size = fft_size,
                                      .hop = hop,
                                      .bands = bands,
                                      .min_frequency = min_frequency,
                                      .max_frequency = max_frequency};
    auto rows = channels_of(samples, "samples");
    const auto count = static_cast<py::ssize_t>(rows.size());
    std::vector<float> values = interruptible([rows = std::move(rows), options](const Waiting&) {
      const synth::signal::MelSpectrogram spectrogram(options);
      std::vector<float> all;
      for (const std::vector<double>& row : rows) {
        const std::vector<float> one = spectrogram(std::vector<float>(row.begin(), row.end()));
        all.insert(all.end(), one.begin(), one.end());
      }
      return all;
    });
    const auto frames = static_cast<py::ssize_t>(values.size()) / (count * bands);
    return array_of(std::move(values), {count, bands, frames});
  });
}

}  // namespace carillon::python
