#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "mpi/context.hpp"

namespace carillon::mpi {

/// Where figures come from: `command`, `carillon` (revision), `processor`, `ranks` of the world and
/// `date` (UTC).
nlohmann::ordered_json made_by(const Context& context);

/// Model name of this machine's processor; "unknown" where the system does not say.
std::string processor_name();

}  // namespace carillon::mpi
