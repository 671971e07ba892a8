#include "cli/context.hpp"

#include <fmt/format.h>

#include "mpi/comm.hpp"
#include "mpi/launcher.hpp"

namespace carillon::cli {

bool Context::speaks() const {
  return world == MPI_COMM_NULL ? mpi::launcher_rank().value_or(0) == 0 : mpi::rank(world) == 0;
}

core::Tell teller(const Context& context) {
  // Names of files may be no UTF-8.
  constexpr auto replace = nlohmann::ordered_json::error_handler_t::replace;
  return [json = context.json](const std::string& text, const nlohmann::ordered_json& document) {
    fmt::print("{}", json ? document.dump(2, ' ', false, replace) + "\n" : text);
  };
}

}  // namespace carillon::cli
