#pragma once

namespace carillon::cli {

/// The commit that the program was built from, as `git describe --always --dirty --tags` names it
/// ("v0.1.0", "v0.1.0-12-g1a2b3c4", "1a2b3c4-dirty"); empty where the sources were no clone.
extern const char* const revision;

}  // namespace carillon::cli
