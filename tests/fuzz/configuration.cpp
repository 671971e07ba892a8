#include "dataset/configuration/configuration.hpp"
#include "dataset/sweep/sweep.hpp"
#include "eval/accuracy/accuracy_config.hpp"
#include "tests/fuzz/fuzz.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace carillon;
  std::string text(fuzz::text_of(data, size));
  // A first line `--set KEY=VALUE` is the command line's.
  std::vector<std::string> overrides;
  if (text.starts_with("--set ")) {
    const auto end = std::min(text.find('\n'), text.size());
    overrides.push_back(text.substr(6, end - 6));
    text.erase(0, end);
  }
  // Files that a configuration names are looked for in a folder that there is not.
  const std::string file = "/nowhere/input.yaml";
  fuzz::expect_value_or_error([&] {
    dataset::configuration::read_build_config(text, file, overrides, scene::effects(), false);
  });
  fuzz::expect_value_or_error([&] { eval::accuracy::read_accuracy_config(text, file, overrides); });
  fuzz::expect_value_or_error([&] { dataset::sweep::read_sweep(text, file, overrides); });
  return 0;
}
