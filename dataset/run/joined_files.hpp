#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace carillon::dataset::run {

/// What index.h5 takes from one of the files that it joins.
struct JoinedFile {
  std::map<std::string, std::uint64_t> rows;  ///< of each array
  /// Of each column of texts, one after the other, each with a zero byte behind it.
  std::map<std::string, std::string> texts;
};

/// The files that an index joins. Each is opened once, however often the index is written while
/// they grow in number. Holds some 100 bytes for each sample, its texts.
class JoinedFiles {
 public:
  /// @param folder  of the dataset, which paths are relative to
  explicit JoinedFiles(std::filesystem::path folder) : folder_(std::move(folder)) {}

  /// Opens the file when it is asked for the first time. Its arrays are those of its root, or of a
  /// modes file the objects' and appearances'.
  /// @throws FileError
  const JoinedFile& of(const std::string& file);
  /// Rows of an array. @throws FileError  the file cannot be read or has none of that name
  std::uint64_t rows(const std::string& file, const std::string& name);
  /// Adds the texts of a column. @throws FileError  likewise
  void append_texts(const std::string& file, const std::string& name,
                    std::vector<std::string>& texts);
  /// The file is another one now.
  void forget(const std::string& file) { files_.erase(file); }

 private:
  std::filesystem::path folder_;
  std::map<std::string, JoinedFile> files_;
};

/// Arrays of a modes file that the index joins: what belongs to the object as a whole.
const std::vector<std::string>& object_arrays();
/// Those that have a row for each material that the object is drawn in.
const std::vector<std::string>& appearance_arrays();

}  // namespace carillon::dataset::run
