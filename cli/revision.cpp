#include "cli/revision.hpp"

#include "carillon_revision.hpp"

namespace carillon::cli {

const char* const revision = CARILLON_REVISION;

}  // namespace carillon::cli
