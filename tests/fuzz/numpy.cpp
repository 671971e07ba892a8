#include "core/npy.hpp"
#include "tests/fuzz/fuzz.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace carillon;
  const fuzz::InputFile file(fuzz::text_of(data, size));
  fuzz::expect_value_or_error([&] {
    const core::NpyFile array(file.path());
    array.read_rows(0, array.rows());
  });
  return 0;
}
