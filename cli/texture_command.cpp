#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "cli/command_line.hpp"
#include "cli/commands.hpp"
#include "cli/option_values.hpp"
#include "core/error.hpp"
#include "core/units.hpp"
#include "render/maps/generated_maps.hpp"
#include "render/maps/map_image.hpp"

namespace carillon::cli {

namespace {

struct TextureOptions {
  std::string name;
  std::vector<std::string> parameters;
  int texels = 512;
  std::uint64_t seed = 0;
  bool normals = false;
  std::string output;
};

/// `size=8mm` as a number in SI; counts and exponents are plain numbers.
std::map<std::string, double> parse_parameters(const std::vector<std::string>& texts) {
  std::map<std::string, double> values;
  for (const std::string& text : texts) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos) {
      throw core::InputError(fmt::format("--set {}: no value", text), "write --set size=8mm");
    }
    values[text.substr(0, equals)] =
        option_quantity(text.substr(equals + 1), core::Dimension::length, "--set");
  }
  return values;
}

nlohmann::json write_texture(const TextureOptions& options) {
  render::maps::SurfaceMap map = render::maps::generate_map(
      options.name, parse_parameters(options.parameters), options.texels, options.seed);
  if (options.normals) map = render::maps::normal_map_of(map);
  const render::maps::MapImage image = render::maps::write_map(options.output, map);
  return {{"file", options.output}, {"columns", map.width},   {"rows", map.height},
          {"width_m", image.width}, {"depth_m", image.depth}, {"texel_m", map.texel}};
}

}  // namespace

void add_texture(Program& program, Context& context) {
  Command& command = program.add(
      "texture", "a generated map of a surface as a PNG (docs/textures.md)", Needs::nothing);
  auto options = std::make_shared<TextureOptions>();
  command.option("map", options->name, "brick, grooves, pebbles, tiles or noise").required();
  command.option("-o,--output", options->output, "PNG, 16 bits a channel").required();
  command.option("--set", options->parameters, "parameter=value (carillon list textures)")
      .one_value_each();
  command.option("--texels", options->texels, "along the longer side").show_default();
  command.option("--seed", options->seed, "of what is drawn").show_default();
  command.flag("--normals", options->normals, "a normal map (RGB) in place of a relief (RGBA)");
  command.footer(
      "Example:\n  carillon texture brick --set mortar_depth=3mm -o brick.png\n"
      "What it prints goes under `texture:` of an object, as `image:`, `image_width:` and "
      "`depth:`.");
  command.does([&context, options] {
    if (!context.speaks()) return;
    require_output_file(context, options->output);
    const nlohmann::json made = write_texture(*options);
    if (context.json) {
      fmt::print("{}\n", made.dump(2));
      return;
    }
    fmt::print("texture: {{image: {}, image_width: {} m", options->output,
               made.at("width_m").get<double>());
    if (!options->normals) fmt::print(", depth: {} m", made.at("depth_m").get<double>());
    fmt::print("}}\n");
  });
}

}  // namespace carillon::cli
