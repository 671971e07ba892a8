#include "cli/evaluate/evaluation.hpp"

#include "cli/made_by.hpp"
#include "core/files.hpp"

namespace carillon::cli {

void keep_evaluation_trace(const std::filesystem::path& path, bool worked,
                           nlohmann::ordered_json trace, const Context& context) {
  if (!worked && std::filesystem::exists(path)) return;
  trace["made"] = made_by(context);
  core::write_text_durably(path, trace.dump(1) + "\n");
}

}  // namespace carillon::cli
