#include <fmt/format.h>

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

Appearance appearance_of(const std::string& material) {
  std::string_view name = material;
  constexpr std::string_view prefix = "sterling_";
  if (name.starts_with(prefix)) name.remove_prefix(prefix.size());
  if (name == "ceramic") return {{0.78, 0.70, 0.60}, 0.35, 0};
  if (name == "porcelain") return {{0.86, 0.86, 0.84}, 0.18, 0};
  if (name == "glass") return {{0.30, 0.52, 0.46}, 0.06, 0};
  if (name == "wood") return {{0.36, 0.20, 0.09}, 0.6, 0};
  if (name == "plastic") return {{0.10, 0.25, 0.62}, 0.42, 0};
  if (name == "polycarbonate") return {{0.50, 0.62, 0.70}, 0.15, 0};
  if (name == "iron") return {{0.33, 0.31, 0.30}, 0.55, 1};
  if (name == "steel") return {{0.64, 0.64, 0.66}, 0.28, 1};
  if (name == "travertine") return {{0.62, 0.52, 0.40}, 0.75, 0};
  return {};
}

}  // namespace carillon::render
