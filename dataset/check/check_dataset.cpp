#include "dataset/check/check_dataset.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <nlohmann/json.hpp>
#include <unordered_set>

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

namespace carillon::dataset::check {

using nlohmann::json;

namespace {

/// A check that ran into an error has failed.
Finding guarded(const std::string& name, const std::function<Finding()>& check) {
  try {
    return check();
  } catch (const json::exception& error) {
    return judged(name, {error.what()}, "", "a JSON file has other fields than it should", "");
  } catch (const std::exception& error) {
    return judged(name, {error.what()}, "", "could not be checked", "");
  }
}

/// What takes time, for all ranks together.
struct CheckWork {
  std::string folder{};
  std::vector<run::ListedFile> files{};
  std::vector<std::string> shards{};
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(CheckWork, folder, files, shards)

/// What a rank found.
struct CheckShare {
  std::vector<std::string> wrong{};  ///< files that are not as listed, shards that cannot be read
  std::vector<ValueScan> scans{};
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
    const run::ListedFile& file = work.files[i];
    const std::string damage = run::damage_of(folder / file.path, file);
    if (!damage.empty()) share.wrong.push_back(file.path + " " + damage);
  }
  for (std::size_t i = 0; i < work.shards.size(); ++i) {
    if (!mine(i)) continue;
    try {
      share.scans.push_back(scan_values(folder / work.shards[i]));
    } catch (const std::exception& error) {
      share.wrong.push_back(error.what());
    }
  }
  return share;
}

Finding checksums(const DatasetFolder& folder, std::vector<std::string> wrong) {
  if (folder.listed.empty() && !folder.building) wrong.push_back("no file is listed");
  double bytes = 0;
  std::unordered_set<std::string> listed;
  for (const run::ListedFile& file : folder.listed) {
    bytes += static_cast<double>(file.bytes);
    listed.insert(file.path);
  }
  for (const std::size_t t : folder.present) {
    const std::string path = folder.path_of(t);
    if (!listed.contains(path) && !folder.building) wrong.push_back(path + " is not listed");
  }
  return judged("checksums", std::move(wrong),
                fmt::format("{} files, {}, as they were written", folder.listed.size(),
                            core::human_bytes(bytes)),
                "files are not as they were written",
                "delete these files and run the build again into this folder: they are made again");
}

}  // namespace

CheckedDataset check_dataset(const std::filesystem::path& dataset, const std::string& inputs,
                             MPI_Comm comm) {
  const bool first = mpi::rank(comm) == 0;
  CheckedDataset checked;
  DatasetFolder folder;
  std::vector<std::size_t> readable;
  std::vector<Finding>& findings = checked.findings;
  std::string work;
  mpi::agreed(comm, [&] {
    if (!first) return;
    try {
      folder = open_folder(dataset, inputs);
    } catch (const json::exception& error) {
      throw core::InputError(fmt::format("{}: dataset.json has other fields than it should: {}",
                                         dataset.string(), error.what()),
                             "run the build again into this folder: it writes the file anew");
    }
    findings = folder.findings;
    findings.push_back(guarded("counts", [&] { return check_counts(folder); }));
    findings.push_back(guarded("schema", [&] { return check_schema(folder, readable); }));
    CheckWork all{dataset.string(), folder.listed};
    for (const std::size_t t : readable) all.shards.push_back(folder.path_of(t));
    work = sent_text(all);
  });
  work = mpi::broadcast(work, 0, comm);
  std::string own;
  mpi::agreed(comm, [&] {
    own = sent_text(share_of(json::parse(work).get<CheckWork>(), mpi::rank(comm), mpi::size(comm)));
  });
  const std::vector<std::string> shares = mpi::all_gather(own, comm);
  mpi::agreed(comm, [&] {
    if (!first) return;
    std::vector<std::string> wrong;
    std::vector<ValueScan> scans;
    for (const std::string& text : shares) {
      const auto share = json::parse(text).get<CheckShare>();
      wrong.insert(wrong.end(), share.wrong.begin(), share.wrong.end());
      scans.insert(scans.end(), share.scans.begin(), share.scans.end());
    }
    std::sort(wrong.begin(), wrong.end());
    findings.push_back(checksums(folder, std::move(wrong)));
    findings.push_back(guarded("description", [&] { return check_description(folder); }));
    findings.push_back(guarded("index", [&] { return check_index(folder, readable); }));
    std::vector<Row> rows;
    findings.push_back(guarded("ids", [&] {
      rows = read_rows(folder, readable);
      return check_ids(folder, rows);
    }));
    for (Finding& finding : judge_values(scans)) findings.push_back(std::move(finding));
    findings.push_back(guarded("split_shape", [&] { return check_split_shape(folder, rows); }));
    findings.push_back(guarded("split_strike", [&] { return check_split_strike(folder, rows); }));
    findings.push_back(guarded("rooms", [&] { return check_rooms(rows); }));
    findings.push_back(guarded("noise", [&] { return check_noise(rows); }));
    findings.push_back(guarded("failures", [&] { return check_failures(folder); }));
    findings.push_back(guarded("warnings", [&] { return check_warnings(folder); }));
    findings.push_back(guarded("pitches", [&] { return check_pitches(folder); }));
    findings.push_back(guarded("files", [&] { return check_foreign_files(folder); }));
    findings.push_back(guarded("publication", [&] { return check_publication(folder); }));
    checked.passed = all_pass(findings);
    checked.name = folder.dataset.folder.string();
    checked.shapes = folder.dataset.build.plan.shapes.size();
    checked.building = folder.building;
    for (const std::size_t t : folder.present) {
      checked.samples += folder.dataset.build.plan.tasks[t].count;
    }
  });
  checked.passed = mpi::broadcast(checked.passed ? "1" : "0", 0, comm) == "1";
  return checked;
}

}  // namespace carillon::dataset::check
