#include <fmt/format.h>

#include <memory>
#include <string_view>

#include "cli/command_line.hpp"
#include "cli/commands.hpp"

namespace carillon::cli {

// The texts of configs/*.schema.json; see carillon_embed() in cli/CMakeLists.txt.
extern const std::string_view configuration_schema;
extern const std::string_view materials_schema;

void add_schema(Program& program, Context& context) {
  Command& command = program.add(
      "schema", "a JSON Schema of configurations, for editors and validators", Needs::nothing);
  auto document = std::make_shared<std::string>("configuration");
  command
      .option("document", *document,
              "configuration (builds, sweeps, trainings, evaluations, studies of accuracy), or "
              "materials (a materials_file)")
      .one_of({"configuration", "materials"})
      .show_default();
  command.footer(
      "Examples:\n"
      "  carillon schema > carillon.schema.json\n"
      "  check-jsonschema --schemafile carillon.schema.json mine.yaml\n"
      "A file that begins with `# yaml-language-server: $schema=carillon.schema.json` is completed "
      "and\nchecked by editors: docs/guide.md.");
  command.does([&context, document] {
    if (!context.speaks()) return;
    fmt::print("{}", *document == "materials" ? materials_schema : configuration_schema);
  });
}

}  // namespace carillon::cli
