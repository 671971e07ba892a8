#include "solvers/mesh/readers/detail/polygon_mesh.hpp"
#include "solvers/mesh/readers/detail/read_formats.hpp"
#include "tests/fuzz/fuzz.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace carillon;
  fuzz::expect_value_or_error([&] {
    solvers::mesh::readers::triangulate(
        solvers::mesh::readers::read_stl("input.stl", fuzz::text_of(data, size)));
  });
  return 0;
}
