#include "dataset/samples/detail/simulation_columns.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "dataset/samples/detail/simulation_parts.hpp"

namespace carillon::dataset::samples {

using nlohmann::json;

namespace {

constexpr double none = std::numeric_limits<double>::quiet_NaN();

/// Who plays, in the order of the bodies' numbers.
json describe_bodies(const configuration::BuildConfig& config, const plan::BuildPlan& plan,
                     const Simulation& simulation) {
  json bodies = json::array();
  const std::size_t first = config.motion->ground ? 1 : 0;
  for (std::size_t b = 0; b < simulation.stage.names.size(); ++b) {
    json body = {{"name", simulation.stage.names[b]}, {"fixed", simulation.stage.moving[b].fixed}};
    if (simulation.touch && b + 1 == simulation.stage.names.size()) {
      body["mass_kg"] = simulation.stage.moving[b].rigid.mass;  // the stylus
    } else if (b >= first) {
      const Role& role = simulation.roles[b - first];
      body["shape"] = plan.shapes[role.shape].id;
      body["material"] = role.material;
      body["size"] = role.size;
      body["mass_kg"] = simulation.stage.moving[b].rigid.mass;
    } else {
      body["material"] = config.motion->ground->material;
    }
    bodies.push_back(std::move(body));
  }
  return bodies;
}

void add_labels(const configuration::BuildConfig& config, const plan::BuildPlan& plan,
                const plan::Sample& sample, const Simulation& simulation, core::Columns& columns) {
  const json bodies = describe_bodies(config, plan, simulation);
  std::set<std::string> shapes, materials;
  for (const json& body : bodies) {
    if (!body.contains("shape")) continue;
    shapes.insert(body["shape"]);
    materials.insert(body["material"]);
  }
  const auto joined = [](const std::set<std::string>& names) {
    std::string text;
    for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
    return text;
  };
  columns.add("key", sample.key);
  columns.add("id", sample.id);
  columns.add("simulation", static_cast<std::int64_t>(sample.strike));
  columns.add("bodies", bodies.dump());
  columns.add("shape", joined(shapes));
  columns.add("material", joined(materials));
  const std::string part = split_of_simulation(config, sample);
  columns.add("split_shape", part);
  columns.add("split_strike", part);
}

void add_poses(const configuration::BuildConfig& config, const Simulation& simulation,
               core::Columns& columns) {
  const synth::motion::Motion& motion = simulation.motion;
  const std::size_t bodies = simulation.stage.names.size();
  const auto stride = static_cast<std::size_t>(
      std::max(1L, std::lround(1 / (config.motion->state_rate * motion.step))));
  std::vector<double> poses, energy;
  for (std::size_t k = 0; k < motion.states.size(); k += stride) {
    for (const synth::motion::BodyState& state : motion.states[k]) {
      const synth::motion::Pose& pose = state.pose;
      poses.insert(poses.end(), pose.origin.begin(), pose.origin.end());
      poses.insert(poses.end(), {pose.turn.w(), pose.turn.x(), pose.turn.y(), pose.turn.z()});
    }
    energy.push_back(motion.energy[k]);
  }
  const std::size_t rows = energy.size();
  columns.add<double>("poses", poses, {rows, bodies, 7});
  columns.add<double>("energy", energy, {rows});
  columns.add("pose_step", motion.step * static_cast<double>(stride));
  std::vector<double> left;
  for (const double time : motion.left) left.push_back(std::isfinite(time) ? time : none);
  columns.add<double>("left", left, {bodies});
  double overlap = 0;
  for (const synth::motion::Overlap& pair : motion.overlaps)
    overlap = std::max(overlap, pair.depth);
  columns.add("start_overlap", overlap);
  columns.add("substeps", static_cast<std::int64_t>(motion.max_substeps));
  columns.add("too_fast_at", motion.too_fast.value_or(none));
}

/// The strongest strikes, in order of time; rows beyond are NaN, bodies -1.
void add_strikes(const configuration::BuildConfig& config, const Simulation& simulation,
                 core::Columns& columns) {
  const auto rows = static_cast<std::size_t>(config.motion->kept_strikes);
  std::vector<const synth::motion::Impact*> kept;
  for (const synth::motion::Impact& impact : simulation.motion.impacts) kept.push_back(&impact);
  std::stable_sort(kept.begin(), kept.end(), [](const auto* a, const auto* b) {
    return a->impulse.squaredNorm() > b->impulse.squaredNorm();
  });
  kept.resize(std::min(kept.size(), rows));
  std::stable_sort(kept.begin(), kept.end(),
                   [](const auto* a, const auto* b) { return a->time < b->time; });
  std::vector<double> times(rows, none), points(3 * rows, none), normals(3 * rows, none),
      impulses(3 * rows, none), speeds(rows, none), durations(rows, none);
  std::vector<std::int64_t> bodies(2 * rows, -1);
  for (std::size_t k = 0; k < kept.size(); ++k) {
    const synth::motion::Impact& impact = *kept[k];
    times[k] = impact.time;
    speeds[k] = impact.speed;
    durations[k] = impact.duration;
    const Vec3 point = synth::motion::pose_at(simulation.motion, impact.bodies[0], impact.time)
                           .to_world(impact.points[0]);
    for (std::size_t i = 0; i < 3; ++i) {
      const auto axis = static_cast<Eigen::Index>(i);
      points[3 * k + i] = point[axis];
      normals[3 * k + i] = impact.normal[axis];
      impulses[3 * k + i] = impact.impulse[axis];
    }
    for (std::size_t side = 0; side < 2; ++side) {
      bodies[2 * k + side] = static_cast<std::int64_t>(impact.bodies[side]);
    }
  }
  columns.add("strikes", static_cast<std::int64_t>(simulation.motion.impacts.size()));
  columns.add<double>("strike_time", times, {rows});
  columns.add<std::int64_t>("strike_bodies", bodies, {rows, 2});
  columns.add<double>("strike_point", points, {rows, 3});
  columns.add<double>("strike_normal", normals, {rows, 3});
  columns.add<double>("strike_impulse", impulses, {rows, 3});
  columns.add<double>("strike_speed", speeds, {rows});
  columns.add<double>("strike_duration", durations, {rows});
  columns.add("lasting_contacts", static_cast<std::int64_t>(simulation.motion.contacts.size()));
}

void add_frames(const scene::motion::MotionCamera& camera, const Simulation& simulation,
                core::Columns& columns) {
  std::vector<std::uint8_t> colors, masks;
  std::vector<float> depths;
  for (const render::SceneFrame& frame : simulation.frames) {
    colors.insert(colors.end(), frame.color.pixels.begin(), frame.color.pixels.end());
    for (const float depth : frame.depth) depths.push_back(std::isfinite(depth) ? depth : 0.0f);
    masks.insert(masks.end(), frame.mask.begin(), frame.mask.end());
  }
  const auto count = static_cast<std::uint64_t>(simulation.frames.size());
  const auto height = static_cast<std::uint64_t>(camera.view.height);
  const auto width = static_cast<std::uint64_t>(camera.view.width);
  columns.add<std::uint8_t>("frames", colors, {count, height, width, 3});
  if (camera.depth) columns.add<float>("depth", depths, {count, height, width});
  if (camera.masks) columns.add<std::uint8_t>("masks", masks, {count, height, width});
  columns.add("frame_rate", camera.rate);
}

void add_touch(const SimulationTouch& touch, core::Columns& columns) {
  const auto ticks = static_cast<std::uint64_t>(touch.forces.size());
  const auto add = [&](const char* name, const std::vector<Vec3>& vectors) {
    std::vector<double> values;
    for (const Vec3& v : vectors) values.insert(values.end(), v.begin(), v.end());
    columns.add<double>(name, values, {ticks, 3});
  };
  add("touch", touch.forces);
  add("touch_tip", touch.tip);
  add("touch_hand", touch.hand);
  columns.add("touch_rate", touch.rate);
  columns.add("touch_limited", static_cast<std::int64_t>(touch.limited));
  columns.add("touch_held_back", static_cast<std::int64_t>(touch.held_back));
}

}  // namespace

void add_simulation_columns(const configuration::BuildConfig& config, const plan::BuildPlan& plan,
                            const plan::Sample& sample, const Simulation& simulation,
                            core::Columns& columns) {
  add_labels(config, plan, sample, simulation, columns);
  add_poses(config, simulation, columns);
  add_strikes(config, simulation, columns);
  if (simulation.touch) add_touch(*simulation.touch, columns);
  if (!simulation.frames.empty()) add_frames(*config.motion->camera, simulation, columns);
}

}  // namespace carillon::dataset::samples
