#include "cli/build/configuration.hpp"
#include "tests/fuzz/fuzz.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace carillon;
  const std::string text(fuzz::text_of(data, size));
  // Files that a configuration names are looked for in a folder that there is not.
  fuzz::expect_value_or_error(
      [&] { cli::read_build_config(text, "/nowhere/input.yaml", {}, cli::effects(), false); });
  return 0;
}
