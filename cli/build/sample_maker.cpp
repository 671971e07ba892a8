#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>

#include "cli/body.hpp"
#include "cli/build/samples_task.hpp"
#include "core/hdf5.hpp"
#include "core/random.hpp"
#include "solvers/modes_file.hpp"

namespace carillon::cli {

using solvers::Vec3;

namespace {

constexpr double pi = 3.14159265358979323846;

/// A direction within `spread` of `axis`, uniform on that cap of the sphere.
Vec3 spread_direction(const Vec3& axis, double spread, core::RandomStream& random) {
  const double cosine = 1 - random.uniform() * (1 - std::cos(spread));
  const double sine = std::sqrt(std::max(0.0, 1 - cosine * cosine));
  const double turn = 2 * pi * random.uniform();
  const Vec3 side = axis.unitOrthogonal();
  return cosine * axis + sine * (std::cos(turn) * side + std::sin(turn) * axis.cross(side));
}

}  // namespace

struct SampleMaker::Impl {
  const BuildConfig& config;
  const Shape& shape;
  std::vector<std::vector<synth::Material>> materials;
  ModeSets sets;
  std::vector<solvers::Modes> solved;
  std::unique_ptr<synth::SurfaceSampler> sampler;  ///< on the body at size 1

  struct Ready {
    solvers::Modes modes;
    std::vector<double> decay_rates;
  };
  std::vector<std::optional<Ready>> ready;  ///< per variant

  Impl(const BuildConfig& build, const Shape& body, const BuildFolders& folders)
      : config(build), shape(body), ready(body.variants.size()) {
    const core::Hdf5Group file = core::Hdf5Group::open_file(folders.modes_file(body));
    const auto regions = file.read<std::string>("regions");
    for (const Variant& variant : body.variants) {
      materials.push_back(variant_materials(build, body, variant, regions));
    }
    sets = group_variants(materials, body.variants, build.band);
    for (std::size_t s = 0; s < sets.requests.size(); ++s) {
      solved.push_back(solvers::read_modes(file.open_group(fmt::format("set-{:03}", s))));
    }
    sampler = std::make_unique<synth::SurfaceSampler>(solved.front().surface);
  }

  const Ready& variant(std::size_t v) {
    if (!ready[v]) {
      const VariantModes& scale = sets.variants[v];
      Ready made;
      made.modes = solvers::restrict_to(
          solvers::rescale(solved[scale.set], scale.length, scale.modulus, scale.density),
          config.band);
      made.decay_rates = synth::decay_rates(made.modes, damping_of(materials[v]));
      ready[v] = std::move(made);
    }
    return *ready[v];
  }

  /// The point belongs to the strike's number, so that a strike held out is held out in every
  /// material and size; force and duration belong to the sample.
  synth::Strike strike_of(const Sample& sample) const {
    const solvers::ModeSurface& surface = solved.front().surface;
    synth::Strike strike;
    if (!config.strikes.given.empty()) {
      const GivenStrike& given = config.strikes.given[static_cast<std::size_t>(sample.strike)];
      strike.point = sampler->nearest(given.position);
      strike.direction = given.direction.value_or(-synth::frame_at(surface, strike.point).normal);
      strike.impulse = given.impulse;
      strike.force.duration = given.contact_time;
      return strike;
    }
    core::RandomStream place(config.seed,
                             core::stable_hash(fmt::format("{}/{}", shape.id, sample.strike)),
                             "strike.position");
    strike.point = sampler->sample(place);
    const Vec3 inward = -synth::frame_at(surface, strike.point).normal;
    strike.direction =
        config.strikes.spread > 0 ? spread_direction(inward, config.strikes.spread, place) : inward;
    core::RandomStream force(config.seed, sample.id, "strike.force");
    strike.impulse = force.log_uniform(config.strikes.impulse.low, config.strikes.impulse.high);
    strike.force.duration =
        force.log_uniform(config.strikes.contact_time.low, config.strikes.contact_time.high);
    return strike;
  }
};

SampleMaker::SampleMaker(const BuildConfig& config, const Shape& shape, const BuildFolders& folders)
    : impl_(std::make_unique<Impl>(config, shape, folders)) {}

SampleMaker::~SampleMaker() = default;

const std::vector<synth::Material>& SampleMaker::materials(std::size_t variant) const {
  return impl_->materials[variant];
}

SampleResult SampleMaker::make(const Sample& sample, core::Trace& trace) {
  const BuildConfig& config = impl_->config;
  const Impl::Ready& body = impl_->variant(sample.variant);
  SampleResult result;
  result.strike = impl_->strike_of(sample);
  result.frame = synth::frame_at(body.modes.surface, result.strike.point);
  result.modes = body.modes.size();
  result.complete_to_hz = body.modes.certificate.complete_to_hz;
  for (const double cents : body.modes.pitch_errors) {
    result.pitch_error = std::max(result.pitch_error, cents);
  }

  std::vector<synth::Listener> listeners;
  if (!config.listeners.empty()) {
    const solvers::Box box = solvers::bounding_box(body.modes.surface.nodes);
    const Vec3 centre = 0.5 * (box.low + box.high);
    for (const synth::Listener& l : config.listeners) listeners.push_back({centre + l.position});
  }
  synth::RingDown rings;
  {
    ++trace.effects["damping"].calls;
    if (result.strike.force.duration > 0) ++trace.effects["contact"].calls;
    std::optional<core::ScopedTimer> radiation;
    if (!listeners.empty()) radiation.emplace(trace.effects["radiation"]);
    rings =
        synth::ring_down(body.modes, body.decay_rates, result.strike,
                         listeners.empty() ? synth::point_velocity(body.modes, result.strike.point)
                                           : synth::monopole(body.modes, listeners));
  }
  result.audio_unit = rings.readout.unit;
  {
    const core::ScopedTimer timer(trace.stages["synthesize"]);
    int dropped = 0;  // at or above half the sample rate
    result.audio = synth::synthesize(rings, result.strike.force, config.audio.sample_rate,
                                     config.audio.samples(), &dropped);
    result.modes -= static_cast<std::size_t>(dropped);
  }
  for (float& value : result.audio) {
    value = static_cast<float>(value * config.audio.gain);
    result.peak = std::max(result.peak, std::abs(static_cast<double>(value)));
  }
  return result;
}

}  // namespace carillon::cli
