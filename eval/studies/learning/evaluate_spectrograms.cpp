#include <fmt/format.h>

#include <cmath>

#include "core/files.hpp"
#include "core/json.hpp"
#include "core/trace.hpp"
#include "eval/scripts/run_script.hpp"
#include "eval/studies/learning/detail/spectrograms.hpp"
#include "eval/studies/learning/sections.hpp"
#include "mpi/comm.hpp"
#include "mpi/interrupt.hpp"

namespace carillon::eval::studies {

using nlohmann::ordered_json;
namespace fs = std::filesystem;

namespace {

/// Bands x frames, as lists.
ordered_json picture(const std::vector<double>& values, std::size_t bands) {
  ordered_json rows = ordered_json::array();
  const auto frames = static_cast<std::ptrdiff_t>(values.size() / bands);
  for (auto row = values.begin(); row != values.end(); row += frames) {
    rows.push_back(std::vector<double>(row, row + frames));
  }
  return rows;
}

ordered_json to_json(const DatasetSpectrograms& dataset, const std::string& color) {
  ordered_json components = ordered_json::array(), exciting = ordered_json::array();
  for (const DatasetSpectrograms::Component& component : dataset.components) {
    components.push_back({{"fraction", component.fraction},
                          {"explained_by_labels", core::number_or_null(component.explained)},
                          {"picture", picture(component.picture, dataset.bands)},
                          {"coordinates", component.coordinates}});
  }
  for (const auto& [name, values] : dataset.exciting) {
    exciting.push_back({{"class", name}, {"picture", picture(values, dataset.bands)}});
  }
  ordered_json filters = ordered_json::array();
  const DatasetSpectrograms::Activations& activations = dataset.activations;
  for (const auto& [number, values] : activations.filters) {
    filters.push_back({{"filter", number}, {"picture", picture(values, activations.bands)}});
  }
  return {{"name", dataset.name},
          {"band_hz", dataset.band_hz},
          {"frame_s", dataset.frame_s},
          {"activations",
           {{"key", dataset.keys[activations.sound]},
            {"label", dataset.labels[activations.sound]},
            {"spectrogram", picture(activations.spectrogram, dataset.bands)},
            {"filters", std::move(filters)}}},
          {"components",
           {{"sounds", dataset.keys.size()},
            {"color", color},
            {"keys", dataset.keys},
            {"labels", dataset.labels},
            {"mean", picture(dataset.mean, dataset.bands)},
            {"mean_square", dataset.mean_square},
            {"components", std::move(components)}}},
          {"exciting", std::move(exciting)}};
}

std::string to_text(const std::vector<DatasetSpectrograms>& found, const std::string& color) {
  std::string text;
  for (const DatasetSpectrograms& dataset : found) {
    text += fmt::format("{}: {} sounds\n", dataset.name, dataset.keys.size());
    std::size_t number = 0;
    for (const DatasetSpectrograms::Component& component : dataset.components) {
      text += fmt::format("  component {}: {:.1f} % of the variance; {} explains {} of it\n",
                          ++number, 100 * component.fraction, color,
                          std::isfinite(component.explained)
                              ? fmt::format("{:.1f} %", 100 * component.explained)
                              : "nothing");
    }
  }
  return text;
}

EvaluationEnd run(const SpectrogramStudy& study, const EvaluatedDatasets& datasets,
                  const fs::path& folder, MPI_Comm world) {
  const double start = core::monotonic_seconds();
  const mpi::InterruptGuard guard;
  const auto found = study_spectrograms(study, datasets, world);
  if (!found) return {mpi::exit_interrupted};
  EvaluationEnd end;
  mpi::agreed(world, [&] {
    if (mpi::rank(world) != 0) return;
    ordered_json& document = end.document;
    document = {{"name", datasets.name()},
                {"task", study.task.name},
                {"method", study.method.name},
                {"datasets", ordered_json::array()}};
    for (const DatasetSpectrograms& dataset : *found) {
      document["datasets"].push_back(to_json(dataset, study.color));
    }
    const fs::path path = folder / "spectrograms.json";
    core::write_text_durably(path, document.dump() + "\n");
    const std::string no_picture = scripts::draw_picture("plot_spectrograms", path);
    document["output"] = folder.string();
    document["timing"] = {{"spectrograms_s", core::monotonic_seconds() - start}};
    end.text = fmt::format("{}{}: spectrograms.json{}\n", to_text(*found, study.color),
                           folder.string(), no_picture.empty() ? ", .svg, .png" : "");
    if (!no_picture.empty()) fmt::print(stderr, "carillon: {}\n", no_picture);
  });
  return end;
}

}  // namespace

RunEvaluation read_spectrograms(core::ConfigNode& node, core::ConfigNode& root,
                                const EvaluatedDatasets& datasets) {
  return
      [study = read_spectrogram_study(node, root, datasets.config()), &datasets](
          const fs::path& folder, MPI_Comm world) { return run(study, datasets, folder, world); };
}

}  // namespace carillon::eval::studies
