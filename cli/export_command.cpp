#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <set>

#include "cli/command_line.hpp"
#include "cli/commands.hpp"
#include "core/error.hpp"
#include "core/files.hpp"
#include "core/json.hpp"
#include "core/trace.hpp"
#include "dataset/configuration/about.hpp"
#include "dataset/exporters/data_card.hpp"
#include "dataset/exporters/export.hpp"
#include "dataset/exporters/export_folder.hpp"
#include "dataset/exporters/seal.hpp"
#include "dataset/exporters/whole_dataset.hpp"
#include "dataset/run/croissant.hpp"
#include "dataset/stored/stored_dataset.hpp"
#include "mpi/comm.hpp"

namespace carillon::cli {

namespace {

using nlohmann::ordered_json;

struct ExportOptions {
  std::string dataset, format, output;
  std::string split = "split_shape";
  std::vector<std::string> arrays, hidden;
  std::size_t per_shard = 1000;
};

ordered_json samples_by_part(const dataset::exporters::ExportedRows& rows) {
  ordered_json counts = ordered_json::object();
  for (const auto& [part, members] : rows.by_part()) counts[part] = members.size();
  return counts;
}

/// What the dataset says of itself, for its descriptions in other formats.
/// @throws FileError  dataset.json is damaged
dataset::exporters::CardSource source_of(const std::filesystem::path& folder,
                                         const ExportOptions& options) {
  const std::filesystem::path path = folder / "dataset.json";
  const ordered_json said =
      std::filesystem::exists(path) ? core::read_ordered_json(path) : ordered_json::object();
  if (!said.is_object()) {
    throw core::FileError(fmt::format(
        "{} is damaged: `carillon build` of the same configuration writes it anew", path.string()));
  }
  dataset::exporters::CardSource source = {said.value("name", folder.filename().string()),
                                           said,
                                           options.format,
                                           options.split,
                                           options.arrays,
                                           options.hidden};
  // Whoever has these could make the hidden sounds again, and compare.
  if (!options.hidden.empty()) {
    for (const char* key : {"configuration", "shapes", "seed"}) source.said.erase(key);
  }
  return source;
}

/// Arrays that say nothing of a sample's classes but what is heard, seen or felt.
const std::vector<std::string> perceived = {"audio",  "mel",   "voxels", "frame",
                                            "frames", "depth", "touch"};

/// Refuses what would tell of hidden samples what --hide hides.
void check_hidden(const ExportOptions& options) {
  if (options.hidden.empty()) return;
  if (options.format == "lhotse") {
    throw core::InputError("--hide does not go with --format lhotse, whose events are labels",
                           "wav and webdataset can be without labels");
  }
  for (const std::string& name : options.arrays) {
    if (std::find(perceived.begin(), perceived.end(), name) != perceived.end()) continue;
    throw core::InputError(fmt::format("--with {} would tell what --hide hides", name),
                           fmt::format("with it go {}", fmt::join(perceived, ", ")));
  }
}

/// Where the key of an export's hidden names is kept: beside it, not in it.
std::filesystem::path seal_path(const std::filesystem::path& output) {
  return output.parent_path() / (output.filename().string() + "-sealed.json");
}

/// The seal of an export that was begun before, or a new one. Rank 0 writes it.
dataset::exporters::Seal seal_of(const std::filesystem::path& output, const ExportOptions& options,
                                 const dataset::exporters::ExportedRows& rows) {
  const std::filesystem::path path = seal_path(output);
  std::vector<std::string> keys;
  for (std::size_t row = 0; row < rows.size(); ++row) keys.push_back(rows.key(row));
  const std::set<std::string> parts(options.hidden.begin(), options.hidden.end());
  if (std::filesystem::exists(path)) {
    dataset::exporters::Seal seal = dataset::exporters::read_seal(path);
    if (seal.is_of(keys) && seal.split == options.split && seal.parts == parts) return seal;
    throw core::InputError(fmt::format("{} is of another export", path.string()),
                           "answers for that one could not be scored without it: move it away, or "
                           "export into another folder");
  }
  dataset::exporters::Seal seal = dataset::exporters::make_seal(options.split, parts, keys);
  dataset::exporters::write_seal(path, seal);
  return seal;
}

ordered_json to_json(const std::vector<dataset::exporters::ExportedFile>& files) {
  ordered_json list = ordered_json::array();
  for (const dataset::exporters::ExportedFile& file : files) {
    list.push_back({{"path", file.path}, {"sha256", file.sha256}, {"bytes", file.bytes}});
  }
  return list;
}

/// Every rank's files by their names.
/// @note Collective.
std::vector<dataset::exporters::ExportedFile> gather(
    const std::vector<dataset::exporters::ExportedFile>& own, MPI_Comm world) {
  std::vector<dataset::exporters::ExportedFile> all;
  for (const std::string& text : mpi::all_gather(to_json(own).dump(), world)) {
    for (const ordered_json& file : ordered_json::parse(text)) {
      all.push_back({file.at("path"), file.at("sha256"), file.at("bytes")});
    }
  }
  std::sort(all.begin(), all.end(),
            [](const dataset::exporters::ExportedFile& a,
               const dataset::exporters::ExportedFile& b) { return a.path < b.path; });
  return all;
}

/// This rank's share of the sounds and labels.
std::vector<dataset::exporters::ExportedFile> write_samples(const dataset::exporters::Export& task,
                                                            const ExportOptions& options) {
  if (options.format == "wav") return dataset::exporters::write_audio_folder(task);
  if (options.format == "lhotse") return dataset::exporters::write_lhotse(task);
  return dataset::exporters::write_web_dataset(task, options.arrays, options.per_shard);
}

/// dataset.json, README.md and croissant.json of an export.
/// @param files  of all ranks
void write_descriptions(const std::filesystem::path& folder,
                        const dataset::exporters::CardSource& source,
                        const dataset::exporters::Export& task,
                        std::vector<dataset::exporters::ExportedFile> files) {
  const auto add = [&](const char* name, const std::string& text) {
    core::write_text_durably(task.output / name, text);
    files.push_back(dataset::exporters::exported_file(task.output, name));
  };
  if (std::filesystem::exists(folder / "dataset.json") && source.hidden.empty()) {
    add("dataset.json", core::read_file(folder / "dataset.json"));
  }
  add("README.md", dataset::exporters::data_card(source, task.rows, task.index));
  const ordered_json head = dataset::run::croissant_head(
      source.name,
      dataset::configuration::about_from(source.said.value("about", ordered_json::object())),
      dataset::run::samples_sentence(task.rows.size()));
  const ordered_json croissant =
      dataset::exporters::croissant_of(head, source.format, files, task.rows, task.index);
  core::write_text_durably(task.output / "croissant.json", croissant.dump(2) + "\n");
}

void run_export(const ExportOptions& options, const Context& context) {
  const double start = core::monotonic_seconds();
  const std::filesystem::path folder = core::tidy_path(options.dataset);
  const std::filesystem::path output =
      options.output.empty() ? folder.filename().string() + "-" + options.format : options.output;
  std::optional<core::Hdf5Group> index;
  std::optional<dataset::exporters::ExportedRows> rows;
  dataset::exporters::CardSource source;
  mpi::agreed(context.world, [&] {
    if (!std::filesystem::exists(folder / "index.h5")) {
      throw dataset::stored::not_a_dataset(folder);
    }
    index = core::Hdf5Group::open_file(folder / "index.h5");
    if (context.speaks()) dataset::exporters::require_whole(folder, *index, options.arrays);
    rows.emplace(*index, options.split);
    source = source_of(folder, options);
  });
  std::string sealed;
  on_one_rank(context, [&] {
    dataset::exporters::ExportFolder::begin(output);
    if (!options.hidden.empty()) sealed = to_json(seal_of(output, options, *rows)).dump();
  });
  sealed = mpi::broadcast(sealed, 0, context.world);
  if (!sealed.empty()) rows->hide(dataset::exporters::seal_from(nlohmann::json::parse(sealed)));
  const dataset::exporters::Export task{output, *index, *rows, mpi::rank(context.world),
                                        mpi::size(context.world)};
  std::vector<dataset::exporters::ExportedFile> files;
  mpi::agreed(context.world, [&] { files = write_samples(task, options); });
  files = gather(files, context.world);
  on_one_rank(context, [&] {
    write_descriptions(folder, source, task, files);
    dataset::exporters::ExportFolder::finish(output);
  });
  if (!context.speaks()) return;
  const double seconds = core::monotonic_seconds() - start;
  if (context.json) {
    ordered_json document = {{"output", output.string()},
                             {"format", options.format},
                             {"samples", rows->size()},
                             {"parts", samples_by_part(*rows)},
                             {"timing", {{"export_s", seconds}}}};
    if (!sealed.empty()) document["sealed"] = seal_path(output).string();
    fmt::print("{}\n", document.dump(1));
  } else {
    fmt::print("{}: {} samples\n", output.string(), rows->size());
    if (!sealed.empty()) {
      fmt::print("{}: keep it, and to yourself; carillon score --sealed takes it\n",
                 seal_path(output).string());
    }
  }
}

/// What is wrong with a format that nobody needs to ask for.
std::string refuse_croissant(const std::string& format) {
  return format == "croissant"
             ? "every dataset has a croissant.json already, and so has every export"
             : "";
}

}  // namespace

void add_export(Program& program, Context& context) {
  Command& command = program.add("export", "a dataset in another format", Needs::ranks);
  auto options = std::make_shared<ExportOptions>();
  command.option("dataset", options->dataset, "folder of a dataset").required();
  command
      .option("--format", options->format,
              "wav: files and a metadata.jsonl for each part (AudioFolder); webdataset: tar "
              "files of shuffled samples; lhotse: as wav, with manifests whose events are strikes")
      .required()
      .check(refuse_croissant)
      .one_of({"wav", "webdataset", "lhotse"});
  command.option("-o,--output", options->output,
                 "new folder (default: DATASET-FORMAT in the current one)");
  command.option("--split", options->split, "column that says which part a sample is in")
      .show_default();
  command.option("--with", options->arrays,
                 "columns that a webdataset has as .npy too: mel, voxels, frame, touch, ...");
  command.option("--per-shard", options->per_shard, "samples of a tar file")
      .show_default()
      .range(std::size_t{1}, std::size_t{1000000});
  command
      .option(
          "--hide", options->hidden,
          "parts whose samples get names that tell nothing, and no labels: carillon score knows "
          "them by OUTPUT-sealed.json")
      .one_of({"test", "validation"});
  command.footer(
      "Examples:\n"
      "  carillon export carillon-smoke --format wav\n"
      "  carillon export carillon-smoke --format wav --hide test\n"
      "  mpirun -n 4 carillon export kitchen --format webdataset --with mel voxels -o shards\n"
      "  carillon export carillon-dominoes --format lhotse\n"
      "Every export has a README.md, the data card of the Hugging Face Hub, and a croissant.json, "
      "as every dataset has.\n"
      "docs/exports.md");
  command.does([&context, options] {
    if (options->format != "webdataset" && !options->arrays.empty()) {
      throw core::InputError("--with goes with --format webdataset",
                             "the other columns are in metadata.jsonl");
    }
    check_hidden(*options);
    run_export(*options, context);
  });
}

}  // namespace carillon::cli
