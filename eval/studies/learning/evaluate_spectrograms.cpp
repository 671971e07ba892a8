#include <fmt/format.h>

#include "core/files.hpp"
#include "core/trace.hpp"
#include "eval/studies/learning/detail/spectrograms.hpp"
#include "eval/studies/learning/sections.hpp"
#include "eval/studies/picture.hpp"
#include "mpi/comm.hpp"
#include "mpi/interrupt.hpp"

namespace carillon::eval::studies {

using nlohmann::ordered_json;
namespace fs = std::filesystem;

namespace {

std::string study_text(const ordered_json& document) {
  std::string text;
  for (const ordered_json& dataset : document.at("datasets")) {
    const ordered_json& found = dataset.at("components");
    text += fmt::format("{}: {} sounds\n", dataset.at("name").get<std::string>(),
                        found.at("sounds").get<std::size_t>());
    std::size_t number = 0;
    for (const ordered_json& component : found.at("components")) {
      const ordered_json& explained = component.at("explained_by_labels");
      text += fmt::format(
          "  component {}: {:.1f} % of the variance; {} explains {} of it\n", ++number,
          100 * component.at("share").get<double>(), found.at("color").get<std::string>(),
          explained.is_null() ? "nothing" : fmt::format("{:.1f} %", 100 * explained.get<double>()));
    }
  }
  return text;
}

EvaluationEnd run(const SpectrogramStudy& study, const EvaluatedDatasets& datasets,
                  const fs::path& folder, const mpi::Context& context) {
  const double start = core::monotonic_seconds();
  const mpi::InterruptGuard guard;
  auto document = study_spectrograms(study, datasets, context);
  if (!document) return {mpi::exit_interrupted};
  mpi::agreed(context.world, [&] {
    if (!context.speaks()) return;
    const fs::path path = folder / "spectrograms.json";
    core::write_text_durably(path, document->dump() + "\n");
    const std::string no_picture = draw_picture("plot_spectrograms", path);
    (*document)["output"] = folder.string();
    (*document)["timing"] = {{"spectrograms_s", core::monotonic_seconds() - start}};
    if (!context.json) {
      fmt::print("{}{}: spectrograms.json{}\n", study_text(*document), folder.string(),
                 no_picture.empty() ? ", .svg, .png" : "");
    }
    if (!no_picture.empty()) fmt::print(stderr, "carillon: {}\n", no_picture);
  });
  return {mpi::exit_done, std::move(*document)};
}

}  // namespace

RunEvaluation read_spectrograms(core::ConfigNode& node, core::ConfigNode& root,
                                const EvaluatedDatasets& datasets) {
  return [study = read_spectrogram_study(node, root, datasets.config()), &datasets](
             const fs::path& folder, const mpi::Context& context) {
    return run(study, datasets, folder, context);
  };
}

}  // namespace carillon::eval::studies
