#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace carillon::eval::studies {

/// For people, in Markdown: a table of each task and dataset, the best method's recalls and
/// confusions, and what differs from the papers' sets where their numbers stand beside.
/// @param document  as classification_document() makes it
std::string classification_text(const nlohmann::ordered_json& document);

/// One row for each method, task and dataset.
std::string classification_csv(const nlohmann::ordered_json& document);

}  // namespace carillon::eval::studies
