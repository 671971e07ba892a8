#include "eval/studies/evaluation.hpp"

#include "core/files.hpp"

namespace carillon::eval::studies {

void keep_evaluation_trace(const std::filesystem::path& path, bool worked,
                           nlohmann::ordered_json trace, nlohmann::ordered_json made) {
  if (!worked && std::filesystem::exists(path)) return;
  trace["made"] = std::move(made);
  core::write_text_durably(path, trace.dump(1) + "\n");
}

}  // namespace carillon::eval::studies
