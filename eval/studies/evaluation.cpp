#include "eval/studies/evaluation.hpp"

#include "core/files.hpp"
#include "mpi/made_by.hpp"

namespace carillon::eval::studies {

void keep_evaluation_trace(const std::filesystem::path& path, bool worked,
                           nlohmann::ordered_json trace, const mpi::Context& context) {
  if (!worked && std::filesystem::exists(path)) return;
  trace["made"] = mpi::made_by(context);
  core::write_text_durably(path, trace.dump(1) + "\n");
}

}  // namespace carillon::eval::studies
