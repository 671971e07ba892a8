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

/// What takes time, for all ranks together.
struct CheckWork {
  std::string folder{};
  std::vector<dataset::run::ListedFile> files{};
  std::vector<std::string> shards{};
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(CheckWork, folder, files, shards)

/// What a rank found.
struct CheckShare {
  std::vector<std::string> wrong{};  ///< files that are not as listed, shards that cannot be read
  std::vector<dataset::check::ValueScan> scans{};
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(CheckShare, wrong, scans)

/// As ranks send it to each other.
std::string sent_text(const json& sent) {
  return sent.dump(-1, ' ', false, json::error_handler_t::replace);
}

/// This rank's share: every so many files and shards.
CheckShare share_of(const CheckWork& work, int rank, int size) {
  const std::filesystem::path folder = work.folder;
  CheckShare share;
  const auto mine = [&](std::size_t i) {
    return i % static_cast<std::size_t>(size) == static_cast<std::size_t>(rank);
  };
  for (std::size_t i = 0; i < work.files.size(); ++i) {
    if (!mine(i)) continue;
    const dataset::run::ListedFile& file = work.files[i];
    const std::string damage = dataset::run::damage_of(folder / file.path, file);
    if (!damage.empty()) share.wrong.push_back(file.path + " " + damage);
  }
  for (std::size_t i = 0; i < work.shards.size(); ++i) {
    if (!mine(i)) continue;
    try {
      share.scans.push_back(dataset::check::scan_values(folder / work.shards[i]));
    } catch (const std::exception& error) {
      share.wrong.push_back(error.what());
    }
  }
  return share;
}

dataset::check::Finding checksums(const dataset::check::DatasetFolder& folder,
                                  std::vector<std::string> wrong) {
  if (folder.listed.empty() && !folder.building) wrong.push_back("no file is listed");
  double bytes = 0;
  std::unordered_set<std::string> listed;
  for (const dataset::run::ListedFile& file : folder.listed) {
    bytes += static_cast<double>(file.bytes);
    listed.insert(file.path);
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

/// A dataset's findings, to a person or a program.
void tell(const dataset::check::DatasetFolder& folder,
          const std::vector<dataset::check::Finding>& findings, const core::Tell& tell) {
  json checks = json::array();
  for (const dataset::check::Finding& finding : findings)
    checks.push_back(dataset::check::to_json(finding));
  std::size_t samples = 0;
  for (const std::size_t t : folder.present) samples += folder.dataset.build.plan.tasks[t].count;
  const std::string name = folder.dataset.folder.string();
  const std::size_t shapes = folder.dataset.build.plan.shapes.size();
  tell(fmt::format("{}: {} samples of {} shapes{}\n{}", name, samples, shapes,
                   folder.building ? "; a build is writing to it" : "",
                   dataset::check::findings_text(findings)),
       json{{"dataset", name},
            {"samples", samples},
            {"shapes", shapes},
            {"building", folder.building},
            {"passed", dataset::check::all_pass(findings)},
            {"checks", checks}});
}

void check_dataset(const CheckOptions& options, Context& context) {
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
    CheckWork all{options.dataset, folder.listed};
    for (const std::size_t t : readable) all.shards.push_back(folder.path_of(t));
    work = sent_text(all);
  });
  work = mpi::broadcast(work, 0, context.world);
  std::string own;
  mpi::agreed(context.world, [&] {
    own = sent_text(share_of(json::parse(work).get<CheckWork>(), mpi::rank(context.world),
                             mpi::size(context.world)));
  });
  const std::vector<std::string> shares = mpi::all_gather(own, context.world);
  bool passed = false;
  mpi::agreed(context.world, [&] {
    if (!context.speaks()) return;
    std::vector<std::string> wrong;
    std::vector<dataset::check::ValueScan> scans;
    for (const std::string& text : shares) {
      const auto share = json::parse(text).get<CheckShare>();
      wrong.insert(wrong.end(), share.wrong.begin(), share.wrong.end());
      scans.insert(scans.end(), share.scans.begin(), share.scans.end());
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
    tell(folder, findings, teller(context));
  });
  passed = mpi::broadcast(passed ? "1" : "0", 0, context.world) == "1";
  context.exit_code = passed ? mpi::exit_done : mpi::exit_failures;
}

}  // namespace

void add_check(Program& program, Context& context) {
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
