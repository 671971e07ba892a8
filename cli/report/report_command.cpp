#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <functional>
#include <map>
#include <memory>
#include <span>

#include "cli/context.hpp"
#include "cli/made_by.hpp"
#include "cli/report/report.hpp"
#include "core/error.hpp"
#include "core/files.hpp"

namespace carillon::cli {

using nlohmann::ordered_json;

namespace {

/// Together with the page itself (1 MB), below 15 MB.
constexpr std::size_t sounds_bytes = 4'000'000;
constexpr std::size_t objects_bytes = 7'000'000;
/// Of bodies and of tasks, of all datasets together: some 400 bytes a pair.
constexpr std::size_t most_rows = 4000;
/// Each has a configuration, effects and versions: some 15 kB.
constexpr std::size_t most_datasets = 40;
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
             [&] { report[kind].push_back(read_document(folder, name, key)); });
}

/// Datasets with their sounds and objects. Variants of a sweep have one name and mostly the same
/// bodies: the first one's can be struck.
void add_datasets(const ReportFolders& found, const ReportOptions& options, ordered_json& report) {
  const std::size_t count = std::min(found.datasets.size(), most_datasets);
  if (count < found.datasets.size()) {
    report["notes"].push_back(fmt::format(
        "{} of {} datasets are left out, after {}: name their folders to see them",
        found.datasets.size() - count, found.datasets.size(), found.datasets[count - 1].string()));
  }
  // At least one of each, as far as the page's bytes go.
  const auto share = [&](std::size_t all, std::size_t bytes) {
    return ReportShare{all == 0 ? 0 : (all + count - 1) / count, bytes / count};
  };
  std::map<std::string, StoredDataset> by_name;
  for (const std::filesystem::path& folder : std::span(found.datasets).first(count)) {
    try_to_add(report, folder.string(), [&] {
      StoredDataset dataset = open_dataset(folder, "");
      ordered_json entry = dataset_report(dataset, most_rows / count);
      entry["heard"] = ordered_json::array();
      const std::string name = entry.at("name");
      report["datasets"].push_back(std::move(entry));
      by_name.try_emplace(name, std::move(dataset));
      try_to_add(report, (folder / "index.h5").string(), [&] {
        report["datasets"].back()["heard"] =
            heard_samples(folder, share(options.sounds, sounds_bytes));
      });
    });
  }
  ordered_json& objects = report["gallery"]["objects"];
  for (const auto& [name, dataset] : by_name) {
    const std::size_t names = by_name.size();
    const ReportShare part = {(options.objects + names - 1) / names, objects_bytes / names};
    try_to_add(report, "objects of " + name, [&] {
      for (ordered_json& object : gallery_objects(dataset, part, report["notes"])) {
        object["dataset"] = name;
        objects.push_back(std::move(object));
      }
      report["gallery"]["bodies"] =
          report["gallery"]["bodies"].get<std::size_t>() + dataset.build.plan.shapes.size();
    });
  }
}

ordered_json collect(const ReportFolders& found, const ReportOptions& options,
                     const Context& context) {
  ordered_json report = {{"title", fmt::format("{}", fmt::join(options.folders, ", "))},
                         {"made", made_by(context)},
                         {"notes", ordered_json::array()}};
  for (const char* list :
       {"datasets", "sweeps", "ladders", "damping", "classification", "transfer", "nights"}) {
    report[list] = ordered_json::array();
  }
  report["gallery"] = {
      {"bodies", 0}, {"objects", ordered_json::array()}, {"materials", gallery_materials()}};
  add_datasets(found, options, report);
  for (const auto& folder : found.sweeps) {
    add_document(report, "sweeps", folder, "sweep.json", "variants");
  }
  for (const auto& folder : found.ladders) {
    add_document(report, "ladders", folder, "accuracy.json", "objects");
  }
  for (const auto& folder : found.nights) {
    add_document(report, "nights", folder, "nightly.json", "measures");
  }
  for (const auto& folder : found.evaluations) {
    if (std::filesystem::is_regular_file(folder / "damping.json")) {
      try_to_add(report, (folder / "damping.json").string(),
                 [&] { report["damping"].push_back(read_damping(folder)); });
    }
    add_document(report, "classification", folder, "classification.json", "rows");
    add_document(report, "transfer", folder, "transfer.json", "rows");
  }
  return report;
}

void run_report(const ReportOptions& options, const Context& context) {
  if (!context.speaks()) return;
  const ReportFolders found = find_report_folders(options.folders);
  ordered_json report = collect(found, options, context);
  const std::string page = report_page(report);
  if (page.size() > large_page) {
    report["notes"].push_back(
        "the page is large: name fewer folders, or give --sounds and "
        "--objects smaller numbers");
  }
  core::write_text_durably(options.output, page);
  if (context.json) {
    fmt::print("{}\n", ordered_json{{"output", options.output},
                                    {"bytes", page.size()},
                                    {"datasets", report["datasets"].size()},
                                    {"ladders", report["ladders"].size()},
                                    {"objects", report["gallery"]["objects"].size()},
                                    {"notes", report["notes"]}}
                           .dump(1));
    return;
  }
  fmt::print("{}: {:.1f} MB\n", options.output, static_cast<double>(page.size()) / 1e6);
  for (const ordered_json& note : report["notes"]) fmt::print("  {}\n", note.get<std::string>());
}

}  // namespace

void add_report(CLI::App& program, Context& context) {
  CLI::App* command = program.add_subcommand(
      "report", "one page that shows datasets, what accuracy costs and what can be learnt");
  auto options = std::make_shared<ReportOptions>();
  command
      ->add_option(
          "folders", options->folders,
          "folders that build, accuracy, evaluate or scripts/nightly made, or that hold such")
      ->required();
  command->add_option("-o,--output", options->output, "HTML file")->capture_default_str();
  command->add_option("--sounds", options->sounds, "samples to hear, of all datasets together")
      ->capture_default_str();
  command->add_option("--objects", options->objects, "objects to strike, of all datasets together")
      ->capture_default_str();
  command->footer(
      "The page needs no network: open it in a browser, send it, print it.\n"
      "Examples:\n"
      "  carillon report carillon-smoke -o report.html\n"
      "  carillon report carillon-smoke carillon-accuracy carillon-learning-smoke\n"
      "docs/report.md");
  command->callback([&context, options] { run_report(*options, context); });
}

}  // namespace carillon::cli
