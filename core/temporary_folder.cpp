#include "core/temporary_folder.hpp"

#include <fmt/format.h>
#include <stdlib.h>

#include "core/error.hpp"

namespace carillon::core {

namespace fs = std::filesystem;

TemporaryFolder::TemporaryFolder() {
  std::string name = (fs::temp_directory_path() / "carillon-XXXXXX").string();
  if (mkdtemp(name.data()) == nullptr) {
    throw FileError(fmt::format("no folder can be made in {}", fs::temp_directory_path().string()));
  }
  path_ = name;
}

TemporaryFolder::~TemporaryFolder() {
  std::error_code error;
  fs::remove_all(path_, error);
}

}  // namespace carillon::core
