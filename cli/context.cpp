#include "cli/context.hpp"

#include <fmt/format.h>

#include "core/log.hpp"
#include "core/outputs.hpp"
#include "mpi/comm.hpp"
#include "mpi/launcher.hpp"

namespace carillon::cli {

bool Context::speaks() const {
  return world == MPI_COMM_NULL ? mpi::launcher_rank().value_or(0) == 0 : mpi::rank(world) == 0;
}

namespace {

void require_output(const Context& context, const std::string& path,
                    void (*require)(const std::filesystem::path&)) {
  const auto look = [&] {
    if (!path.empty() && context.speaks()) require(path);
  };
  if (context.world == MPI_COMM_NULL) return look();
  mpi::agreed(context.world, look);
}

}  // namespace

void require_output_file(const Context& context, const std::string& path) {
  require_output(context, path, core::require_writable_file);
}

void require_output_folder(const Context& context, const std::string& path) {
  require_output(context, path, core::require_writable_folder);
}

core::Tell teller(const Context& context) {
  // Names of files may be no UTF-8.
  constexpr auto replace = nlohmann::ordered_json::error_handler_t::replace;
  return [json = context.json](const std::string& text, const nlohmann::ordered_json& document) {
    core::log_to_file(text);
    fmt::print("{}", json ? document.dump(2, ' ', false, replace) + "\n" : text);
  };
}

void on_one_rank(const Context& context, const std::function<void()>& action) {
  mpi::agreed(context.world, [&] {
    if (context.speaks()) action();
  });
}

}  // namespace carillon::cli
