// How loud the samples of each material of a dataset are:
//   ./dataset carillon-demo/smoke
#include <algorithm>
#include <carillon/core/hdf5.hpp>
#include <carillon/dataset/stored/sample_audio.hpp>
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

using namespace carillon;

int main(int argc, char** argv) try {
  if (argc != 2) {
    std::fprintf(stderr, "usage: dataset FOLDER\n");
    return 2;
  }
  const auto index = core::Hdf5Group::open_file(std::filesystem::path(argv[1]) / "index.h5");
  const dataset::stored::SampleAudio audio(index);
  const auto materials = index.read<std::string>("material");

  std::map<std::string, std::vector<float>> peaks;
  for (std::size_t row = 0; row < materials.size(); ++row) {
    const std::vector<core::AudioClip> clips = audio.read(row, 1);
    float peak = 0;
    for (const float value : clips.front().samples) peak = std::max(peak, std::abs(value));
    peaks[materials[row]].push_back(peak);
  }
  for (const auto& [material, list] : peaks) {
    std::printf("%-24s %4zu samples, loudest %.3g\n", material.c_str(), list.size(),
                static_cast<double>(*std::max_element(list.begin(), list.end())));
  }
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "dataset: %s\n", error.what());
  return 1;
}
