#pragma once

#include <string>

namespace carillon::cli {

/// Model name of this machine's processor; "unknown" where the system does not say.
std::string processor_name();

}  // namespace carillon::cli
