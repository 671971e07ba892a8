#include "scene/support_config.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <string>

namespace carillon::scene {

namespace {

using core::Dimension;

constexpr double usual_contact_height = 5e-4;  ///< [m]

std::vector<Vec3> read_points(core::ConfigNode& node, const std::string& key) {
  const auto values = node.quantities(key, Dimension::length);
  if (values.empty() || values.size() % 3 != 0) {
    node.fail(key, fmt::format("{} numbers are no list of points", values.size()),
              "three for each point, one after the other: [x1, y1, z1, x2, y2, z2]");
  }
  std::vector<Vec3> points;
  for (std::size_t k = 0; k < values.size(); k += 3) {
    points.emplace_back(values[k], values[k + 1], values[k + 2]);
  }
  return points;
}

void read_place(core::ConfigNode& node, SupportConfig& support) {
  using Place = SupportConfig::Place;
  const std::vector<std::pair<std::string, Place>> places = {{"at", Place::at},
                                                             {"count", Place::random},
                                                             {"lowest", Place::lowest},
                                                             {"along", Place::along}};
  std::string chosen;
  for (const auto& [key, place] : places) {
    if (!node.has(key)) continue;
    if (place == Place::random && node.has("along")) continue;  // as many points along that line
    if (!chosen.empty()) {
      node.fail(key, fmt::format("a contact lies at one kind of place, and {} is given", chosen),
                "make it two contacts");
    }
    chosen = key;
    support.place = place;
  }
  if (chosen.empty()) {
    node.fail("", "where does it touch the object?",
              "give one of at: [x, y, z], count: N (random places), lowest: true, or "
              "along: [x1, y1, z1, x2, y2, z2]");
  }
  switch (support.place) {
    case Place::at:
      support.points = read_points(node, "at");
      support.radius = node.not_negative("radius", Dimension::length, 0);
      break;
    case Place::random:
      support.count = static_cast<int>(node.integer("count", 1, 1000));
      if (node.has("pool")) {
        support.pool = static_cast<int>(node.integer("pool", 1, 10000));
        if (support.pool < support.count) {
          node.fail("pool", fmt::format("{} places cannot give each sound {} different ones",
                                        support.pool, support.count));
        }
      }
      support.radius = node.not_negative("radius", Dimension::length, 0);
      break;
    case Place::lowest: {
      if (!node.flag("lowest", true)) node.fail("lowest", "must be true, or left out");
      support.height = node.not_negative("contact_height", Dimension::length, usual_contact_height);
      const auto down = node.quantities("down", Dimension::none, 3, std::vector<double>{0, 0, -1});
      support.down = {down[0], down[1], down[2]};
      if (!(support.down.norm() > 0)) node.fail("down", "must be a direction");
      support.down.normalize();
      break;
    }
    case Place::along:
      support.points = read_points(node, "along");
      support.count = static_cast<int>(node.integer("count", 1, 1000, 16));
      break;
  }
}

/// Springs change the object's modes, which all of its sounds share; beds need an area.
void check_springs(core::ConfigNode& node, const SupportConfig& support) {
  const synth::support::SupportKind& kind = support.kind;
  const std::string key = node.has("stiffness")       ? "stiffness"
                          : node.has("bed_stiffness") ? "bed_stiffness"
                                                      : "kind";
  if (kind.gives_way() && support.place == SupportConfig::Place::random) {
    node.fail(key, "a spring is where the object is held for all of its sounds, not drawn anew",
              "give its place: at, lowest or along");
  }
  if (kind.gives_way() && support.probability < 1) {
    node.fail(key, "a spring is there in all of an object's sounds", "leave out probability");
  }
  const bool spread = support.place == SupportConfig::Place::lowest || support.radius > 0;
  if ((kind.bed_stiffness > 0 || kind.bed_resistance > 0) && !spread) {
    node.fail(node.has("kind") ? "kind" : "",
              "a bed counts by the area that touches, and points and lines have none",
              "give a radius or lowest: true, or stiffness and resistance in place of the bed");
  }
}

/// What has no kind says what it is.
void check_own(const core::ConfigNode& node, const synth::support::SupportKind& kind) {
  if (node.has("coefficient") && !node.has("friction")) {
    node.fail("friction", "is wanted beside coefficient", "0: nothing acts along the surface");
  }
  const bool linear = kind.gives_way() || kind.resistance > 0 || kind.bed_resistance > 0;
  if (!linear && !node.has("coefficient")) {
    node.fail("", "what holds the object there?",
              "give a kind, coefficient and friction, or stiffness and resistance");
  }
}

SupportConfig read_support(core::ConfigNode& node) {
  SupportConfig support;
  support.kind.name = "own";
  if (node.has("kind")) {
    const std::string name = node.text("kind");
    support.kind = core::at_key(node, "kind", [&] { return synth::support::parse_support(name); });
  }
  synth::support::SupportKind& kind = support.kind;
  kind.coefficient = node.quantity("coefficient", Dimension::none, kind.coefficient);
  kind.friction = node.quantity("friction", Dimension::none, kind.friction);
  kind.stiffness = node.not_negative("stiffness", Dimension::stiffness, kind.stiffness);
  kind.resistance = node.not_negative("resistance", Dimension::resistance, kind.resistance);
  kind.bed_stiffness = node.not_negative("bed_stiffness", Dimension::none, kind.bed_stiffness);
  kind.bed_resistance = node.not_negative("bed_resistance", Dimension::none, kind.bed_resistance);
  kind.shear = node.not_negative("shear", Dimension::none, kind.shear);
  if (kind.name == "own") check_own(node, kind);
  core::at_key(node, "coefficient", [&] { synth::support::check_support(support.kind); });
  read_place(node, support);
  support.probability = node.quantity("probability", Dimension::none, 1);
  if (!(support.probability > 0 && support.probability <= 1)) {
    node.fail("probability", "must be above 0 and at most 1");
  }
  check_springs(node, support);
  const bool grips = support.kind.name == "finger";
  if (node.flag("weight", !node.has("force") && !grips)) {
    if (node.has("force")) {
      node.fail("force", "the object's weight presses here already", "leave out weight or force");
    }
    return support;
  }
  std::optional<core::Range> usual;
  if (grips) usual = core::Range{0.3, 3};
  support.force = node.range("force", Dimension::force, usual);
  if (!(support.force->low > 0)) {
    node.fail("force", "must be positive: it is drawn uniformly in its logarithm");
  }
  return support;
}

}  // namespace

int SupportConfig::holds() const {
  switch (place) {
    case Place::at:
      return static_cast<int>(points.size());
    case Place::random:
      return count;
    default:
      return 1;
  }
}

int SupportsConfig::holds() const {
  return std::accumulate(contacts.begin(), contacts.end(), 0,
                         [](int sum, const SupportConfig& c) { return sum + c.holds(); });
}

bool SupportsConfig::fixed() const {
  return std::all_of(contacts.begin(), contacts.end(), [](const SupportConfig& c) {
    return c.place != SupportConfig::Place::random && c.probability == 1 &&
           (!c.force || c.force->low == c.force->high);
  });
}

bool SupportsConfig::pooled() const {
  return std::any_of(contacts.begin(), contacts.end(),
                     [](const SupportConfig& c) { return c.pool > 0; });
}

bool SupportsConfig::gives_way() const {
  return std::any_of(contacts.begin(), contacts.end(),
                     [](const SupportConfig& c) { return c.kind.gives_way(); });
}

SupportsConfig standing_on(const std::string& kind) {
  SupportConfig support;
  support.kind = synth::support::parse_support(kind);
  support.place = SupportConfig::Place::lowest;
  support.height = usual_contact_height;
  SupportsConfig config;
  config.contacts.push_back(std::move(support));
  return config;
}

SupportsConfig read_supports(core::ConfigNode& node, bool moves) {
  SupportsConfig config;
  config.full = node.choice("coupling", {"diagonal", "full"}, "diagonal") == "full";
  if (moves && config.full) {
    node.fail("coupling", "scenes that move take the diagonal damping", "leave out coupling");
  }
  for (core::ConfigNode& entry : node.children("contacts")) {
    config.contacts.push_back(read_support(entry));
  }
  if (config.contacts.empty()) {
    node.fail("contacts", "supports need at least one contact",
              "leave supports out for an object in free flight");
  }
  if (moves && !config.fixed()) {
    node.fail("contacts", "what is fixed is held alike in all simulations, and something is drawn",
              "give places (at, lowest or along), one force and no probability");
  }
  return config;
}

}  // namespace carillon::scene
