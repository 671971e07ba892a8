#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

namespace carillon::dataset::exporters {

/// A tar archive (ustar, pax where names are long). Equal members give equal bytes: they have no
/// time and no owner.
class TarFile {
 public:
  /// @throws FileError  cannot be written
  explicit TarFile(const std::filesystem::path& path);
  ~TarFile();
  TarFile(const TarFile&) = delete;
  TarFile& operator=(const TarFile&) = delete;

  /// @throws FileError
  void add(const std::string& name, std::string_view bytes);
  /// Ends the archive: what is not ended may be cut short.
  /// @throws FileError
  void finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace carillon::dataset::exporters
