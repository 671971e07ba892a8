#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "eval/networks/detail/networks.hpp"

namespace carillon::eval::networks {

/// What a classifier computes when it answers, as data: its inputs, the layers of each branch in
/// their order with the names of their weights, how branches are joined, and the layer that
/// classifies (docs/learning.md, "Weights for other programs"). Values lie as samples x channels x
/// axes.
nlohmann::ordered_json layer_table(const Classifier& classifier, const learning::Method& method,
                                   const std::vector<learning::ModalityExtent>& extents,
                                   const std::vector<std::string>& classes);

/// The weights that the table names, and the statistics of normalised layers.
std::map<std::string, torch::Tensor> weights_of(const Classifier& classifier);

}  // namespace carillon::eval::networks
