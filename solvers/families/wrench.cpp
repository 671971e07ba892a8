#include "solvers/families/family.hpp"

namespace carillon::solvers::families {
namespace {

void check_wrench(const mesh::GeneratedShape& shape) {
  check_parameters(shape);
  const double head = parameter(shape, "head_radius"), jaw = parameter(shape, "jaw_width");
  require(jaw <= 1.4 * head, shape, "jaw_width must not exceed 1.4 head_radius");
  require(parameter(shape, "handle_width") <= 1.4 * head, shape,
          "handle_width must not exceed 1.4 head_radius");
  require(parameter(shape, "length") >= 4 * head, shape, "length must be at least 4 head_radius");
  require(parameter(shape, "thickness") <= head, shape, "thickness must not exceed head_radius");
}

}  // namespace

Family wrench_family() {
  return {"wrench",
          "flat open-ended wrench: round head with a jaw, handle with a round end",
          {{"length", 0.12, 0.3, "along x, over the handle and the head's full circle [m]"},
           {"handle_width", 0.012, 0.022, "[m]"},
           {"head_radius", 0.018, 0.03, "[m]"},
           {"jaw_width", 0.012, 0.024, "[m]"},
           {"thickness", 0.004, 0.01, "along z [m]"}},
          check_wrench,
          nullptr};
}

}  // namespace carillon::solvers::families
