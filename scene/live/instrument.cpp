#include "scene/live/instrument.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <numeric>
#include <set>

#include "core/error.hpp"
#include "core/text.hpp"
#include "scene/strikes.hpp"

namespace carillon::scene::live {

namespace {

using core::InputError;

double checked(double value, const char* what) {
  if (value >= 0 && value < 1e12) return value;
  throw InputError(fmt::format("{} must be at least 0 and below 1e12, not {}", what, value));
}

}  // namespace

Instrument::Instrument(std::vector<LiveObject> objects, const UsualStrike& usual,
                       double sample_rate, double gain)
    : player_(objects.empty() ? 1 : objects.front().readout.delays.size(), sample_rate, gain),
      objects_(std::move(objects)),
      hands_(objects_.size(), 0.0),
      samplers_(objects_.size()),
      usual_(usual) {
  if (objects_.empty()) throw InputError("there are no objects to play", "name at least one");
  std::set<std::string> names;
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    const LiveObject& object = objects_[i];
    if (!names.insert(object.name).second) {
      throw InputError(fmt::format("two objects are called {}", object.name));
    }
    player_.add_body(object.modes->eigenvalues, object.decay_rates, object.readout);
    if (!object.supports.empty()) hold(i, 0);
  }
}

std::size_t Instrument::modes() const {
  return std::accumulate(
      objects_.begin(), objects_.end(), std::size_t{0},
      [](std::size_t sum, const LiveObject& object) { return sum + object.modes->size(); });
}

std::vector<std::size_t> Instrument::named(const std::string& object) const {
  std::vector<std::size_t> all;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < objects_.size(); ++i) {
    if (object == "*") all.push_back(i);
    if (objects_[i].name == object) return {i};
    names.push_back(objects_[i].name);
  }
  if (object == "*") return all;
  std::size_t number = 0;
  const auto [end, error] = std::from_chars(object.data(), object.data() + object.size(), number);
  if (error == std::errc() && end == object.data() + object.size()) {
    if (number < objects_.size()) return {number};
    throw InputError(
        fmt::format("there is no object {}: they go from 0 to {}", object, objects_.size() - 1));
  }
  const std::string near = core::nearest_name(object, names);
  throw InputError(fmt::format("there is no object \"{}\"", object),
                   near.empty()
                       ? fmt::format("they are called as {}, or by number from 0", names.front())
                       : fmt::format("did you mean \"{}\"?", near));
}

void Instrument::apply(const Request& request) {
  if (request.kind == Request::Kind::stop) return player_.stop(request.time);
  const std::vector<std::size_t> objects = named(request.object);
  const std::lock_guard lock(mutex_);
  for (const std::size_t object : objects) {
    if (request.kind == Request::Kind::strike) {
      strike(object, request);
      continue;
    }
    if (request.kind == Request::Kind::damp) {
      hands_[object] = checked(request.amount, "a hand's amount");
    } else {
      std::vector<LiveSupport>& supports = objects_[object].supports;
      if (request.support < 0 || static_cast<std::size_t>(request.support) >= supports.size()) {
        throw InputError(fmt::format("{} has no support {}: it has {}", objects_[object].name,
                                     request.support, supports.size()),
                         "supports of the scene are counted from 0; add some with --set "
                         "supports.contacts=[...]");
      }
      LiveSupport changed = supports[static_cast<std::size_t>(request.support)];
      changed.on = request.on.value_or(changed.on || request.stiffness || request.damping);
      changed.stiffness = checked(request.stiffness.value_or(changed.stiffness), "a stiffness");
      changed.damping = checked(request.damping.value_or(changed.damping), "a damping");
      supports[static_cast<std::size_t>(request.support)] = std::move(changed);
    }
    hold(object, request.time);
  }
}

void Instrument::strike(std::size_t index, const Request& request) {
  const LiveObject& object = objects_[index];
  synth::modal::Strike strike;
  strike.point = object.place;
  if (request.position) {
    if (!samplers_[index]) {
      samplers_[index] = std::make_unique<synth::modal::SurfaceSampler>(object.modes->surface);
    }
    strike.point = nearest_point(*samplers_[index], object.modes->surface, *request.position);
  } else if (request.place && !object.places.empty()) {
    strike.point = object.places[static_cast<std::size_t>(*request.place) % object.places.size()];
  }
  strike.direction =
      request.direction ? *request.direction
                        : Vec3(-synth::modal::frame_at(object.modes->surface, strike.point).normal);
  const double length = strike.direction.norm();
  if (!(length > 0) || !std::isfinite(length)) throw InputError("the direction has no length");
  strike.direction /= length;
  strike.impulse = request.strength * request.impulse.value_or(usual_.impulse);
  if (!std::isfinite(strike.impulse)) throw InputError("the impulse is not finite");
  strike.force.duration = request.contact.value_or(usual_.contact);
  if (!(strike.force.duration >= 0 && strike.force.duration <= longest_live_contact)) {
    throw InputError(fmt::format("a contact lasts from 0 to {} s, not {} s", longest_live_contact,
                                 strike.force.duration));
  }
  const synth::modal::RingDown rings =
      synth::modal::ring_down(*object.modes, object.decay_rates, strike, object.readout);
  player_.strike(index, rings.excitation, strike.force, request.time);
}

void Instrument::hold(std::size_t index, const std::optional<double>& time) {
  const LiveObject& object = objects_[index];
  std::vector<double> eigenvalues = object.modes->eigenvalues;
  std::vector<double> decay_rates = object.decay_rates;
  for (std::size_t i = 0; i < eigenvalues.size(); ++i) {
    decay_rates[i] += hands_[index];
    for (const LiveSupport& support : object.supports) {
      if (!support.on) continue;
      const double unit = support.unit[static_cast<Eigen::Index>(i)];
      decay_rates[i] += support.damping * unit / 2;
      eigenvalues[i] += support.stiffness * unit;
    }
  }
  player_.change(index, eigenvalues, decay_rates, time);
}

}  // namespace carillon::scene::live
