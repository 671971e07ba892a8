#include "eval/validation/draw_sounds.hpp"

#include <utility>

namespace carillon::eval::validation {

std::vector<std::size_t> draw_sounds(const std::vector<std::vector<std::size_t>>& objects,
                                     std::size_t count, core::RandomStream& random) {
  std::vector<std::size_t> enough;
  for (std::size_t b = 0; b < objects.size(); ++b) {
    if (objects[b].size() >= count) enough.push_back(b);
  }
  if (enough.empty()) return {};
  std::vector<std::size_t> sounds = objects[enough[random.index(enough.size())]];
  for (std::size_t k = 0; k < count; ++k) {
    std::swap(sounds[k], sounds[k + random.index(sounds.size() - k)]);
  }
  sounds.resize(count);
  return sounds;
}

}  // namespace carillon::eval::validation
