#include "dataset/samples/cast.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <set>

#include "core/error.hpp"
#include "core/random.hpp"
#include "synth/motion/convex_hull.hpp"
#include "synth/surface/rigid_body.hpp"

namespace carillon::dataset::samples {

namespace {

constexpr double ground_depth = 0.5;  ///< thickness of the slab that the ground is [m]
constexpr double roundness = 1e-4;    ///< of a ball: spread of its radii over the largest

/// Radius of a body whose surface is everywhere as far from its centre of mass; 0: no ball.
double ball_radius(const solvers::modes::ModeSurface& surface, const Vec3& centre) {
  double minimum = std::numeric_limits<double>::infinity(), maximum = 0;
  for (const Vec3& node : surface.nodes) {
    const double r = (node - centre).norm();
    minimum = std::min(minimum, r);
    maximum = std::max(maximum, r);
  }
  return maximum - minimum <= roundness * maximum ? maximum : 0;
}

/// A body of several regions turns about where its weight is.
synth::surface::RigidBody rigid_of(const ShapeModes& shape, std::size_t variant, double size,
                                   const solvers::modes::Modes& modes) {
  std::vector<synth::surface::RegionMoments> regions = shape.moments();
  if (regions.empty()) return synth::surface::rigid_body(modes);
  std::vector<double> densities;
  for (const synth::material::Material& material : shape.materials(variant)) {
    densities.push_back(material.elastic.density);
  }
  for (synth::surface::RegionMoments& region : regions) {
    region.volume *= size * size * size;
    region.centroid *= size;
    region.spread *= size * size;
  }
  return synth::surface::rigid_body(regions, densities, modes.mass);
}

std::size_t variant_of(const plan::Shape& shape, const std::string& material, double size) {
  for (std::size_t v = 0; v < shape.variants.size(); ++v) {
    if (shape.variants[v].material == material && shape.variants[v].size == size) return v;
  }
  throw core::InputError(fmt::format("{} is not built of {} at size {}", shape.id, material, size));
}

}  // namespace

const Actor& Actors::of(std::size_t shape, const std::string& material, double size,
                        const std::shared_ptr<const scene::SupportsConfig>& held_by) {
  std::unique_ptr<Actor>& actor = actors_[{shape, material, size, held_by.get()}];
  if (actor) return *actor;
  const plan::Shape& body = plan_.shapes[shape];
  auto found = shapes_.find(shape);
  if (found == shapes_.end()) {
    found = shapes_.emplace(shape, ShapeModes(config_, body, folders_)).first;
  }
  const ShapeModes& modes = found->second;
  const std::size_t v = variant_of(body, material, size);
  auto made = std::make_unique<Actor>();
  made->modes = modes.of(v);
  made->rigid = rigid_of(modes, v, size, made->modes);
  made->ball_radius = ball_radius(made->modes.surface, made->rigid.centre);
  made->hulls = modes.hulls();
  for (auto& hull : made->hulls) {
    for (Vec3& p : hull) p *= size;
  }
  if (made->hulls.empty()) {
    throw core::InputError(fmt::format("{}: its modes file has no hulls", body.id),
                           "it was made before the configuration had a motion: build again");
  }
  made->surface = solvers::modes::flatten(made->modes.surface);
  made->box = solvers::mesh::bounding_box(made->modes.surface.nodes);
  made->ringing = chain_.prepare_moving(body.id, fmt::format("{}/{}/{}", body.id, material, size),
                                        made->modes, modes.materials(v), held_by.get());
  made->looks = looks_of(body, modes.materials(v), modes.looks(), made->modes.surface);
  if (config_.scene.runs("click")) {
    made->click = synth::contact::rigid_source(made->modes.surface, made->modes.mass);
  }
  actor = std::move(made);
  return *actor;
}

namespace {

Vec3 between(const scene::motion::Ranges3& ranges, core::RandomStream& random) {
  Vec3 value;
  for (std::size_t k = 0; k < 3; ++k) {
    value[static_cast<Eigen::Index>(k)] = random.uniform(ranges[k].low, ranges[k].high);
  }
  return value;
}

/// Shapes of an entry of `objects`.
std::vector<std::size_t> instances(const configuration::BuildConfig& config,
                                   const plan::BuildPlan& plan, const std::string& object) {
  std::vector<std::size_t> shapes;
  for (std::size_t s = 0; s < plan.shapes.size(); ++s) {
    if (config.objects[plan.shapes[s].source].object.name == object) shapes.push_back(s);
  }
  return shapes;
}

}  // namespace

bool held_out(const configuration::BuildConfig& config, const plan::BuildPlan& plan,
              const std::string& object) {
  std::set<std::string> parts;
  for (const std::size_t s : instances(config, plan, object)) {
    parts.insert(plan.shapes[s].split_shape);
  }
  return parts.size() == config.split.names().size();
}

std::vector<Role> draw_roles(const configuration::BuildConfig& config, const plan::BuildPlan& plan,
                             std::uint64_t simulation_id, const std::string& part) {
  std::vector<Role> roles;
  for (const scene::motion::CastBody& body : config.motion->bodies) {
    core::RandomStream random(config.seed, simulation_id, "motion." + body.name);
    Role role;
    role.name = body.name;
    std::vector<std::size_t> shapes = instances(config, plan, body.object);
    if (held_out(config, plan, body.object)) {
      std::erase_if(shapes, [&](std::size_t s) { return plan.shapes[s].split_shape != part; });
    }
    role.shape = shapes[random.index(shapes.size())];
    // Physical groups have one set of materials between them.
    role.material = body.materials.empty() ? plan.shapes[role.shape].variants.front().material
                                           : body.materials[random.index(body.materials.size())];
    role.size = body.size;
    role.start.pose.origin = between(body.at, random);
    const Vec3 turn = between(body.turn, random);
    role.start.pose.turn = Eigen::AngleAxisd(turn.z(), Vec3::UnitZ()) *
                           Eigen::AngleAxisd(turn.y(), Vec3::UnitY()) *
                           Eigen::AngleAxisd(turn.x(), Vec3::UnitX());
    role.start.velocity = between(body.velocity, random);
    role.start.spin = between(body.spin, random);
    role.release = random.uniform(body.release.low, body.release.high);
    roles.push_back(std::move(role));
  }
  return roles;
}

namespace {

/// Faces do not know their region: of several materials the most compliant is met, as by strikers.
solvers::elements::Elastic softest(const std::vector<synth::material::Material>& materials) {
  const auto modulus = [](const synth::material::Material& m) {
    return m.elastic.youngs_modulus / (1 - m.elastic.poisson_ratio * m.elastic.poisson_ratio);
  };
  return std::min_element(materials.begin(), materials.end(),
                          [&](const auto& a, const auto& b) { return modulus(a) < modulus(b); })
      ->elastic;
}

void set_surface(synth::motion::MovingBody& body, const scene::motion::SurfaceConfig& surface) {
  body.friction = surface.friction;
  body.rolling_friction = surface.rolling_friction;
  body.restitution = surface.restitution;
}

/// Says whose texture it is that cannot be.
template <class Make>
render::maps::TexturedFace textured(const std::string& body, const Make& make) {
  try {
    return make();
  } catch (const core::InputError& error) {
    throw core::InputError(fmt::format("motion: the texture of {}: {}", body, error.message()),
                           error.hint());
  }
}

synth::motion::MovingBody make_ground(const configuration::BuildConfig& config,
                                      scene::motion::Textures& textures) {
  const scene::motion::GroundConfig& ground = *config.motion->ground;
  synth::motion::MovingBody body;
  body.name = "ground";
  body.fixed = true;
  set_surface(body, ground.surface);
  const solvers::elements::Elastic elastic =
      synth::material::parse_material(ground.material, config.own_materials).elastic;
  body.youngs_modulus = elastic.youngs_modulus;
  body.poisson_ratio = elastic.poisson_ratio;
  const double half = ground.side / 2;
  const solvers::mesh::Box box{{-half, -half, -ground_depth}, {half, half, 0}};
  std::vector<Vec3> corners;
  for (int k = 0; k < 8; ++k) {
    corners.emplace_back(k & 1 ? box.high.x() : box.low.x(), k & 2 ? box.high.y() : box.low.y(),
                         k & 4 ? box.high.z() : box.low.z());
  }
  body.hulls.push_back(std::move(corners));
  body.rigid.mass = 1;
  body.rigid.inertia = Vec3::Ones();
  body.rigid.centre = {0, 0, -ground_depth / 2};
  if (ground.texture) {
    body.texture = textured("ground", [&] { return textures.on(*ground.texture, box); });
  }
  return body;
}

synth::motion::MovingBody make_body(const scene::motion::CastBody& cast, const Role& role,
                                    const Actor& actor, scene::motion::Textures& textures) {
  synth::motion::MovingBody body;
  body.name = role.name;
  body.rigid = actor.rigid;
  body.hulls = actor.hulls;
  if (cast.one_hull && body.hulls.size() > 1) {
    std::vector<Vec3> all;
    for (const auto& hull : actor.hulls) all.insert(all.end(), hull.begin(), hull.end());
    body.hulls = {synth::motion::convex_hull(all).vertices};
  }
  body.ball_radius = actor.ball_radius;
  body.fixed = cast.fixed;
  set_surface(body, cast.surface);
  const solvers::elements::Elastic elastic = softest(*actor.ringing.materials);
  body.youngs_modulus = elastic.youngs_modulus;
  body.poisson_ratio = elastic.poisson_ratio;
  body.curvature = 1 / (actor.ball_radius > 0 ? actor.ball_radius : cast.edge_radius);
  if (cast.texture) {
    body.texture =
        textured(cast.name, [&] { return textures.on(*cast.texture, actor.box, &actor.surface); });
  }
  body.start = role.start;
  body.release = role.release;
  // `at` is where the box's centre goes.
  const Vec3 middle = 0.5 * (actor.box.low + actor.box.high);
  body.start.pose.origin = role.start.pose.origin - role.start.pose.turn * middle;
  return body;
}

}  // namespace

SimulationStage set_stage(const configuration::BuildConfig& config, const std::vector<Role>& roles,
                          Actors& actors, scene::motion::Textures& textures) {
  const scene::motion::MotionConfig& motion = *config.motion;
  SimulationStage stage;
  if (motion.ground) {
    stage.names.push_back("ground");
    stage.actors.push_back(nullptr);
    stage.moving.push_back(make_ground(config, textures));
    stage.sounding.emplace_back();
  }
  std::map<std::string, std::size_t> numbers;
  for (std::size_t b = 0; b < roles.size(); ++b) {
    const Role& role = roles[b];
    const scene::motion::CastBody& cast = motion.bodies[b];
    const Actor& actor = actors.of(role.shape, role.material, role.size, cast.held_by);
    numbers[role.name] = stage.names.size();
    stage.names.push_back(role.name);
    stage.actors.push_back(&actor);
    stage.moving.push_back(make_body(cast, role, actor, textures));
    synth::motion::SoundingBody sounding;
    sounding.modes = actor.ringing.modes;
    sounding.decay_rates = actor.ringing.decay_rates;
    sounding.field = actor.ringing.field.get();
    sounding.rests = synth::support::parse_support(cast.rests);
    if (!cast.fixed) sounding.click = actor.click;
    stage.sounding.push_back(std::move(sounding));
  }
  for (const scene::motion::CastString& string : motion.strings) {
    const std::size_t body = numbers.at(string.body);
    const Actor& actor = *stage.actors[body];
    const Vec3 at = 0.5 * (actor.box.low + actor.box.high) + string.at;
    stage.sounding[body].strings.push_back(
        {stage.strings.size(), at, string.anchor, synth::support::parse_support(string.rests)});
    stage.strings.push_back({body, at, string.anchor, string.length});
  }
  return stage;
}

}  // namespace carillon::dataset::samples
