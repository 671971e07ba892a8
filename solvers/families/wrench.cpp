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

/// Two thirds of the way is handle, a third head.
mesh::ShapeExtent wrench_extent(const mesh::GeneratedShape& shape) {
  const double width =
      (2 * parameter(shape, "handle_width") + 1.3 * parameter(shape, "head_radius")) / 3;
  mesh::ShapeExtent extent =
      box_extent({parameter(shape, "length"), width, parameter(shape, "thickness")});
  extent.mirror_planes = 1;
  extent.is_halved = true;
  return extent;
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
          nullptr,
          nullptr,
          wrench_extent};
}

}  // namespace carillon::solvers::families
