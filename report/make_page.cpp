#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <functional>
#include <map>
#include <span>

#include "core/error.hpp"
#include "report/report.hpp"

namespace carillon::report {

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

/// So many folders as are shown, the first ones; what is left out is noted.
std::span<const std::filesystem::path> first_of(const std::vector<std::filesystem::path>& folders,
                                                std::size_t max, const char* what,
                                                ordered_json& report) {
  const std::size_t count = std::min(folders.size(), max);
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
NamedDatasets add_datasets(const ReportFolders& found, const PageRequest& request,
                           ordered_json& report) {
  const auto shown = first_of(found.datasets, max_datasets, "datasets", report);
  const std::size_t count = shown.size();
  NamedDatasets by_name;
  for (const std::filesystem::path& folder : shown) {
    require_shards(folder);
    try_to_add(report, folder.string(), [&] {
      dataset::stored::StoredDataset dataset = dataset::stored::open_dataset(folder, "");
      ordered_json entry = dataset_report(dataset, max_rows / count);
      entry["heard"] = ordered_json::array();
      const std::string name = entry.at("name");
      report["datasets"].push_back(std::move(entry));
      by_name.try_emplace(name, std::move(dataset));
      // At least one of each, as far as the page's bytes go.
      const ReportShare share = {(request.sounds + count - 1) / count, sounds_bytes / count};
      try_to_add(report, (folder / "index.h5").string(),
                 [&] { report["datasets"].back()["heard"] = heard_samples(folder, share); });
    });
  }
  return by_name;
}

void add_gallery(const NamedDatasets& datasets, std::size_t bytes, const PageRequest& request,
                 ordered_json& report) {
  ordered_json& gallery = report["gallery"];
  std::size_t left = datasets.size();
  for (const auto& named : datasets) {
    const auto& dataset = named.second;
    const ReportShare share = {(request.objects + datasets.size() - 1) / datasets.size(),
                               bytes / left--};
    try_to_add(report, "objects of " + named.first, [&] {
      ordered_json here = gallery_objects(dataset, share, report["notes"]);
      for (ordered_json& object : here.at("objects")) {
        object["dataset"] = named.first;
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

/// Names of the files that `carillon score` wrote in an evaluation's folder, in their order.
std::vector<std::string> leaderboards_in(const std::filesystem::path& folder) {
  std::vector<std::string> names;
  std::error_code unreadable;  // then there are none to show
  for (const auto& entry : std::filesystem::directory_iterator(folder, unreadable)) {
    const std::string name = entry.path().filename().string();
    if (name.starts_with("leaderboard-") && name.ends_with(".json")) names.push_back(name);
  }
  std::sort(names.begin(), names.end());
  return names;
}

/// Of the nightly runs the last one, which tells of those before.
void add_nightly(const ReportFolders& found, ordered_json& report) {
  if (found.nightly_runs.empty()) return;
  if (found.nightly_runs.size() > 1) {
    report["notes"].push_back(
        fmt::format("of {} nightly runs the last one is shown: name another one's folder to see it",
                    found.nightly_runs.size()));
  }
  add_document(report, "nightly_runs", found.nightly_runs.back(), "nightly.json", "measures");
}

ordered_json collect(const ReportFolders& found, const PageRequest& request) {
  ordered_json report = {{"title", fmt::format("{}", fmt::join(request.folders, ", "))},
                         {"made", request.made},
                         {"notes", ordered_json::array()}};
  for (const char* list : {"datasets", "sweeps", "studies", "damping", "classification", "transfer",
                           "leaderboards", "nightly_runs"}) {
    report[list] = ordered_json::array();
  }
  report["gallery"] = {{"total", 0},
                       {"objects", ordered_json::array()},
                       {"left_out", ordered_json::object()},
                       {"materials", gallery_materials()}};
  for (const std::string& why : found.unreadable) report["notes"].push_back(why);
  const NamedDatasets datasets = add_datasets(found, request, report);
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
    add("damping", "damping.json", read_damping);
    add("classification", "classification.json", read_classification);
    add_document(report, "transfer", folder, "transfer.json", "rows");
    for (const std::string& name : leaderboards_in(folder)) {
      add_document(report, "leaderboards", folder, name, "rows");
    }
  }
  const std::size_t rest = std::min(full_page, report_page(report).size());
  add_gallery(datasets, std::max(min_objects_bytes, full_page - rest), request, report);
  return report;
}

}  // namespace

Page make_page(const PageRequest& request) {
  ordered_json report =
      collect(find_report_folders(request.folders, request.may_be_empty), request);
  Page page;
  page.html = report_page(report);
  if (page.html.size() > large_page) {
    report["notes"].push_back(
        fmt::format("this page has {:.0f} MB: name fewer folders, or give --sounds and --objects "
                    "smaller numbers",
                    static_cast<double>(page.html.size()) / 1e6));
    page.html = report_page(report);
  }
  page.datasets = report["datasets"].size();
  page.studies = report["studies"].size();
  page.objects = report["gallery"]["objects"].size();
  page.notes = report["notes"].get<std::vector<std::string>>();
  return page;
}

}  // namespace carillon::report
