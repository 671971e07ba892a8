#include "solvers/mesh/readers/read_mesh.hpp"
#include "tests/fuzz/fuzz.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace carillon;
  const fuzz::InputFile file(fuzz::text_of(data, size));
  fuzz::expect_value_or_error([&] { solvers::mesh::readers::read_msh(file.path()); });
  return 0;
}
