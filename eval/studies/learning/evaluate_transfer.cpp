#include <fmt/format.h>

#include "core/files.hpp"
#include "core/trace.hpp"
#include "eval/studies/learning/detail/transfer.hpp"
#include "eval/studies/learning/sections.hpp"
#include "eval/studies/picture.hpp"
#include "mpi/comm.hpp"
#include "mpi/interrupt.hpp"

namespace carillon::eval::studies {

using nlohmann::ordered_json;
namespace fs = std::filesystem;

namespace {

EvaluationEnd run(const TransferSpec& spec, const EvaluatedDatasets& datasets,
                  const fs::path& folder, const mpi::Context& context) {
  const double start = core::monotonic_seconds();
  const mpi::InterruptGuard guard;
  const auto rows = run_transfer(spec, datasets, context);
  if (!rows) return {mpi::exit_interrupted};
  ordered_json document;
  mpi::agreed(context.world, [&] {
    if (!context.speaks()) return;
    document = transfer_json(spec, datasets, *rows);
    const std::string text = transfer_text(spec, datasets, *rows);
    const fs::path path = folder / "transfer.json";
    core::write_text_durably(path, document.dump(1) + "\n");
    core::write_text_durably(folder / "transfer.md", text);
    const std::string no_picture = draw_picture("plot_transfer", path);
    document["output"] = folder.string();
    document["timing"] = {{"transfer_s", core::monotonic_seconds() - start}};
    keep_evaluation_trace(folder / "transfer-trace.json", true, {{"timing", document["timing"]}},
                          context);
    if (!context.json) {
      fmt::print("{}\n{}: transfer.json, .md{}\n", text, folder.string(),
                 no_picture.empty() ? ", .svg, .png" : "");
    }
    if (!no_picture.empty()) fmt::print(stderr, "carillon: {}\n", no_picture);
  });
  return {mpi::exit_done, std::move(document)};
}

}  // namespace

RunEvaluation read_transfer_section(core::ConfigNode& node, core::ConfigNode& root,
                                    const EvaluatedDatasets& datasets) {
  return [spec = read_transfer(node, root, datasets), &datasets](const fs::path& folder,
                                                                 const mpi::Context& context) {
    return run(spec, datasets, folder, context);
  };
}

}  // namespace carillon::eval::studies
