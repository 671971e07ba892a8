#include "eval/studies/learning/detail/published_accuracies.hpp"

#include <algorithm>

namespace carillon::eval::studies {

namespace {

/// Not in the tables.
constexpr double none = -1;

/// One method's accuracies [%] on a table's sets.
struct Row {
  const char* method;
  std::vector<double> percent;
};

struct Table {
  std::vector<const char*> sets;
  std::vector<Row> rows;
};

/// Sterling 2019. The row of VGG16, on pictures of ImageNet, is left out: it is trained on pictures
/// that are not ours to give, and on none of these sets.
const std::vector<Table>& tables() {
  static const std::vector<const char*> rsaudio = {"rsa-s-geometry", "rsa-r-geometry",
                                                   "rsa-merged-geometry", "sound-20k-geometry",
                                                   "arnab-geometry"};
  static const std::vector<const char*> modelnet = {
      "mn10o-geometry", "mn10os-geometry", "mn10om-geometry",  "mn10osm-geometry",
      "mn10-geometry",  "mn40o-geometry",  "mn40osm-geometry",
  };
  static const std::vector<Table> all = {
      // Table 6.1.
      {rsaudio,
       {{"nearest-neighbour-a", {96.92, 68.63, 97.59, 95.54, 87.50}},
        {"linear-svm-a", {2.31, 2.30, 3.20, 82.07, 7.14}},
        {"soundnet5", {94.74, 16.10, 97.70, 58.81, 23.21}},
        {"soundnet8", {83.83, 4.24, 89.62, 71.43, 58.93}},
        {"isnn-a", {96.74, 92.37, 97.07, 99.52, 89.29}}}},
      // Table 6.2: by sound.
      {modelnet,
       {{"nearest-neighbour-a", {40.73, 32.42, 62.81, 67.97, none, 26.55, 54.41}},
        {"linear-svm-a", {16.67, 7.81, 28.85, 15.63, 11.73, 3.97, 12.18}},
        {"soundnet5", {16.96, 10.00, 10.70, 11.00, none, 4.10, 10.95}},
        {"soundnet8", {10.64, 19.50, 20.74, 29.67, none, 5.73, 49.27}},
        {"isnn-a", {43.35, 56.50, 68.00, 71.50, 42.90, 32.51, 65.07}}}},
      // Table 6.3: by sight; VoxNet has one number for the sets of equal voxels.
      {modelnet,
       {{"nearest-neighbour-v", {83.11, 72.57, 82.62, 72.96, none, 65.72, 67.23}},
        {"linear-svm-v", {74.06, 66.80, 68.65, 77.34, 35.39, 51.15, 12.06}},
        {"voxnet", {89.47, 89.47, 89.47, 89.47, 89.47, 80.17, 80.17}}}},
      // Table 6.4: by both.
      {modelnet,
       {{"nearest-neighbour-av", {82.91, 72.57, 83.40, 74.05, none, 65.84, 71.25}},
        {"linear-svm-av", {80.63, 73.44, 82.50, 81.64, 36.70, 54.93, 66.15}},
        {"isnn-av-concatenate", {86.25, 78.50, 88.96, 88.50, 87.40, 79.93, 92.30}},
        {"soundnet8-av-concatenate", {88.14, 52.50, 72.80, 54.50, none, 79.56, 56.39}},
        {"isnn-av-add", {88.91, 80.00, 88.52, 86.00, 88.27, 79.40, 90.43}},
        {"soundnet8-av-add", {88.58, 50.50, 72.91, 64.33, none, 79.89, 24.43}},
        {"isnn-av-multiply", {89.14, 84.00, 89.41, 86.24, 87.51, 81.35, 93.24}},
        {"soundnet8-av-multiply", {83.48, 66.00, 71.79, 51.67, none, 61.44, 38.97}},
        {"isnn-av-bilinear", {91.80, 84.50, 89.97, 90.12, 89.16, 82.04, 92.51}},
        {"soundnet8-av-bilinear", {88.69, 76.50, 73.02, 42.00, none, 80.90, 91.33}}}},
      // Table 6.5.
      {{"rsa-s-material", "rsa-r-material", "arnab-material"},
       {{"isnn-a", {98.69, 95.76, 71.86}},
        {"soundnet5", {99.97, 29.66, 43.11}},
        {"soundnet8", {92.66, 30.51, 43.11}}}}};
  return all;
}

}  // namespace

std::vector<std::string> published_sets() {
  std::vector<std::string> sets;
  for (const Table& table : tables()) {
    for (const char* set : table.sets) {
      if (std::find(sets.begin(), sets.end(), set) == sets.end()) sets.emplace_back(set);
    }
  }
  return sets;
}

std::optional<double> published_accuracy(const std::string& set, const std::string& method) {
  for (const Table& table : tables()) {
    for (const Row& row : table.rows) {
      if (row.method != method) continue;
      for (std::size_t s = 0; s < table.sets.size(); ++s) {
        if (table.sets[s] == set && row.percent[s] != none) return row.percent[s] / 100;
      }
    }
  }
  return {};
}

}  // namespace carillon::eval::studies
