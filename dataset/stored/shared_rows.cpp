#include "dataset/stored/shared_rows.hpp"

namespace carillon::dataset::stored {

const std::vector<SharedRows>& shared_rows() {
  static const std::vector<SharedRows> groups = {
      {"shapes", "shape_index", "row of the shape in the dataset"},
      {"appearances", "appearance_index", "row of the object in its material in the dataset"}};
  return groups;
}

ArrayPlace find_array(const core::Hdf5Group& index, const std::string& name) {
  if (index.has(name) && !index.is_group(name)) return {name, ""};
  for (const SharedRows& rows : shared_rows()) {
    const std::string path = std::string(rows.group) + "/" + name;
    if (index.has(rows.column) && index.has(path)) return {path, rows.column};
  }
  return {};
}

}  // namespace carillon::dataset::stored
