#include "cli/body_options.hpp"

#include <fmt/format.h>

#include <sstream>

#include "cli/command_line.hpp"
#include "core/error.hpp"
#include "core/units.hpp"

namespace carillon::cli {

void add_body_options(Command& command, scene::BodyOptions& options) {
  command
      .option("mesh", options.mesh,
              "OBJ, OFF, PLY, STL or MSH file, or a generated shape such as "
              "bowl:radius=60mm,wall=3mm (carillon list shapes)")
      .required();
  command
      .option("--material,-m", options.material,
              "preset (carillon list materials), "
              "youngs_modulus=7.2e10,poisson_ratio=0.19,density=2700[,alpha1=6,alpha2=1e-7] "
              "(other damping: damping=hybrid,alpha1=...,alpha3=... or "
              "damping=6 + 1e-7*lambda; carillon list models), or group=preset,... for the "
              "physical groups of an MSH file")
      .required();
  command.option("--length", options.length,
                 "longest side the body is scaled to, e.g. 0.12 m (default: file in metres)");
  command.option("--thickness", options.thickness, "wall given to open sheets, e.g. 2 mm");
  command.flag("--any-size", options.any_size, "let bodies outside 1 mm to 10 m pass");
  command.option("--order", options.order, "order of the elements").range(1, 4).show_default("3");
  command.option("--element-size", options.element_size,
                 "largest edge, e.g. 5 mm (default: from thickness and curvature)");
  command.option("--min-frequency", options.min_frequency, "lowest frequency of the band")
      .show_default();
  command.option("--max-frequency", options.max_frequency, "highest frequency of the band")
      .show_default("20 kHz");
  command.option("--max-modes", options.max_modes, "at most so many modes")
      .range(1, 100000)
      .show_default();
  command
      .option("--eigen-solver,--solver", options.solver,
              "block_lanczos or krylov_schur on tetrahedra; fourier: harmonics about the axis "
              "of a generated body of revolution")
      .one_of({"block_lanczos", "krylov_schur", "fourier"})
      .show_default();
  command
      .option("--pitch-cents", options.pitch_cents,
              "refine order and element size until the worst mode's estimated pitch error is "
              "below it; begins with --order and --element-size")
      .range(solvers::pitch::least_pitch_target, 1e4);
  command
      .option("--linear-solver", options.linear_solver,
              "direct: Cholesky; iterative: multigrid, modes are then "
              "not counted; automatic: direct while it fits the memory limit")
      .one_of({"automatic", "direct", "iterative"})
      .show_default("automatic");
  command
      .option("--memory-limit", options.memory_limit,
              "of the solve, all ranks together; decides what automatic means")
      .show_default("16 GiB");
  command
      .option("--max-elements", options.max_elements,
              "more is an error that names the element size that would fit")
      .range(1, 100000000)
      .show_default("200000");
}

Vec3 parse_position(const std::string& text) {
  Vec3 position;
  std::istringstream parts(text);
  int i = 0;
  for (std::string part; std::getline(parts, part, ','); ++i) {
    if (i < 3) position[i] = core::parse_quantity(part, core::Dimension::length);
  }
  if (i != 3)
    throw core::InputError(fmt::format("\"{}\" is not a position", text), "write x,y,z in metres");
  return position;
}

}  // namespace carillon::cli
