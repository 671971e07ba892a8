#pragma once

#include <mpi.h>

#include <nlohmann/json.hpp>
#include <string>

namespace carillon::mpi {

/// Where figures come from: `command` (as it was typed), `carillon` (revision), `processor`,
/// `ranks` of the world and `date` (UTC).
nlohmann::ordered_json made_by(const std::string& command, MPI_Comm world);

/// Model name of this machine's processor; "unknown" where the system does not say.
std::string processor_name();

}  // namespace carillon::mpi
