#include "core/audio.hpp"
#include "tests/fuzz/fuzz.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace carillon;
  const fuzz::InputFile file(fuzz::text_of(data, size));
  fuzz::expect_value_or_error([&] { core::read_audio_header(file.path()); });
  fuzz::expect_value_or_error([&] { core::read_audio(file.path()); });
  return 0;
}
