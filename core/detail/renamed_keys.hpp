#pragma once

#include <string>
#include <vector>

namespace carillon::core {

/// What a key of an earlier version is called now.
/// @param path   of the key as it was written, e.g. `sound.scene.room.order`
/// @param known  keys of its mapping; a name that none of them begins is another document's
/// @return its name within the same mapping, e.g. `levels.tolerances`; "" where it has none
std::string renamed_key(const std::string& path, const std::vector<std::string>& known);

}  // namespace carillon::core
