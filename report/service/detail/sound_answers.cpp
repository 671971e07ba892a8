#include "report/service/detail/sound_answers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <map>

#include "core/audio.hpp"
#include "core/error.hpp"
#include "core/storage_error.hpp"
#include "core/temporary_folder.hpp"
#include "core/text.hpp"
#include "eval/damping/fit_report.hpp"
#include "eval/features/feature_arguments.hpp"
#include "eval/features/feature_json.hpp"
#include "eval/features/read_clip.hpp"
#include "eval/perception/compare_report.hpp"
#include "report/service/options.hpp"

namespace carillon::report::service {

namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

/// A sound of a request as a file, under a name of this program's.
class Clip {
 public:
  /// @param name  of the part of a form; "" for the body itself
  Clip(const HttpRequest& request, const std::string& name, const ClipLimits& limits)
      : path_(folder_ / (name.empty() ? "recording" : name)), name_(path_.filename().string()) {
    const auto part = request.files.find(name);
    const std::string* bytes = part != request.files.end() ? &part->second
                               : request.files.size() == 1 && name.empty()
                                   ? &request.files.begin()->second
                               : name.empty() ? &request.body
                                              : nullptr;
    if (bytes == nullptr || bytes->empty()) {
      throw core::InputError(
          name.empty() ? "the request has no sound"
                       : fmt::format("the form has no file \"{}\"", name),
          name.empty() ? "its body is a WAV, FLAC, Ogg or AIFF file" : "curl -F name=@file.wav");
    }
    std::ofstream file(path_, std::ios::binary);
    file << *bytes;
    file.close();
    if (!file) {
      throw core::StorageError("the sound could not be kept while it is computed with",
                               "see that the folder for temporary files has room");
    }
    const core::AudioHeader header = told([&] { return core::read_audio_header(path_); });
    if (!(header.seconds <= limits.seconds)) {
      throw core::InputError(fmt::format("the {} lasts {:.3g} s, and {:.3g} s are taken", name_,
                                         header.seconds, limits.seconds),
                             "carillon serve --longest-clip");
    }
  }

  const fs::path& path() const { return path_; }

  /// Calls something that reads it: errors do not tell where this program keeps it.
  template <class Use>
  auto told(const Use& use) const -> decltype(use()) {
    const auto plain = [&](std::string text) {
      for (std::size_t at = text.find(path_.string()); at != std::string::npos;
           at = text.find(path_.string())) {
        text.replace(at, path_.string().size(), "the " + name_);
      }
      return text;
    };
    try {
      return use();
    } catch (const core::Error& error) {
      throw core::InputError(plain(error.message()), plain(error.hint()));
    }
  }

 private:
  core::TemporaryFolder folder_;
  fs::path path_;
  std::string name_;
};

eval::features::FeatureOptions feature_options_of(Options& options) {
  eval::features::FeatureArguments arguments;
  arguments.method = options.text("method", arguments.method);
  if (arguments.method != "esprit" && arguments.method != "peaks") {
    throw core::InputError(fmt::format("method is \"{}\"", arguments.method),
                           "there are esprit and peaks");
  }
  for (const auto& [name, value] :
       {std::pair{"onset", &arguments.onset}, std::pair{"contact_time", &arguments.contact_time},
        std::pair{"duration", &arguments.duration},
        std::pair{"min_frequency", &arguments.min_frequency},
        std::pair{"max_frequency", &arguments.max_frequency},
        std::pair{"min_decay_rate", &arguments.min_decay_rate},
        std::pair{"explained", &arguments.explained}, std::pair{"rt60", &arguments.rt60}}) {
    *value = options.text(name, *value);
  }
  arguments.min_level =
      options.number("min_level", arguments.min_level, eval::features::lowest_min_level, 0);
  arguments.max_features =
      options.count("max_features", arguments.max_features, 1, eval::features::max_feature_count);
  return eval::features::feature_options(arguments);
}

}  // namespace

ordered_json features_of(const HttpRequest& request, const ClipLimits& limits) {
  Options options(request);
  const eval::features::FeatureOptions wanted = feature_options_of(options);
  options.finish();
  const Clip clip(request, "", limits);
  return clip.told(
      [&] { return ordered_json(to_json(eval::features::read_features(clip.path(), wanted))); });
}

ordered_json fit_of(const HttpRequest& request, const ClipLimits& limits) {
  Options options(request);
  const auto laws = eval::damping::damping_laws(options.text("model", "rayleigh"));
  const std::vector<eval::damping::Estimator> estimators = {
      eval::damping::estimator_named(options.text("estimator", "mixture"))};
  const eval::features::FeatureOptions wanted = feature_options_of(options);
  options.finish();
  const Clip clip(request, "", limits);
  return clip.told([&] {
    return ordered_json(to_json(eval::damping::fit_sources(
        {eval::damping::fit_source_of_recording(clip.path().string(), wanted)}, laws, estimators,
        /*with_history=*/false)));
  });
}

ordered_json comparison_of(const HttpRequest& request, const ClipLimits& limits) {
  Options options(request);
  eval::perception::SoundComparisonOptions how;
  how.loudest_level = options.number("loudest_level", how.loudest_level, 0, 140);
  how.modes.widest = options.number("widest", how.modes.widest, 0.1, 2400);
  const eval::features::FeatureOptions wanted = feature_options_of(options);
  options.finish();
  const Clip reference(request, "reference", limits), other(request, "other", limits);
  const auto hear = [&](const Clip& clip) {
    return clip.told([&] {
      const core::AudioClip audio = core::read_audio(clip.path());
      auto channels = eval::features::channels_by_energy(audio);
      eval::features::FeatureSet set =
          eval::features::extract_features(channels.front().samples, audio.sample_rate, wanted);
      return eval::perception::HeardSound{std::move(channels.front().samples), std::move(set)};
    });
  };
  eval::perception::ComparedFiles compared{"reference", "other", hear(reference), hear(other), {}};
  compared.comparison = eval::perception::compare_sounds(compared.reference, compared.other, how);
  return eval::perception::to_json(compared);
}

ordered_json identified(const HttpRequest& request, const ClipLimits& limits,
                        const Identify& identify) {
  Options(request).finish();
  const Clip clip(request, "", limits);
  return clip.told([&] { return identify(clip.path()); });
}

}  // namespace carillon::report::service
