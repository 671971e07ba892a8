#include "solvers/families/families.hpp"
#include "tests/fuzz/fuzz.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace carillon;
  const fuzz::InputFile file(fuzz::text_of(data, size));
  fuzz::expect_value_or_error(
      [&] { solvers::families::profile_from_svg(file.path(), {.height = 0.1}); });
  return 0;
}
