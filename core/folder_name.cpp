#include "core/folder_name.hpp"

#include <algorithm>
#include <filesystem>

namespace carillon::core {

namespace {

constexpr std::size_t longest = 100;

/// Bytes from 0x80 on are letters of other alphabets.
bool may_stand_in_name(char c) {
  const auto code = static_cast<unsigned char>(c);
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' ||
         c == '_' || c == '.' || code >= 0x80;
}

bool may_begin_name(char c) {
  return c != '-' && c != '.';
}

/// A file may be called what no folder should be.
std::string name_of_file(const std::string& file_name) {
  std::string name = std::filesystem::path(file_name).stem().string().substr(0, longest);
  std::replace_if(
      name.begin(), name.end(), [](char c) { return !may_stand_in_name(c); }, '-');
  name.erase(0, static_cast<std::size_t>(std::find_if(name.begin(), name.end(), may_begin_name) -
                                         name.begin()));
  return name.empty() ? "dataset" : name;
}

}  // namespace

std::string folder_name(ConfigNode& root, const std::string& file_name) {
  const std::string name = root.text("name", name_of_file(file_name));
  const char* hint =
      "a name has letters, digits, - _ and ., and begins with none of - and .; --output names "
      "another folder";
  if (name.empty()) root.fail("name", "is empty", hint);
  if (!may_begin_name(name.front()) || !std::all_of(name.begin(), name.end(), may_stand_in_name)) {
    root.fail("name", "\"" + name + "\" is no name of a folder", hint);
  }
  if (name.size() > longest) root.fail("name", "is longer than 100 characters", hint);
  return name;
}

}  // namespace carillon::core
