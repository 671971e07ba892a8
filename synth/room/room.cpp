#include "synth/room/room.hpp"

#include <fmt/format.h>

#include <cmath>

#include "core/error.hpp"
#include "core/hash.hpp"
#include "core/random.hpp"
#include "synth/room/air_filter.hpp"

namespace carillon::synth::room {

namespace {

/// Changes when the same options give another response.
constexpr const char* version = "room response 2";

std::string text_of(const RoomOptions& options) {
  std::string text =
      fmt::format("{} {:a} {} {}", version, options.sample_rate, options.order, options.seed);
  const auto add = [&text](const auto& values) {
    for (const double v : values) text += fmt::format(" {:a}", v);
  };
  add(options.size);
  add(options.source);
  add(options.listener);
  for (const OctaveValues& wall : options.walls) add(wall);
  return text + fmt::format(" {:a} {:a}", options.air.temperature, options.air.humidity);
}

}  // namespace

std::string room_key(const RoomOptions& options) {
  return core::sha256(text_of(options) + fmt::format(" {} {:d} {:d}", options.count,
                                                     options.with_images, options.with_tail));
}

TailPlan room_tail_plan(const RoomOptions& options) {
  check_room(options.size, options.source, options.listener, options.order);
  if (!(options.sample_rate > 0) || !std::isfinite(options.sample_rate)) {
    throw core::InputError(fmt::format("a room at a sample rate of {} Hz", options.sample_rate));
  }
  // One order more, to know when the first image that is left out would arrive.
  std::vector<ImageSource> images;
  double beyond = std::numeric_limits<double>::infinity();
  for (const ImageSource& image :
       image_sources(options.size, options.source, options.listener, options.order + 1)) {
    if (image.order <= options.order) {
      images.push_back(image);
    } else {
      beyond = std::min(beyond, image.distance);
    }
  }
  return plan_tail(options.size, images, beyond, (options.source - options.listener).norm(),
                   options.walls, options.air, octaves_below_nyquist(options.sample_rate));
}

RoomResponse room_response(const RoomOptions& options) {
  const TailPlan plan = room_tail_plan(options);
  RoomResponse response;
  response.rt60 = plan.rt60;
  response.level = plan.level;
  response.tail_start = plan.start;
  response.tail_db = plan.energy_db();
  response.join_db = plan.join_db;
  response.air = air_response(plan.direct, options.air, options.sample_rate);
  if (options.with_images && options.order > 0) {
    response.images =
        image_response(image_sources(options.size, options.source, options.listener, options.order),
                       plan.direct, options.walls, options.air, options.sample_rate, options.count,
                       ReflectionFilters(options.sample_rate));
  }
  while (!response.images.empty() && response.images.back() == 0) response.images.pop_back();
  if (options.with_tail && response.tail_db >= inaudible_tail) {
    response.tail = reverberant_tail(plan, options.sample_rate, options.count, options.seed,
                                     core::stable_hash(text_of(options)));
  }
  return response;
}

}  // namespace carillon::synth::room
