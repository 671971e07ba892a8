#include "eval/features/feature_table.hpp"
#include "scene/detail/given_strikes.hpp"
#include "tests/fuzz/fuzz.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace carillon;
  const fuzz::InputFile file(fuzz::text_of(data, size));
  fuzz::expect_value_or_error([&] { scene::read_given_strikes(file.path()); });
  fuzz::expect_value_or_error([&] { eval::features::read_feature_table(file.path()); });
  return 0;
}
