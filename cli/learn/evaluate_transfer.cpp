#include <fmt/format.h>

#include "cli/learn/sections.hpp"
#include "cli/learn/transfer.hpp"
#include "cli/picture.hpp"
#include "core/files.hpp"
#include "core/trace.hpp"
#include "mpi/comm.hpp"
#include "mpi/interrupt.hpp"

namespace carillon::cli {

using nlohmann::ordered_json;
namespace fs = std::filesystem;

namespace {

EvaluationEnd run(const TransferSpec& spec, const EvaluatedDatasets& datasets,
                  const fs::path& folder, const Context& context) {
  const double start = core::monotonic_seconds();
  const mpi::InterruptGuard guard;
  const auto rows = run_transfer(spec, datasets, context);
  if (!rows) return {exit_interrupted};
  ordered_json document;
  mpi::agreed(context.world, [&] {
    if (!context.speaks()) return;
    document = transfer_document(spec, datasets, *rows);
    const fs::path path = folder / "transfer.json";
    core::write_text_durably(path, document.dump(1) + "\n");
    core::write_text_durably(folder / "transfer.md", transfer_text(document));
    const std::string no_picture = draw_picture("plot_transfer", path);
    document["output"] = folder.string();
    document["timing"] = {{"transfer_s", core::monotonic_seconds() - start}};
    keep_evaluation_trace(folder / "transfer-trace.json", true, {{"timing", document["timing"]}},
                          context);
    if (!context.json) {
      fmt::print("{}\n{}: transfer.json, .md{}\n", transfer_text(document), folder.string(),
                 no_picture.empty() ? ", .svg, .png" : "");
    }
    if (!no_picture.empty()) fmt::print(stderr, "carillon: {}\n", no_picture);
  });
  return {exit_done, std::move(document)};
}

}  // namespace

RunEvaluation read_transfer_section(core::ConfigNode& node, core::ConfigNode& root,
                                    const EvaluatedDatasets& datasets) {
  return [spec = read_transfer(node, root, datasets), &datasets](const fs::path& folder,
                                                                 const Context& context) {
    return run(spec, datasets, folder, context);
  };
}

}  // namespace carillon::cli
