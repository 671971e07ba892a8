#pragma once

#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "core/trace.hpp"

namespace carillon::dataset::run {

/// `{stages: {NAME: {calls, seconds}}, effects: {...}}`
nlohmann::json to_json(const core::Trace& trace);

/// What a task ran by its journal entry, for the samples that it kept from an earlier run too.
core::Trace trace_of(const nlohmann::json& entry);

/// What all finished tasks ran, in this run and in those before it.
/// @param finished  journal entries by task
core::Trace total_trace(const std::map<std::string, nlohmann::json>& finished);

}  // namespace carillon::dataset::run
