// offscreen_pictures FILE: the pixels of all pictures, as this build of the library draws them.
#include "tests/render/offscreen_pictures.hpp"

#include <fstream>

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  std::ofstream file(argv[1], std::ios::binary);
  for (const carillon::core::Image& picture : carillon::render::offscreen_pictures()) {
    file.write(reinterpret_cast<const char*>(picture.pixels.data()),
               static_cast<std::streamsize>(picture.pixels.size()));
  }
  return file.good() ? 0 : 1;
}
