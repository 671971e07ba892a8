#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "core/error.hpp"
#include "core/trace.hpp"
#include "eval/damping/fit_report.hpp"
#include "eval/damping/law_text.hpp"
#include "eval/features/feature_arguments.hpp"
#include "eval/features/feature_json.hpp"
#include "eval/features/read_clip.hpp"
#include "eval/material/estimate_recording.hpp"
#include "eval/material/estimate_report.hpp"
#include "eval/material/pitch_report.hpp"
#include "eval/perception/compare_report.hpp"
#include "python/objects.hpp"
#include "scene/material_json.hpp"
#include "scene/single_strike.hpp"
#include "synth/contact/recorded_force.hpp"
#include "synth/signal/mel.hpp"

namespace carillon::python {

namespace {

using core::InputError;
using eval::features::FeatureArguments;
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
  if (samples.ndim() != 2 || samples.shape(0) == 0) {
    throw InputError(fmt::format("{} must be [samples] or [channels, samples]", what));
  }
  std::vector<std::vector<double>> channels;
  for (py::ssize_t i = 0; i < samples.shape(0); ++i) {
    const double* const row = samples.data() + i * samples.shape(1);
    channels.emplace_back(row, row + samples.shape(1));
  }
  return channels;
}

/// Takes arguments of Python by name where they were given.
class Given {
 public:
  explicit Given(const std::string& text) : values_(json::parse(text)) {}
  template <class T>
  void read(const char* name, T& value) const {
    if (const auto found = values_.find(name); found != values_.end()) found->get_to(value);
  }

 private:
  json values_;
};

/// As `carillon features` has them as options.
FeatureArguments feature_arguments(const Given& given) {
  FeatureArguments arguments;
  given.read("method", arguments.method);
  given.read("onset", arguments.onset);
  given.read("contact_time", arguments.contact_time);
  given.read("min_frequency", arguments.min_frequency);
  given.read("max_frequency", arguments.max_frequency);
  given.read("min_decay_rate", arguments.min_decay_rate);
  given.read("rt60", arguments.rt60);
  given.read("min_level", arguments.min_level);
  given.read("max_features", arguments.max_features);
  given.read("explained", arguments.explained);
  return arguments;
}

eval::features::FeatureOptions feature_options(const std::string& given) {
  return eval::features::feature_options(feature_arguments(Given(given)));
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
    if (!std::isfinite(feature.frequency) || !std::isfinite(feature.decay_rate) ||
        !(feature.frequency > 0) || !(feature.decay_rate > 0)) {
      throw InputError(fmt::format("feature {}: its frequency and decay rate must be positive",
                                   features.size()));
    }
    features.push_back(feature);
  }
  return features;
}

/// @param sources  a list of {name, features}
std::string fit(const std::string& sources, const std::string& model,
                const std::string& estimator) {
  std::vector<eval::damping::FitSource> all;
  for (const json& source : json::parse(sources)) {
    all.push_back({source.at("name"), features_from(source.at("features")), {}, {}, {}});
  }
  return interruptible([all = std::move(all), laws = eval::damping::damping_laws(model),
                        chosen = eval::damping::estimator_named(estimator)](const Waiting&) {
    return eval::damping::to_json(eval::damping::fit_sources(all, laws, std::vector{chosen}, false))
        .dump();
  });
}

std::string compare(const Samples& reference, double reference_rate, const Samples& other,
                    double other_rate, double loudest_level, double widest,
                    const std::string& settings) {
  eval::perception::SoundComparisonOptions comparison;
  comparison.loudest_level = loudest_level;
  comparison.modes.widest = widest;
  return interruptible([comparison, options = feature_options(settings),
                        one = channel_of(reference, "the reference"), reference_rate,
                        two = channel_of(other, "the other sound"), other_rate](const Waiting&) {
    const auto hear = [&](const std::vector<double>& samples, double rate) {
      return eval::perception::HeardSound{samples,
                                          eval::features::extract_features(samples, rate, options)};
    };
    eval::perception::ComparedFiles compared{
        "reference", "other", hear(one, reference_rate), hear(two, other_rate), {}};
    compared.comparison =
        eval::perception::compare_sounds(compared.reference, compared.other, comparison);
    return eval::perception::to_json(compared).dump();
  });
}

/// @return samples [rows, samples] and what carillon strike says of them
py::tuple strike(const SolvedPointer& solved, const std::string& configuration,
                 const std::optional<Triples>& at, const std::optional<Triples>& direction,
                 const std::optional<Samples>& force, double force_rate, std::uint64_t seed,
                 std::size_t repeat, double interval) {
  scene::Scene scene = scene::read_strike_scene(configuration, "strike()", {},
                                                solved->object.materials, "the object's material");
  scene::SingleStrike single{.seed = seed, .repeat = repeat, .interval = interval};
  if (at) single.known.position = vector_of(*at, "at");
  if (direction) {
    const Vec3 way = vector_of(*direction, "direction");
    if (!(way.norm() > 0)) throw InputError("direction has no length");
    single.known.direction = way.normalized();
  }
  if (force) {
    if (force->ndim() != 1) throw InputError("force must be one row of samples, [samples] in N");
    single.known.force = synth::contact::recorded_force(
        {force->data(), static_cast<std::size_t>(force->size())}, force_rate);
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

/// As `carillon estimate` has them as options.
eval::material::EstimateArguments estimate_arguments(const std::string& text) {
  const Given given(text);
  eval::material::EstimateArguments arguments;
  given.read("metric", arguments.metric);
  given.read("model", arguments.model);
  given.read("heard", arguments.heard);
  given.read("contact_time", arguments.contact_time);
  given.read("poisson_ratio", arguments.poisson_ratio);
  given.read("density", arguments.density);
  given.read("onset", arguments.onset);
  given.read("rt60", arguments.rt60);
  given.read("starts", arguments.starts);
  given.read("seed", arguments.seed);
  return arguments;
}

/// What the object is solved in, as `carillon list materials --json` has materials: once for each
/// Poisson's ratio that is tried.
std::string assumed_materials(const std::string& named, const std::string& given) {
  const eval::material::EstimateArguments arguments = estimate_arguments(given);
  eval::material::checked_metric(arguments, true, 1, false);
  synth::material::Material assumed = eval::material::assumed_material(named, arguments);
  json materials = json::array();
  for (const double ratio : eval::material::poisson_ratios(named, arguments)) {
    assumed.elastic.poisson_ratio = ratio;
    materials.push_back(scene::to_json(assumed));
  }
  return materials.dump();
}

/// What is known of a strike on an object.
std::optional<eval::material::StruckPlace> place_of(const std::optional<Triples>& at,
                                                    const std::optional<Triples>& direction) {
  if (!at) {
    if (direction) throw InputError("direction needs at");
    return std::nullopt;
  }
  std::optional<Vec3> force;
  if (direction) force = vector_of(*direction, "direction");
  return eval::material::struck_place(vector_of(*at, "at"), force);
}

/// The material by pitches; solves the object at each Poisson's ratio once what was heard is known
/// to be usable.
/// @param solves  give the solved objects, by ascending Poisson's ratio
/// @return what carillon estimate says
std::string estimate_pitches(const std::vector<py::function>& solves,
                             const std::vector<Samples>& recordings,
                             const std::vector<double>& rates, const std::optional<Triples>& at,
                             const std::optional<Triples>& direction, const std::string& given) {
  const eval::material::EstimateArguments arguments = estimate_arguments(given);
  eval::material::checked_metric(arguments, at.has_value(), recordings.size(), false);
  const eval::material::MaterialOptions options = eval::material::material_options(arguments);
  const auto place = place_of(at, direction);
  std::vector<std::vector<double>> clips;
  for (const Samples& samples : recordings) clips.push_back(channel_of(samples, "the recording"));
  struct Heard {
    std::vector<eval::material::HeardRecording> recordings;
    core::Trace trace;
  };
  Heard heard = interruptible([clips = std::move(clips), rates, arguments](const Waiting&) mutable {
    Heard made;
    const core::ScopedTimer timer(made.trace.stages["features"]);
    for (std::size_t i = 0; i < clips.size(); ++i) {
      made.recordings.push_back(
          eval::material::listen(std::move(clips[i]), rates[i], arguments, "the recording"));
    }
    return made;
  });
  std::vector<SolvedPointer> solved;
  for (const py::function& solve : solves) solved.push_back(solve().cast<SolvedPointer>());
  return interruptible([=, heard = std::move(heard)](const Waiting&) mutable {
    std::vector<solvers::modes::Modes> modes;
    std::vector<double> ratios;
    for (const SolvedPointer& one : solved) {
      heard.trace.merge(one->object.trace);
      modes.push_back(one->object.modes);
      ratios.push_back(one->object.materials.front().elastic.poisson_ratio);
    }
    const eval::material::PitchEstimate found = eval::material::estimate_from_recordings(
        heard.recordings, modes, ratios, solved.front()->object.materials.front(), place,
        options.law, heard.trace);
    return eval::material::to_json(found, eval::material::known_density(arguments), heard.trace)
        .dump();
  });
}

/// Solves the object once what was heard and where it was struck are known to be usable.
/// @param solve  gives the solved object
/// @return what carillon estimate says, and the recording made again [samples]
py::tuple estimate(const py::function& solve, const Samples& samples, double rate,
                   const std::optional<Triples>& at, const std::optional<Triples>& direction,
                   const std::string& given) {
  const eval::material::EstimateArguments arguments = estimate_arguments(given);
  eval::material::checked_metric(arguments, at.has_value(), 1, true);
  const eval::material::MaterialOptions options = eval::material::material_options(arguments);
  const eval::material::StruckPlace place = *place_of(at, direction);
  struct Heard {
    eval::material::HeardRecording recording;
    core::Trace trace;
  };
  Heard heard = interruptible(
      [clip = channel_of(samples, "the recording"), rate, arguments](const Waiting&) mutable {
        Heard made;
        const core::ScopedTimer timer(made.trace.stages["features"]);
        made.recording = eval::material::listen(std::move(clip), rate, arguments, "the recording");
        return made;
      });
  const auto solved = solve().cast<SolvedPointer>();
  auto made = interruptible([=, heard = std::move(heard)](const Waiting&) mutable {
    core::Trace& trace = heard.trace;
    trace.merge(solved->object.trace);
    eval::material::RecordedMaterial found = eval::material::estimate_recording(
        heard.recording, solved->object.modes, solved->object.materials, place, options,
        solved->name, trace);
    return std::pair(eval::material::to_json(found.estimate, heard.recording.set,
                                             eval::material::known_density(arguments), trace)
                         .dump(),
                     std::move(found.resynthesis.samples));
  });
  return py::make_tuple(made.first, array_of(std::move(made.second)));
}

/// @return [rows, bands, frames]
py::array_t<float> mel(const Samples& samples, double rate, int bands, int fft_size, int hop,
                       double min_frequency, double max_frequency, int resized_bands,
                       int resized_frames) {
  const synth::signal::MelOptions options{.sample_rate = rate,
                                          .fft_size = fft_size,
                                          .hop = hop,
                                          .bands = bands,
                                          .min_frequency = min_frequency,
                                          .max_frequency = max_frequency,
                                          .resized_bands = resized_bands,
                                          .resized_frames = resized_frames};
  auto rows = channels_of(samples, "samples");
  for (const std::vector<double>& row : rows) {
    if (!std::all_of(row.begin(), row.end(), [](double x) { return std::isfinite(x); })) {
      throw InputError("samples: one of them is not finite");
    }
  }
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
  const auto frames = static_cast<py::ssize_t>(values.size()) / (count * resized_bands);
  return array_of(std::move(values), {count, resized_bands, frames});
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
  module.def("assumed_materials", &assumed_materials);
  module.def("estimate", &estimate);
  module.def("estimate_pitches", &estimate_pitches);
  module.def("mel", &mel);
}

}  // namespace carillon::python
