#pragma once

#include <string>

namespace carillon::core {

/// Name of this machine; "" where the system does not tell.
std::string host_name();

}  // namespace carillon::core
