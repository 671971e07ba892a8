#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <memory>

#include "core/numbers.hpp"
#include "core/random.hpp"
#include "dataset/samples/samples_task.hpp"
#include "dataset/samples/shape_modes.hpp"
#include "scene/chain.hpp"
#include "scene/solved_object.hpp"
#include "scene/strikes.hpp"

namespace carillon::dataset::samples {

struct SampleMaker::Impl {
  const configuration::BuildConfig& config;
  const plan::Shape& shape;
  ShapeModes modes;
  synth::modal::SurfaceSampler sampler;  ///< on the object at size 1

  scene::SoundChain chain;

  /// An object at its size: what points into the variant stays where it is.
  struct Ready {
    solvers::modes::Modes modes;
    scene::RingingObject object;
  };
  std::vector<std::unique_ptr<Ready>> ready;  ///< per variant

  Impl(const configuration::BuildConfig& build, const plan::Shape& object,
       const BuildFolders& folders, core::Trace& trace)
      : config(build),
        shape(object),
        modes(build, object, folders),
        sampler(modes.surface()),
        chain(build.scene, folders.cache, trace),
        ready(object.variants.size()) {}

  const Ready& variant(std::size_t v) {
    if (!ready[v]) {
      auto made = std::make_unique<Ready>();
      made->modes = modes.of(v);
      made->object = chain.prepare(shape.id, plan::object_name(shape.id, shape.variants[v]),
                                   made->modes, modes.materials(v));
      ready[v] = std::move(made);
    }
    return *ready[v];
  }

  /// The point belongs to the strike's number, so that a strike held out is held out in every
  /// material and size; force and duration belong to the sample.
  void draw_strike(const plan::Sample& sample, scene::Sound& sound) const {
    const scene::StrikeConfig& strikes = config.scene.strikes;
    scene::KnownStrike known;
    if (!strikes.given.empty()) {
      const scene::GivenStrike& given = strikes.given[static_cast<std::size_t>(sample.strike)];
      // A point for every shape lies on none of them, but it is not in other units either.
      const bool for_all = given.shape.empty() || given.shape == "*";
      known = {.position = given.position,
               .direction = given.direction,
               .impulse = given.impulse,
               .contact_time = given.contact_time,
               .tolerance = for_all ? 1.0 : scene::usual_tolerance};
    }
    const scene::StrikeDraw draw{
        .seed = config.seed,
        .place = core::stable_hash(fmt::format("{}/{}", shape.id, sample.strike)),
        .force = sample.id};
    scene::draw_strike(strikes, modes.surface(), sampler, draw, known, sound);
  }

  /// Rooms and noises of different parts of either split have nothing in common.
  void set_part(const plan::Sample& sample, scene::Sound& sound) const {
    const std::vector<std::string> parts = config.split.names();
    const auto index = [&](const std::string& part) {
      return static_cast<std::size_t>(std::find(parts.begin(), parts.end(), part) - parts.begin());
    };
    sound.parts = config.scene.parts;
    sound.part = index(shape.split_shape) * parts.size() +
                 index(plan::split_strike(config, shape, sample.strike));
  }

  /// A sample's sound before the effects.
  scene::Sound struck(const plan::Sample& sample) {
    scene::Sound sound;
    sound.object = &variant(sample.variant).object;
    sound.seed = config.seed;
    sound.id = sample.id;
    set_part(sample, sound);
    draw_strike(sample, sound);
    return sound;
  }
};

SampleMaker::SampleMaker(const configuration::BuildConfig& config, const plan::Shape& shape,
                         const BuildFolders& folders, core::Trace& trace)
    : impl_(std::make_unique<Impl>(config, shape, folders, trace)) {}

SampleMaker::~SampleMaker() = default;

const std::vector<synth::material::Material>& SampleMaker::materials(std::size_t variant) const {
  return impl_->modes.materials(variant);
}

double SampleMaker::size(std::size_t variant) const {
  return impl_->modes.size(variant);
}

synth::modal::RingDown SampleMaker::ring(const plan::Sample& sample) {
  scene::Sound sound = impl_->struck(sample);
  impl_->chain.ring(sound);
  return std::move(sound.rings);
}

SampleResult SampleMaker::make(const plan::Sample& sample, core::Columns* record) {
  const core::TimeLimit clock = configuration::sample_clock(impl_->config.limits);
  const Impl::Ready& variant = impl_->variant(sample.variant);
  SampleResult result;
  result.sound = impl_->struck(sample);
  scene::Sound& sound = result.sound;
  sound.record = record;
  const scene::Scene& scene = impl_->config.scene;
  scene::draw_repeats(scene.strikes.repeats, scene.audio.sample_rate, sound);
  impl_->chain.make(sound);
  if (clock.passed()) clock.refuse();
  result.frame = synth::modal::frame_at(variant.modes.surface, sound.strike.point);
  result.complete_to_hz = variant.modes.certificate.complete_to_hz;
  for (const double cents : variant.object.modes->pitch_errors) {
    result.pitch_error = std::max(result.pitch_error, cents);
  }
  result.peak = core::peak(sound.audio);
  return result;
}

}  // namespace carillon::dataset::samples
