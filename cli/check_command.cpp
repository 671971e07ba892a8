#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <unordered_set>

#include "cli/command_line.hpp"
#include "cli/commands.hpp"
#include "core/error.hpp"
#include "core/progress.hpp"
#include "dataset/check/folder.hpp"
#include "dataset/check/leaks.hpp"
#include "dataset/check/publication.hpp"
#include "dataset/check/remade.hpp"
#include "dataset/check/schema.hpp"
#include "dataset/check/values.hpp"
#include "dataset/run/check_files.hpp"
#include "mpi/comm.hpp"

namespace carillon::cli {

using nlohmann::json;

namespace {

struct CheckOptions {
  std::string dataset;
  std::string inputs;
};

/// A check that ran into an error has failed.
dataset::check::Finding guarded(const std::string& name,
                                const std::function<dataset::check::Finding()>& check) {
  try {
    return check();
  } catch (const json::exception& error) {
    return dataset::check::judged(name, {error.what()}, "",
                                  "a JSON file has other fields than it should", "");
  } catch (const std::exception& error) {
    return dataset::check::judged(name, {error.what()}, "", "could not be checked", "");
  }
}

/// This rank's share of what takes time: every so many files and shards.
/// @return {files: [what is wrong], scans: [...], broken: [shards that cannot be read]}
json fraction_of(const json& work, int rank, int size) {
  const std::filesystem::path folder = work.at("folder").get<std::string>();
  json result = {{"files", json::array()}, {"scans", json::array()}, {"broken", json::array()}};
  const auto mine = [&](std::size_t i) {
    return i % static_cast<std::size_t>(size) == static_cast<std::size_t>(rank);
  };
  const json &files = work.at("files"), &shards = work.at("shards");
  for (std::size_t i = 0; i < files.size(); ++i) {
    if (!mine(i)) continue;
    const std::string name = files[i].at("path");
    const std::string wrong = dataset::run::damage_of(folder / name, files[i]);
    if (!wrong.empty()) result["files"].push_back(name + " " + wrong);
  }
  for (std::size_t i = 0; i < shards.size(); ++i) {
    if (!mine(i)) continue;
    try {
      result["scans"].push_back(dataset::check::scan_values(folder / shards[i].get<std::string>()));
    } catch (const std::exception& error) {
      result["broken"].push_back(error.what());
    }
  }
  return result;
}

dataset::check::Finding checksums(const dataset::check::DatasetFolder& folder,
                                  std::vector<std::string> wrong) {
  if (folder.listed.empty() && !folder.building) wrong.push_back("no file is listed");
  double bytes = 0;
  std::unordered_set<std::string> listed;
  for (const json& file : folder.listed) {
    bytes += file.at("bytes").get<double>();
    listed.insert(file.at("path").get<std::string>());
  }
  for (const std::size_t t : folder.present) {
    const std::string path = folder.path_of(t);
    if (!listed.contains(path) && !folder.building) wrong.push_back(path + " is not listed");
  }
  return dataset::check::judged(
      "checksums", std::move(wrong),
      fmt::format("{} files, {}, as they were written", folder.listed.size(),
                  core::human_bytes(bytes)),
      "files are not as they were written",
      "delete these files and run the build again into this folder: they are made again");
}

json report_json(const dataset::check::DatasetFolder& folder,
                 const std::vector<dataset::check::Finding>& findings) {
  json checks = json::array();
  for (const dataset::check::Finding& finding : findings)
    checks.push_back(dataset::check::to_json(finding));
  std::size_t samples = 0;
  for (const std::size_t t : folder.present) samples += folder.dataset.build.plan.tasks[t].count;
  return {{"dataset", folder.dataset.folder.string()},         {"samples", samples},
          {"shapes", folder.dataset.build.plan.shapes.size()}, {"building", folder.building},
          {"passed", dataset::check::all_pass(findings)},      {"checks", checks}};
}

void check_dataset(const CheckOptions& options, mpi::Context& context) {
  dataset::check::DatasetFolder folder;
  std::vector<std::size_t> readable;
  std::vector<dataset::check::Finding> findings;
  std::string work;
  mpi::agreed(context.world, [&] {
    if (!context.speaks()) return;
    try {
      folder = dataset::check::open_folder(options.dataset, options.inputs);
    } catch (const json::exception& error) {
      throw core::InputError(fmt::format("{}: dataset.json has other fields than it should: {}",
                                         options.dataset, error.what()),
                             "run the build again into this folder: it writes the file anew");
    }
    findings = folder.findings;
    findings.push_back(guarded("counts", [&] { return dataset::check::check_counts(folder); }));
    findings.push_back(
        guarded("schema", [&] { return dataset::check::check_schema(folder, readable); }));
    json shards = json::array();
    for (const std::size_t t : readable) shards.push_back(folder.path_of(t));
    work = json{{"folder", options.dataset}, {"files", folder.listed}, {"shards", shards}}.dump(
        -1, ' ', false, json::error_handler_t::replace);
  });
  work = mpi::broadcast(work, 0, context.world);
  std::string own;
  mpi::agreed(context.world, [&] {
    own = fraction_of(json::parse(work), mpi::rank(context.world), mpi::size(context.world))
              .dump(-1, ' ', false, json::error_handler_t::replace);
  });
  const std::vector<std::string> fractions = mpi::all_gather(own, context.world);
  bool passed = false;
  mpi::agreed(context.world, [&] {
    if (!context.speaks()) return;
    std::vector<std::string> wrong;
    std::vector<json> scans;
    for (const std::string& text : fractions) {
      const json fraction = json::parse(text);
      for (const json& file : fraction.at("files")) wrong.push_back(file.get<std::string>());
      for (const json& file : fraction.at("broken")) wrong.push_back(file.get<std::string>());
      for (const json& scan : fraction.at("scans")) scans.push_back(scan);
    }
    std::sort(wrong.begin(), wrong.end());
    findings.push_back(checksums(folder, std::move(wrong)));
    findings.push_back(
        guarded("description", [&] { return dataset::check::check_description(folder); }));
    findings.push_back(
        guarded("index", [&] { return dataset::check::check_index(folder, readable); }));
    std::vector<dataset::check::Row> rows;
    findings.push_back(guarded("ids", [&] {
      rows = dataset::check::read_rows(folder, readable);
      return dataset::check::check_ids(folder, rows);
    }));
    for (dataset::check::Finding& finding : dataset::check::judge_values(scans))
      findings.push_back(std::move(finding));
    findings.push_back(
        guarded("split_shape", [&] { return dataset::check::check_split_shape(folder, rows); }));
    findings.push_back(
        guarded("split_strike", [&] { return dataset::check::check_split_strike(folder, rows); }));
    findings.push_back(guarded("rooms", [&] { return dataset::check::check_rooms(rows); }));
    findings.push_back(guarded("noise", [&] { return dataset::check::check_noise(rows); }));
    findings.push_back(guarded("failures", [&] { return dataset::check::check_failures(folder); }));
    findings.push_back(
        guarded("files", [&] { return dataset::check::check_foreign_files(folder); }));
    findings.push_back(
        guarded("publication", [&] { return dataset::check::check_publication(folder); }));
    passed = dataset::check::all_pass(findings);
    const json report = report_json(folder, findings);
    if (context.json) {
      fmt::print("{}\n", report.dump(2, ' ', false, json::error_handler_t::replace));
      return;
    }
    fmt::print("{}: {} samples of {} shapes{}\n", options.dataset,
               report.at("samples").get<std::size_t>(), report.at("shapes").get<std::size_t>(),
               folder.building ? "; a build is writing to it" : "");
    dataset::check::print(findings);
  });
  passed = mpi::broadcast(passed ? "1" : "0", 0, context.world) == "1";
  context.exit_code = passed ? mpi::exit_done : mpi::exit_failures;
}

}  // namespace

void add_check(Program& program, mpi::Context& context) {
  Command& command = program.add(
      "check", "a dataset: checksums, columns, index, counts, values, leaks between parts",
      Needs::ranks);
  auto options = std::make_shared<CheckOptions>();
  command.option("dataset", options->dataset, "folder of a dataset").required();
  command.option("--inputs", options->inputs,
                 "folder that paths in the configuration (recordings of noise) are meant from");
  command.footer(
      "Ends with 0 when every check passes, with 3 when one fails, with 2 when it is no dataset.\n"
      "Ranks share the reading.\n"
      "Example:\n  carillon check kitchen");
  command.does([&context, options] { check_dataset(*options, context); });
}

}  // namespace carillon::cli
