#include "dataset/samples/drawn_stylus.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "core/random.hpp"

namespace carillon::dataset::samples {

namespace {

/// The hand's way over the face in its body's coordinates, as many ticks as the clip has; it stops
/// at the path's end.
std::vector<Vec3> hand_path(const scene::motion::StylusConfig& config,
                            const render::maps::TexturedFace& face, core::RandomStream& random,
                            double rate, std::size_t ticks) {
  std::vector<Vec3> corners;
  for (const auto& [u_range, v_range] : config.path) {
    const double u = random.uniform(u_range.low, u_range.high),
                 v = random.uniform(v_range.low, v_range.high);
    if (!(u >= 0 && v >= 0 && u <= face.size.x() && v <= face.size.y())) {
      throw core::InputError(
          fmt::format("motion.stylus.path[{}]: {:.4g}, {:.4g} m is not on the face of {}, which is "
                      "{:.4g} x {:.4g} m",
                      corners.size(), u, v, config.body, face.size.x(), face.size.y()));
    }
    corners.push_back(face.origin + u * face.u + v * face.v);
  }
  std::vector<Vec3> hand =
      synth::touch::drawn_path(corners, random.uniform(config.speed.low, config.speed.high), rate);
  hand.resize(ticks, hand.back());
  return hand;
}

}  // namespace

SimulationTouch draw_stylus(const configuration::BuildConfig& config, std::uint64_t simulation_id,
                            SimulationStage& stage, synth::motion::Motion& motion,
                            const std::shared_ptr<synth::motion::TracedMaps>& traced) {
  const scene::motion::StylusConfig& stylus = *config.motion->stylus;
  const std::size_t touched = static_cast<std::size_t>(
      std::find(stage.names.begin(), stage.names.end(), stylus.body) - stage.names.begin());
  const render::maps::TexturedFace& face = *stage.moving[touched].texture;
  const synth::motion::Pose pose = motion.states.front()[touched].pose;  // it is fixed
  const double rate = 1 / motion.step;
  core::RandomStream random(config.seed, simulation_id, "motion.stylus");
  const std::vector<Vec3> hand = hand_path(stylus, face, random, rate, motion.states.size());
  const synth::touch::Touch felt =
      synth::touch::draw_stylus(face, hand, stylus.stylus, {rate, traced});

  SimulationTouch touch;
  touch.rate = rate;
  touch.limited = felt.limited;
  touch.held_back = felt.held_back;
  for (const Vec3& p : felt.hand) touch.hand.push_back(pose.to_world(p));
  for (const Vec3& p : felt.tip) touch.tip.push_back(pose.to_world(p));
  for (const Vec3& f : felt.forces) touch.forces.push_back(pose.turn * f);

  synth::motion::Motion drawn = synth::touch::motion_of(felt, face);
  const std::size_t number = stage.names.size();
  stage.names.push_back("stylus");
  stage.actors.push_back(nullptr);
  stage.moving.push_back(synth::touch::moving_stylus(stylus.stylus));
  stage.sounding.emplace_back();
  for (std::size_t k = 0; k < motion.states.size(); ++k) {
    synth::motion::BodyState state = drawn.states[k][0];
    state.pose = {pose.turn, pose.to_world(state.pose.origin)};
    state.velocity = pose.turn * state.velocity;
    motion.states[k].push_back(state);
  }
  motion.left.push_back(std::numeric_limits<double>::infinity());
  for (synth::motion::LastingContact& contact : drawn.contacts) {
    // There the stylus is the first body; here the face's has the smaller number.
    contact.bodies = {touched, number};
    for (synth::motion::ContactStep& step : contact.steps) {
      std::swap(step.points[0], step.points[1]);
      std::swap(step.sweep[0], step.sweep[1]);
      step.normal = -(pose.turn * step.normal);
      step.force = -(pose.turn * step.force);
      step.slip = -(pose.turn * step.slip);
      for (Vec3& sweep : step.sweep) sweep = pose.turn * sweep;
    }
    motion.contacts.push_back(std::move(contact));
  }
  std::stable_sort(motion.contacts.begin(), motion.contacts.end(),
                   [](const auto& a, const auto& b) { return a.first_step < b.first_step; });
  return touch;
}

solvers::mesh::SurfaceMesh pen_mesh() {
  constexpr int sides = 16;
  constexpr double pen_radius = 0.004, cone = 0.02, pen_length = 0.13, stylus_lean = 0.5;
  const Eigen::AngleAxisd lean(-stylus_lean, Vec3::UnitY());
  solvers::mesh::SurfaceMesh mesh;
  mesh.vertices.push_back(Vec3::Zero());
  mesh.vertices.push_back(lean * Vec3(0, 0, pen_length));
  for (int k = 0; k < sides; ++k) {
    const double turn = 2 * std::numbers::pi * k / sides;
    const Vec3 out(pen_radius * std::cos(turn), pen_radius * std::sin(turn), 0);
    mesh.vertices.push_back(lean * (out + cone * Vec3::UnitZ()));
    mesh.vertices.push_back(lean * (out + pen_length * Vec3::UnitZ()));
  }
  for (int k = 0; k < sides; ++k) {
    const int low = 2 + 2 * k, next = 2 + 2 * ((k + 1) % sides);
    mesh.triangles.push_back({0, next, low});
    mesh.triangles.push_back({low, next, next + 1});
    mesh.triangles.push_back({low, next + 1, low + 1});
    mesh.triangles.push_back({1, low + 1, next + 1});
  }
  return mesh;
}

}  // namespace carillon::dataset::samples
