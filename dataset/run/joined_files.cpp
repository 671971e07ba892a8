#include "dataset/run/joined_files.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/error.hpp"
#include "core/hdf5.hpp"

namespace carillon::dataset::run {

namespace {

JoinedFile read_joined(const std::filesystem::path& path, bool of_object) {
  JoinedFile joined;
  const core::Hdf5Group file = core::Hdf5Group::open_file(path);
  std::vector<std::string> names = of_object ? object_arrays() : file.names();
  if (of_object) names.insert(names.end(), appearance_arrays().begin(), appearance_arrays().end());
  for (const std::string& name : names) {
    if (of_object && !file.has(name)) continue;
    if (!file.is_text(name)) {
      joined.rows[name] = file.extent(name).front();
      continue;
    }
    std::string& all = joined.texts[name];
    for (const std::string& text : file.read<std::string>(name)) all.append(text).push_back('\0');
  }
  return joined;
}

template <class T>
const T& found(const std::map<std::string, T>& columns, const std::filesystem::path& path,
               const std::string& name) {
  const auto at = columns.find(name);
  if (at == columns.end()) {
    throw core::FileError(fmt::format("{}: holds no {} as other files do", path.string(), name));
  }
  return at->second;
}

}  // namespace

const std::vector<std::string>& object_arrays() {
  static const std::vector<std::string> names{"voxels", "voxel_pitch", "voxel_origin"};
  return names;
}

const std::vector<std::string>& appearance_arrays() {
  static const std::vector<std::string> names{"appearances/material", "appearances/frame"};
  return names;
}

const JoinedFile& JoinedFiles::of(const std::string& file) {
  const auto known = files_.find(file);
  if (known != files_.end()) return known->second;
  return files_.emplace(file, read_joined(folder_ / file, file.starts_with("modes/")))
      .first->second;
}

std::uint64_t JoinedFiles::rows(const std::string& file, const std::string& name) {
  return found(of(file).rows, folder_ / file, name);
}

void JoinedFiles::append_texts(const std::string& file, const std::string& name,
                               std::vector<std::string>& texts) {
  const std::string& all = found(of(file).texts, folder_ / file, name);
  for (std::size_t begin = 0; begin < all.size();) {
    const std::size_t end = all.find('\0', begin);
    texts.push_back(all.substr(begin, end - begin));
    begin = end + 1;
  }
}

}  // namespace carillon::dataset::run
