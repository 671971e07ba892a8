#include <fmt/chrono.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <memory>

#include "cli/context.hpp"
#include "cli/processor.hpp"
#include "cli/report/report.hpp"
#include "core/error.hpp"
#include "core/files.hpp"

namespace carillon::cli {

using nlohmann::ordered_json;

namespace {

/// Together with the page itself and the tables, below 15 MB.
constexpr std::size_t sounds_bytes = 4'000'000;
constexpr std::size_t objects_bytes = 8'000'000;

struct ReportOptions {
  std::vector<std::string> folders;
  std::string output = "report.html";
  std::size_t sounds = 12, objects = 8;
};

ordered_json how_made(const ReportOptions& options) {
  const auto now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  return {{"command", fmt::format("carillon report {} -o {}", fmt::join(options.folders, " "),
                                  options.output)},
          {"date", fmt::format("{:%Y-%m-%d %H:%M} UTC", fmt::gmtime(now))},
          {"version", CARILLON_VERSION},
          {"processor", processor_name()}};
}

/// A file's document with the folder that it lies in.
ordered_json document(const std::filesystem::path& folder, const char* name) {
  ordered_json read = ordered_json::parse(core::read_file(folder / name), nullptr, false);
  if (!read.is_object()) {
    throw core::FileError(fmt::format("{} holds no JSON object", (folder / name).string()));
  }
  read["folder"] = folder.string();
  return read;
}

void append(ordered_json& list, ordered_json more) {
  for (ordered_json& entry : more) list.push_back(std::move(entry));
}

/// Datasets with their sounds and objects; what cannot be read is noted and left out.
void add_datasets(const ReportFolders& found, const ReportOptions& options, ordered_json& report) {
  const std::size_t count = found.datasets.size();
  // At least one of each, as far as the page's bytes go.
  const auto share = [&](std::size_t all, std::size_t bytes) {
    return ReportShare{all == 0 ? 0 : (all + count - 1) / count, bytes / count};
  };
  for (const std::filesystem::path& folder : found.datasets) {
    try {
      const StoredDataset dataset = open_dataset(folder, "");
      ordered_json entry = dataset_report(dataset);
      entry["heard"] = heard_samples(folder, share(options.sounds, sounds_bytes));
      report["datasets"].push_back(std::move(entry));
      append(report["gallery"]["objects"],
             gallery_objects(dataset, share(options.objects, objects_bytes)));
    } catch (const core::Error& error) {
      report["notes"].push_back(
          fmt::format("{} is left out: {}", folder.string(), error.message()));
    } catch (const nlohmann::json::exception& error) {
      report["notes"].push_back(fmt::format("{} is left out, its documents are not as expected: {}",
                                            folder.string(), error.what()));
    }
  }
}

ordered_json collect(const ReportFolders& found, const ReportOptions& options) {
  ordered_json report = {{"title", fmt::format("{}", fmt::join(options.folders, ", "))},
                         {"made", how_made(options)},
                         {"notes", ordered_json::array()}};
  for (const char* list :
       {"datasets", "sweeps", "ladders", "damping", "classification", "transfer", "nights"}) {
    report[list] = ordered_json::array();
  }
  report["gallery"] = {{"objects", ordered_json::array()}, {"materials", gallery_materials()}};
  add_datasets(found, options, report);
  for (const auto& folder : found.sweeps)
    report["sweeps"].push_back(document(folder, "sweep.json"));
  for (const auto& folder : found.ladders) {
    report["ladders"].push_back(document(folder, "accuracy.json"));
  }
  for (const auto& folder : found.nights) {
    report["nights"].push_back(document(folder, "nightly.json"));
  }
  for (const auto& folder : found.evaluations) {
    const ordered_json evaluation = read_evaluation(folder);
    for (const auto& [kind, documents] : evaluation.items()) append(report[kind], documents);
  }
  return report;
}

void run_report(const ReportOptions& options, const Context& context) {
  if (!context.speaks()) return;
  const ReportFolders found = find_report_folders(options.folders);
  const ordered_json report = collect(found, options);
  const std::string page = report_page(report);
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
