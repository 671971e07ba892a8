#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "solvers/mesher/mesh_child.hpp"

namespace carillon::solvers::mesher {

/// Has one task done by `carillon-mesh` (worker/mesh_worker.cpp reads the question).
/// @param question  "task" and what it needs
/// @param what      is worked on, for messages
/// @return its result
/// @throws as mesh_in_child()
nlohmann::json ask_child(nlohmann::json question, const std::string& what,
                         const ChildLimits& limits);

}  // namespace carillon::solvers::mesher
