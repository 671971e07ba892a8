#include <fmt/format.h>

#include <span>
#include <string_view>

#include "core/error.hpp"
#include "render/frame.hpp"

namespace carillon::render {

void check(const Appearance& appearance) {
  for (const double value : {appearance.color[0], appearance.color[1], appearance.color[2],
                             appearance.roughness, appearance.metallic}) {
    if (!(value >= 0 && value <= 1)) {
      throw core::InputError(fmt::format(
          "appearance: color, roughness and metallic lie between 0 and 1, not {}", value));
    }
  }
}

namespace {

struct Look {
  std::string_view name;
  Appearance appearance;
};

constexpr double matt = 0.75;

/// Of words in materials' names.
const Look named_looks[] = {
    {"ceramic", {{0.78, 0.70, 0.60}, 0.35, 0}},   {"porcelain", {{0.86, 0.86, 0.84}, 0.18, 0}},
    {"stoneware", {{0.45, 0.38, 0.30}, 0.4, 0}},  {"terracotta", {{0.55, 0.23, 0.12}, 0.8, 0}},
    {"glass", {{0.30, 0.52, 0.46}, 0.06, 0}},     {"wood", {{0.36, 0.20, 0.09}, 0.6, 0}},
    {"spruce", {{0.62, 0.44, 0.24}, 0.6, 0}},     {"maple", {{0.64, 0.46, 0.27}, 0.55, 0}},
    {"birch", {{0.64, 0.46, 0.27}, 0.55, 0}},     {"cherry", {{0.40, 0.17, 0.08}, 0.55, 0}},
    {"mahogany", {{0.28, 0.10, 0.05}, 0.5, 0}},   {"walnut", {{0.16, 0.09, 0.05}, 0.55, 0}},
    {"plastic", {{0.10, 0.25, 0.62}, 0.42, 0}},   {"polycarbonate", {{0.50, 0.62, 0.70}, 0.15, 0}},
    {"acrylic", {{0.60, 0.68, 0.72}, 0.1, 0}},    {"iron", {{0.33, 0.31, 0.30}, 0.55, 1}},
    {"steel", {{0.64, 0.64, 0.66}, 0.28, 1}},     {"aluminium", {{0.83, 0.84, 0.85}, 0.32, 1}},
    {"aluminum", {{0.83, 0.84, 0.85}, 0.32, 1}},  {"brass", {{0.82, 0.66, 0.31}, 0.25, 1}},
    {"bronze", {{0.62, 0.42, 0.22}, 0.33, 1}},    {"copper", {{0.85, 0.45, 0.32}, 0.27, 1}},
    {"gold", {{0.95, 0.68, 0.26}, 0.2, 1}},       {"silver", {{0.91, 0.90, 0.87}, 0.2, 1}},
    {"lead", {{0.28, 0.29, 0.32}, 0.6, 1}},       {"tungsten", {{0.45, 0.44, 0.42}, 0.35, 1}},
    {"titanium", {{0.50, 0.47, 0.44}, 0.38, 1}},  {"travertine", {{0.62, 0.52, 0.40}, matt, 0}},
    {"granite", {{0.36, 0.33, 0.32}, 0.5, 0}},    {"marble", {{0.82, 0.80, 0.77}, 0.25, 0}},
    {"limestone", {{0.58, 0.53, 0.43}, matt, 0}}, {"sandstone", {{0.55, 0.42, 0.27}, 0.85, 0}},
    {"basalt", {{0.07, 0.07, 0.08}, matt, 0}},    {"brick", {{0.42, 0.16, 0.10}, 0.85, 0}},
    {"gypsum", {{0.82, 0.81, 0.78}, 0.85, 0}},    {"carbon", {{0.03, 0.03, 0.035}, 0.3, 0}},
    {"cork", {{0.42, 0.27, 0.14}, 0.85, 0}},      {"bone", {{0.76, 0.70, 0.56}, 0.5, 0}},
    {"ice", {{0.66, 0.78, 0.84}, 0.08, 0}},
};

/// Of groups, where no word of the name is known.
const Look group_looks[] = {
    {"metal", {{0.60, 0.60, 0.60}, 0.35, 1}}, {"wood", {{0.50, 0.31, 0.15}, 0.6, 0}},
    {"stone", {{0.45, 0.44, 0.41}, matt, 0}}, {"ceramic", {{0.80, 0.79, 0.76}, 0.3, 0}},
    {"glass", {{0.30, 0.52, 0.46}, 0.06, 0}}, {"plastic", {{0.75, 0.74, 0.70}, 0.42, 0}},
    {"rubber", {{0.03, 0.03, 0.03}, 0.7, 0}},
};

const Appearance* find_look(std::span<const Look> looks, std::string_view name) {
  for (const Look& look : looks)
    if (look.name == name) return &look.appearance;
  return nullptr;
}

}  // namespace

Appearance appearance_of(const std::string& material, const std::string& group) {
  // What a thing is comes last: lead_glass is glass.
  std::string_view rest = material;
  while (!rest.empty()) {
    const std::size_t before = rest.rfind('_');
    const bool first = before == std::string_view::npos;
    if (const Appearance* look = find_look(named_looks, first ? rest : rest.substr(before + 1)))
      return *look;
    rest = first ? std::string_view() : rest.substr(0, before);
  }
  const Appearance* look = find_look(group_looks, group);
  return look != nullptr ? *look : Appearance{};
}

}  // namespace carillon::render
