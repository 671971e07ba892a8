#include <fmt/format.h>
#include <fmt/ranges.h>

#include <functional>
#include <map>
#include <memory>
#include <span>

#include "cli/command_line.hpp"
#include "cli/commands.hpp"
#include "core/error.hpp"
#include "core/files.hpp"
#include "mpi/comm.hpp"
#include "mpi/made_by.hpp"
#include "report/report.hpp"

namespace carillon::cli {

using nlohmann::ordered_json;

namespace {

/// Of sounds, of all datasets together.
constexpr std::size_t sounds_bytes = 3'500'000;
/// Objects have what the rest leaves of a page, and as much at the least.
constexpr std::size_t full_page = 14'500'000, min_objects_bytes = 2'000'000;
/// Of objects and of tasks, of all datasets together: some 400 bytes a pair.
constexpr std::size_t max_rows = 4000;
/// Each has a configuration, effects and versions: some 15 kB.
constexpr std::size_t max_datasets = 40;
/// Of sweeps, studies and evaluations each.
constexpr std::size_t max_documents = 20;
constexpr std::size_t large_page = 15'000'000;

struct ReportOptions {
  std::vector<std::string> folders;
  std::string output = "report.html";
  std::size_t sounds = 12, objects = 40;
};

/// Adds a part; one that cannot be read is noted, and the others are shown.
void try_to_add(ordered_json& report, const std::string& what, const std::function<void()>& add) {
  const auto note = [&](const std::string& why) {
    report["notes"].push_back(fmt::format("{} cannot be shown: {}", what, why));
  };
  try {
    add();
  } catch (const core::Error& error) {
    note(error.message());
  } catch (const nlohmann::json::exception& error) {
    note(fmt::format("values are missing or of another kind ({})", error.what()));
  } catch (const std::filesystem::filesystem_error& error) {
    note(error.code().message());
  }
}

void add_document(ordered_json& report, const char* kind, const std::filesystem::path& folder,
                  const std::string& name, const std::string& key) {
  if (!std::filesystem::is_regular_file(folder / name)) return;
  try_to_add(report, (folder / name).string(),
             [&] { report[kind].push_back(report::read_document(folder, name, key)); });
}

/// So many folders as are shown, the first ones; what is left out is noted.
std::span<const std::filesystem::path> first_of(const std::vector<std::filesystem::path>& folders,
                                                std::size_t most, const char* what,
                                                ordered_json& report) {
  const std::size_t count = std::min(folders.size(), most);
  if (count < folders.size()) {
    report["notes"].push_back(
        fmt::format("{} of {} {} are left out, after {}: name their folders to see them",
                    folders.size() - count, folders.size(), what, folders[count - 1].string()));
  }
  return std::span(folders).first(count);
}

using NamedDatasets = std::map<std::string, dataset::stored::StoredDataset>;

/// Datasets with their sounds.
/// @return the first of each name: variants of a sweep share theirs, and most of their objects
NamedDatasets add_datasets(const report::ReportFolders& found, const ReportOptions& options,
                           ordered_json& report) {
  const auto shown = first_of(found.datasets, max_datasets, "datasets", report);
  const std::size_t count = shown.size();
  NamedDatasets by_name;
  for (const std::filesystem::path& folder : shown) {
    try_to_add(report, folder.string(), [&] {
      dataset::stored::StoredDataset dataset = dataset::stored::open_dataset(folder, "");
      ordered_json entry = report::dataset_report(dataset, max_rows / count);
      entry["heard"] = ordered_json::array();
      const std::string name = entry.at("name");
      report["datasets"].push_back(std::move(entry));
      by_name.try_emplace(name, std::move(dataset));
      // At least one of each, as far as the page's bytes go.
      const report::ReportShare share = {(options.sounds + count - 1) / count,
                                         sounds_bytes / count};
      try_to_add(report, (folder / "index.h5").string(), [&] {
        report["datasets"].back()["heard"] = report::heard_samples(folder, share);
      });
    });
  }
  return by_name;
}

void add_gallery(const NamedDatasets& datasets, std::size_t bytes, const ReportOptions& options,
                 ordered_json& report) {
  ordered_json& gallery = report["gallery"];
  std::size_t left = datasets.size();
  for (const auto& named : datasets) {
    const auto& dataset = named.second;
    const report::ReportShare share = {(options.objects + datasets.size() - 1) / datasets.size(),
                                       bytes / left--};
    try_to_add(report, "objects of " + named.first, [&] {
      ordered_json here = report::gallery_objects(dataset, share, report["notes"]);
      for (ordered_json& object : here.at("objects")) {
        gallery["objects"].push_back(std::move(object));
      }
      for (const auto& [reason, objects] : here.at("left_out").items()) {
        gallery["left_out"][reason] =
            gallery["left_out"].value(reason, std::size_t{0}) + objects.get<std::size_t>();
      }
      bytes -= std::min(bytes, here.at("bytes").get<std::size_t>());
      gallery["total"] = gallery["total"].get<std::size_t>() + dataset.build.plan.shapes.size();
    });
  }
}

/// Of the nightly runs the last one, which tells of those before.
void add_nightly(const report::ReportFolders& found, ordered_json& report) {
  if (found.nightly_runs.empty()) return;
  if (found.nightly_runs.size() > 1) {
    report["notes"].push_back(
        fmt::format("of {} nightly runs the last one is shown: name another one's folder to see it",
                    found.nightly_runs.size()));
  }
  add_document(report, "nightly_runs", found.nightly_runs.back(), "nightly.json", "measures");
}

ordered_json collect(const report::ReportFolders& found, const ReportOptions& options,
                     const Context& context) {
  ordered_json report = {{"title", fmt::format("{}", fmt::join(options.folders, ", "))},
                         {"made", mpi::made_by(context.command, context.world)},
                         {"notes", ordered_json::array()}};
  for (const char* list :
       {"datasets", "sweeps", "studies", "damping", "classification", "transfer", "nightly_runs"}) {
    report[list] = ordered_json::array();
  }
  report["gallery"] = {{"total", 0},
                       {"objects", ordered_json::array()},
                       {"left_out", ordered_json::object()},
                       {"materials", report::gallery_materials()}};
  for (const std::string& why : found.unreadable) report["notes"].push_back(why);
  const NamedDatasets datasets = add_datasets(found, options, report);
  for (const auto& folder : first_of(found.sweeps, max_documents, "sweeps", report)) {
    add_document(report, "sweeps", folder, "sweep.json", "variants");
  }
  for (const auto& folder : first_of(found.studies, max_documents, "studies", report)) {
    add_document(report, "studies", folder, "accuracy.json", "objects");
  }
  add_nightly(found, report);
  for (const auto& folder : first_of(found.evaluations, max_documents, "evaluations", report)) {
    const auto add = [&](const char* kind, const char* name, auto&& read) {
      if (!std::filesystem::is_regular_file(folder / name)) return;
      try_to_add(report, (folder / name).string(), [&] { report[kind].push_back(read(folder)); });
    };
    add("damping", "damping.json", report::read_damping);
    add("classification", "classification.json", report::read_classification);
    add_document(report, "transfer", folder, "transfer.json", "rows");
  }
  const std::size_t rest = std::min(full_page, report::report_page(report).size());
  add_gallery(datasets, std::max(min_objects_bytes, full_page - rest), options, report);
  return report;
}

void write_report(const ReportOptions& options, const Context& context) {
  const report::ReportFolders found = report::find_report_folders(options.folders);
  ordered_json report = collect(found, options, context);
  std::string page = report::report_page(report);
  if (page.size() > large_page) {
    report["notes"].push_back(
        fmt::format("this page has {:.0f} MB: name fewer folders, or give --sounds and --objects "
                    "smaller numbers",
                    static_cast<double>(page.size()) / 1e6));
    page = report::report_page(report);
  }
  core::write_text_durably(options.output, page);
  if (context.json) {
    fmt::print("{}\n", ordered_json{{"output", options.output},
                                    {"bytes", page.size()},
                                    {"datasets", report["datasets"].size()},
                                    {"studies", report["studies"].size()},
                                    {"objects", report["gallery"]["objects"].size()},
                                    {"notes", report["notes"]}}
                           .dump(1));
    return;
  }
  fmt::print("{}: {:.1f} MB\n", options.output, static_cast<double>(page.size()) / 1e6);
  for (const ordered_json& note : report["notes"]) fmt::print("  {}\n", note.get<std::string>());
}

/// One rank does it; all end with its outcome.
void run_report(const ReportOptions& options, const Context& context) {
  mpi::agreed(context.world, [&] {
    if (context.speaks()) write_report(options, context);
  });
}

}  // namespace

void add_report(Program& program, Context& context) {
  Command& command = program.add(
      "report", "one page that shows datasets, what accuracy costs and what can be learnt",
      Needs::ranks);
  auto options = std::make_shared<ReportOptions>();
  command
      .option("folders", options->folders,
              "folders that build, accuracy, evaluate or scripts/nightly made, or that hold such")
      .required();
  command.option("-o,--output", options->output, "HTML file").show_default();
  command.option("--sounds", options->sounds, "samples to hear, of all datasets together")
      .show_default();
  command.option("--objects", options->objects, "objects to strike, of all datasets together")
      .show_default();
  command.footer(
      "The page needs no network: open it in a browser, send it, print it.\n"
      "Examples:\n"
      "  carillon report carillon-smoke -o report.html\n"
      "  carillon report carillon-smoke carillon-accuracy carillon-learning-smoke\n"
      "docs/report.md");
  command.does([&context, options] { run_report(*options, context); });
}

}  // namespace carillon::cli
