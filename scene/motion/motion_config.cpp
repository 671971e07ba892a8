#include "scene/motion/motion_config.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>

#include "core/error.hpp"
#include "scene/motion/texture_config.hpp"
#include "scene/picture.hpp"
#include "synth/support/supports.hpp"

namespace carillon::scene::motion {

using core::at_key;
using core::ConfigNode;
using core::Dimension;
using core::Range;

namespace {

constexpr std::size_t max_in_masks = 255;  ///< bodies of a picture (render::Scene)

Ranges3 three(ConfigNode& node, const std::string& key, Dimension dimension) {
  Ranges3 values{};
  if (!node.has(key)) return values;
  const std::vector<Range> read = node.ranges(key, dimension, 3);
  std::copy(read.begin(), read.end(), values.begin());
  return values;
}

Vec3 point(ConfigNode& node, const std::string& key, const std::optional<Vec3>& otherwise) {
  std::optional<std::vector<double>> default_value;
  if (otherwise) default_value.emplace(otherwise->begin(), otherwise->end());
  return Vec3(node.quantities(key, Dimension::length, 3, default_value).data());
}

SurfaceConfig read_surface(ConfigNode& node) {
  SurfaceConfig surface;
  surface.friction = node.not_negative("friction", Dimension::none, surface.friction);
  surface.rolling_friction = node.not_negative("rolling_friction", Dimension::length, 0);
  surface.restitution = node.quantity("restitution", Dimension::none, surface.restitution);
  if (!(surface.restitution >= 0 && surface.restitution <= 1)) {
    node.fail("restitution", "lies between 0 (no rebound) and 1 (nothing lost)");
  }
  return surface;
}

const CastObject& find_object(const ConfigNode& node, const std::string& name,
                              const std::vector<CastObject>& objects) {
  std::vector<std::string> names;
  for (const CastObject& object : objects) {
    if (object.name == name) return object;
    names.push_back(object.name);
  }
  const std::string near = core::nearest_name(name, names);
  node.fail("object", fmt::format("no entry of objects is named \"{}\"", name),
            near.empty() ? fmt::format("there are {}", fmt::join(names, ", "))
                         : fmt::format("did you mean \"{}\"?", near));
}

/// What touches damps under its force; what bears and fixes has no such coefficient.
void check_touch(const ConfigNode& node, const std::string& rests) {
  at_key(node, "rests", [&] {
    if (synth::support::parse_support(rests).coefficient > 0) return;
    throw core::InputError(fmt::format("{} bears and fixes, it does not damp under a force", rests),
                           "write finger, string, foam or table");
  });
}

/// What holds a body that is fixed.
std::shared_ptr<const SupportsConfig> read_held_by(
    ConfigNode& node, const CastBody& body, const std::shared_ptr<const SupportsConfig>& supports) {
  if (!body.fixed) {
    if (node.has("supports")) {
      node.fail("supports", "hold what is fixed; a free body is held by what it touches",
                "write fixed: true, or leave supports out");
    }
    return nullptr;
  }
  if (node.has("supports")) {
    ConfigNode own = node.child("supports");
    return std::make_shared<const SupportsConfig>(read_supports(own, true));
  }
  if (supports) return supports;
  return std::make_shared<const SupportsConfig>(standing_on(body.rests));
}

/// Of one entry of `bodies`; `repeat` gives the further ones.
CastBody read_body(ConfigNode& node, const std::string& file_name,
                   const std::vector<CastObject>& objects) {
  CastBody body;
  body.object = node.text("object");
  const CastObject& object = find_object(node, body.object, objects);
  body.name = node.text("name", body.object);
  body.materials = node.texts("materials", object.materials);
  for (const std::string& material : body.materials) {
    if (std::find(object.materials.begin(), object.materials.end(), material) ==
        object.materials.end()) {
      node.fail("materials",
                fmt::format("the object \"{}\" is not made of {}", object.name, material),
                object.materials.empty()
                    ? std::string("its physical groups have their materials: leave this out")
                    : fmt::format("its materials are {}", fmt::join(object.materials, ", ")));
    }
  }
  body.size = node.quantity("size", Dimension::none, object.sizes.front());
  if (std::find(object.sizes.begin(), object.sizes.end(), body.size) == object.sizes.end()) {
    node.fail("size", fmt::format("the object \"{}\" has no size {}", object.name, body.size),
              fmt::format("its sizes are {}", fmt::join(object.sizes, ", ")));
  }
  body.fixed = node.flag("fixed", false);
  body.release = node.range("release", Dimension::time, Range{0, 0});
  if (!(body.release.low >= 0)) node.fail("release", "must not be negative");
  body.one_hull = node.choice("collides_as", {"pieces", "hull"}, "pieces") == "hull";
  body.at = three(node, "at", Dimension::length);
  body.turn = three(node, "turn", Dimension::angle);
  body.velocity = three(node, "velocity", Dimension::speed);
  body.spin = three(node, "spin", Dimension::none);
  const auto still = [](const Ranges3& ranges) { return ranges == Ranges3{}; };
  if (body.fixed && !(still(body.velocity) && still(body.spin) && body.release == Range{})) {
    node.fail(body.release == Range{} ? still(body.spin) ? "velocity" : "spin" : "release",
              "has no meaning for a body that is fixed");
  }
  body.surface = read_surface(node);
  body.edge_radius = node.positive("edge_radius", Dimension::length, body.edge_radius);
  body.rests = node.text("rests", body.rests);
  check_touch(node, body.rests);
  body.texture = read_texture(node, file_name, true);
  return body;
}

void shift(Ranges3& ranges, const std::vector<double>& step, int times) {
  for (std::size_t k = 0; k < 3; ++k) {
    ranges[k].low += times * step[k];
    ranges[k].high += times * step[k];
  }
}

void read_bodies(ConfigNode& node, const std::string& file_name,
                 const std::vector<CastObject>& objects,
                 const std::shared_ptr<const SupportsConfig>& supports, MotionConfig& motion) {
  std::size_t number = 0;
  for (ConfigNode& entry : node.children("bodies")) {
    CastBody first = read_body(entry, file_name, objects);
    first.held_by = read_held_by(entry, first, supports);
    first.entry = number++;
    int count = 1;
    std::vector<double> step = {0, 0, 0}, turn = {0, 0, 0};
    double later = 0;
    if (entry.has("repeat")) {
      ConfigNode repeat = entry.child("repeat");
      count = static_cast<int>(repeat.integer("count", 1, 10000));
      step = repeat.quantities("offset", Dimension::length, 3, step);
      turn = repeat.quantities("turn", Dimension::angle, 3, turn);
      later = repeat.quantity("release", Dimension::time, 0);
    }
    for (int k = 0; k < count; ++k) {
      CastBody body = first;
      if (count > 1) body.name = fmt::format("{}-{:02}", first.name, k);
      shift(body.at, step, k);
      shift(body.turn, turn, k);
      body.release.low += k * later;
      body.release.high += k * later;
      motion.bodies.push_back(std::move(body));
    }
  }
  std::set<std::string> names;
  for (const CastBody& body : motion.bodies) {
    if (!names.insert(body.name).second) {
      node.fail("bodies", fmt::format("two bodies are named \"{}\"", body.name),
                "give one of them another `name:`");
    }
  }
  if (motion.bodies.empty()) node.fail("bodies", "nothing moves", "name a body at the least");
}

void read_strings(ConfigNode& node, MotionConfig& motion) {
  for (ConfigNode& entry : node.children("strings")) {
    CastString string;
    string.body = entry.text("body");
    std::vector<std::string> names;
    for (const CastBody& body : motion.bodies) names.push_back(body.name);
    if (std::find(names.begin(), names.end(), string.body) == names.end()) {
      const std::string near = core::nearest_name(string.body, names);
      entry.fail("body", fmt::format("no body is named \"{}\"", string.body),
                 near.empty() ? fmt::format("there are {}", fmt::join(names, ", "))
                              : fmt::format("did you mean \"{}\"?", near));
    }
    if (std::any_of(motion.bodies.begin(), motion.bodies.end(),
                    [&](const CastBody& body) { return body.name == string.body && body.fixed; })) {
      entry.fail("body", fmt::format("\"{}\" is fixed: nothing needs to hold it", string.body));
    }
    string.at = point(entry, "at", Vec3::Zero());
    string.anchor = point(entry, "anchor", {});
    string.length = entry.not_negative("length", Dimension::length, 0);
    string.rests = entry.text("rests", string.rests);
    check_touch(entry, string.rests);
    motion.strings.push_back(string);
  }
}

synth::motion::LastingForceOptions read_contacts(ConfigNode node) {
  using synth::motion::ContactExcitation;
  synth::motion::LastingForceOptions contacts;
  const std::string word = node.choice(
      "excitation", {"height_profile", "texel_impulses", "solver_impulses"}, "height_profile");
  contacts.excitation = word == "texel_impulses"    ? ContactExcitation::texel_impulses
                        : word == "solver_impulses" ? ContactExcitation::solver_impulses
                                                    : ContactExcitation::height_profile;
  contacts.smoothing = node.not_negative("smoothing", Dimension::time, contacts.smoothing);
  contacts.map = node.flag("use_textures", contacts.map);
  contacts.roughness = node.not_negative("roughness", Dimension::none, contacts.roughness);
  contacts.exponent = node.quantity("exponent", Dimension::none, contacts.exponent);
  contacts.longest = node.positive("max_wavelength", Dimension::length, contacts.longest);
  if (!(contacts.exponent > 1 && contacts.exponent <= 5)) {
    node.fail("exponent", "must lie above 1 and at most at 5");
  }
  return contacts;
}

MotionCamera read_camera(ConfigNode node) {
  MotionCamera camera;
  render::SceneCamera& view = camera.view;
  view.width = view.height = 128;
  read_picture(node, view.width, view.height, view.field_of_view);
  view.eye = point(node, "eye", view.eye);
  view.target = point(node, "target", view.target);
  const Vec3 way = view.target - view.eye;
  if (!(way.norm() > 0)) node.fail("eye", "is where the target is");
  if (!(way.head<2>().norm() > 1e-6 * way.norm())) {
    node.fail("eye", "is straight above or below the target: the picture has no upper side",
              "move it by a little");
  }
  camera.rate = node.positive("rate", Dimension::frequency, camera.rate);
  camera.depth = node.flag("depth_maps", camera.depth);
  camera.masks = node.flag("masks", camera.masks);
  camera.movie = node.flag("movie", camera.movie);
  return camera;
}

StylusConfig read_stylus(ConfigNode node, const MotionConfig& motion) {
  StylusConfig stylus;
  stylus.body = node.text("body");
  const auto found = std::find_if(motion.bodies.begin(), motion.bodies.end(),
                                  [&](const CastBody& body) { return body.name == stylus.body; });
  if (found == motion.bodies.end() || !found->texture || !found->fixed) {
    node.fail("body",
              found == motion.bodies.end()
                  ? fmt::format("no body is named \"{}\"", stylus.body)
                  : fmt::format("\"{}\" is not fixed, or has no texture", stylus.body),
              "name a body with `fixed: true` and a `texture:`");
  }
  for (ConfigNode& corner : node.children("path")) {
    stylus.path.emplace_back(corner.range("u", Dimension::length),
                             corner.range("v", Dimension::length));
  }
  if (stylus.path.size() < 2) node.fail("path", "has fewer than two corners");
  stylus.speed = node.range("speed", Dimension::speed, stylus.speed);
  if (!(stylus.speed.low > 0)) node.fail("speed", "must be positive");
  synth::touch::Stylus& pen = stylus.stylus;
  pen.mass = node.positive("mass", Dimension::mass, pen.mass);
  pen.hold = node.positive("hold_stiffness", Dimension::stiffness, pen.hold);
  pen.hold_damping = node.not_negative("hold_damping", Dimension::resistance, pen.hold_damping);
  pen.stiffness = node.positive("face_stiffness", Dimension::stiffness, pen.stiffness);
  pen.damping = node.not_negative("face_damping", Dimension::resistance, pen.damping);
  pen.largest_force = node.positive("max_force", Dimension::force, pen.largest_force);
  pen.radius = node.not_negative("radius", Dimension::length, pen.radius);
  pen.press = node.not_negative("press", Dimension::force, pen.press);
  pen.friction = node.not_negative("friction", Dimension::none, pen.friction);
  return stylus;
}

GroundConfig read_ground(ConfigNode node, const std::string& file_name,
                         const std::vector<synth::material::Material>& own_materials) {
  GroundConfig ground;
  ground.material = node.text("material", "wood");
  at_key(node, "material",
         [&] { return synth::material::parse_material(ground.material, own_materials); });
  ground.side = node.positive("side", Dimension::length, ground.side);
  ground.surface = read_surface(node);
  ground.texture = read_texture(node, file_name, false);
  return ground;
}

}  // namespace

MotionConfig read_motion(ConfigNode node, const std::string& file_name,
                         const std::vector<CastObject>& objects,
                         const std::vector<synth::material::Material>& own_materials,
                         const std::shared_ptr<const SupportsConfig>& supports) {
  MotionConfig motion;
  motion.simulations = static_cast<int>(node.integer("simulations", 1, 1000000, 1));
  motion.options.time_step = node.quantity("time_step", Dimension::time, 0.001);
  if (!(motion.options.time_step >= 1e-5 && motion.options.time_step <= 0.02)) {
    node.fail("time_step", "must lie between 10 us and 20 ms");
  }
  const std::vector<double> gravity =
      node.quantities("gravity", Dimension::none, 3, std::vector<double>{0, 0, -9.80665});
  motion.options.gravity = {gravity[0], gravity[1], gravity[2]};
  motion.options.min_speed = node.not_negative("min_speed", Dimension::speed, 0.01);
  motion.options.world_radius = node.positive("world_radius", Dimension::length, 50);
  motion.state_rate = node.quantity("state_rate", Dimension::frequency, 100);
  if (!(motion.state_rate > 0 && motion.state_rate * motion.options.time_step <= 1 + 1e-9)) {
    node.fail("state_rate", "must be positive and at most one state a step");
  }
  motion.kept_strikes = static_cast<int>(node.integer("kept_strikes", 1, 100000, 256));
  motion.hertz_pulses = node.choice("pulse", {"cosine", "hertz"}, "cosine") == "hertz";
  motion.contacts = read_contacts(node.child("lasting_contacts"));
  if (node.has("camera")) motion.camera = read_camera(node.child("camera"));
  if (node.has("ground"))
    motion.ground = read_ground(node.child("ground"), file_name, own_materials);
  read_bodies(node, file_name, objects, supports, motion);
  read_strings(node, motion);
  if (node.has("stylus")) motion.stylus = read_stylus(node.child("stylus"), motion);
  const std::size_t pictured = motion.bodies.size() + (motion.stylus ? 1 : 0);
  if (motion.camera && pictured > max_in_masks) {
    node.fail("camera",
              fmt::format("{} bodies{}: pictures can tell {} apart", pictured,
                          motion.stylus ? " with the stylus" : "", max_in_masks),
              "leave out the camera, or some bodies");
  }
  return motion;
}

}  // namespace carillon::scene::motion
