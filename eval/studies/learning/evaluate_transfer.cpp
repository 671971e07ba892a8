#include <fmt/format.h>

#include "core/files.hpp"
#include "core/trace.hpp"
#include "eval/scripts/run_script.hpp"
#include "eval/studies/learning/detail/transfer.hpp"
#include "eval/studies/learning/sections.hpp"
#include "mpi/comm.hpp"
#include "mpi/interrupt.hpp"
#include "mpi/made_by.hpp"

namespace carillon::eval::studies {

using nlohmann::ordered_json;
namespace fs = std::filesystem;

namespace {

EvaluationEnd run(const TransferSpec& spec, const EvaluatedDatasets& datasets,
                  const fs::path& folder, MPI_Comm world) {
  const double start = core::monotonic_seconds();
  const mpi::InterruptGuard guard;
  const auto rows = run_transfer(spec, datasets, world);
  if (!rows) return {mpi::exit_interrupted};
  EvaluationEnd end;
  mpi::agreed(world, [&] {
    if (mpi::rank(world) != 0) return;
    ordered_json& document = end.document;
    document = transfer_json(spec, datasets, *rows);
    const std::string text = transfer_text(spec, datasets, *rows);
    const fs::path path = folder / "transfer.json";
    core::write_text_durably(path, document.dump(1) + "\n");
    core::write_text_durably(folder / "transfer.md", text);
    const std::string no_picture = scripts::draw_picture("plot_transfer", path);
    document["output"] = folder.string();
    document["timing"] = {{"transfer_s", core::monotonic_seconds() - start}};
    keep_evaluation_trace(folder / "transfer-trace.json", true, {{"timing", document["timing"]}},
                          mpi::made_by(datasets.options().command, world));
    end.text = fmt::format("{}\n{}: transfer.json, .md{}\n", text, folder.string(),
                           no_picture.empty() ? ", .svg, .png" : "");
    if (!no_picture.empty()) fmt::print(stderr, "carillon: {}\n", no_picture);
  });
  return end;
}

}  // namespace

RunEvaluation read_transfer_section(core::ConfigNode& node, core::ConfigNode& root,
                                    const EvaluatedDatasets& datasets) {
  return [spec = read_transfer(node, root, datasets), &datasets](
             const fs::path& folder, MPI_Comm world) { return run(spec, datasets, folder, world); };
}

}  // namespace carillon::eval::studies
