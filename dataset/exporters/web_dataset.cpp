#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>

#include "core/error.hpp"
#include "core/files.hpp"
#include "core/progress.hpp"
#include "dataset/exporters/detail/npy_rows.hpp"
#include "dataset/exporters/detail/tar_file.hpp"
#include "dataset/exporters/export.hpp"
#include "dataset/stored/sample_audio.hpp"
#include "dataset/stored/shared_rows.hpp"

namespace carillon::dataset::exporters {

namespace {

/// A column whose rows are written as arrays: of samples, or of what they share.
struct Array {
  std::string name;
  NpyRows rows;
  std::vector<std::int64_t> row_of;  ///< of each sample; empty: as samples are numbered
};

[[noreturn]] void refuse_array(const core::Hdf5Group& index, const std::string& name) {
  std::vector<std::string> there = index.names();
  for (const stored::SharedRows& shared : stored::shared_rows()) {
    if (!index.has(shared.column)) continue;
    const std::vector<std::string> more = index.open_group(shared.group).names();
    there.insert(there.end(), more.begin(), more.end());
  }
  throw core::InputError(fmt::format("the dataset has no \"{}\"", name),
                         fmt::format("there are {}", fmt::join(there, ", ")));
}

std::vector<Array> open_arrays(const core::Hdf5Group& index,
                               const std::vector<std::string>& names) {
  std::vector<Array> arrays;
  for (const std::string& name : names) {
    const stored::ArrayPlace place = stored::find_array(index, name);
    if (place.path.empty()) refuse_array(index, name);
    arrays.push_back({name, NpyRows(index, place.path), {}});
    if (!place.column.empty()) arrays.back().row_of = index.read<std::int64_t>(place.column);
  }
  return arrays;
}

struct Shard {
  std::string name;
  std::vector<std::size_t> rows;
};

/// A part's samples in the order of their ids, so many to a shard.
std::vector<Shard> make_shards(const ExportedRows& rows, std::size_t per_shard) {
  std::vector<Shard> shards;
  for (auto& [part, members] : rows.by_part()) {
    std::sort(members.begin(), members.end(),
              [&](std::size_t a, std::size_t b) { return rows.id(a) < rows.id(b); });
    for (std::size_t first = 0; first < members.size(); first += per_shard) {
      const auto begin = members.begin() + static_cast<std::ptrdiff_t>(first);
      const auto end = members.begin() +
                       static_cast<std::ptrdiff_t>(std::min(members.size(), first + per_shard));
      shards.push_back({fmt::format("{}-{:06}.tar", part, first / per_shard), {begin, end}});
    }
  }
  return shards;
}

}  // namespace

std::vector<ExportedFile> write_web_dataset(const Export& task,
                                            const std::vector<std::string>& arrays,
                                            std::size_t per_shard) {
  const stored::SampleAudio audio(task.index);
  const std::vector<Array> more = open_arrays(task.index, arrays);
  const std::vector<Shard> shards = make_shards(task.rows, per_shard);
  std::vector<std::size_t> own_rows;
  for (std::size_t s = 0; s < shards.size(); ++s) {
    if (!task.is_own(s)) continue;
    own_rows.insert(own_rows.end(), shards[s].rows.begin(), shards[s].rows.end());
  }
  LabelStream labels(task.rows, own_rows);
  core::Progress progress("export", static_cast<double>(shards.size()), task.rank != 0, "shards");
  std::vector<ExportedFile> files;
  for (std::size_t s = 0; s < shards.size(); ++s) {
    if (!task.is_own(s)) continue;
    core::write_durably(task.output / shards[s].name, [&](const std::filesystem::path& path) {
      TarFile tar(path);
      for (const std::size_t row : shards[s].rows) {
        const std::string& key = task.rows.key(row);
        tar.add(key + ".wav", core::wav_bytes(key, audio.read(row, 1).front(), audio.format()));
        tar.add(key + ".json", labels.next().dump());
        for (const Array& array : more) {
          const auto entry =
              array.row_of.empty() ? row : static_cast<std::uint64_t>(array.row_of[row]);
          tar.add(key + "." + array.name + ".npy", array.rows.row(entry));
        }
      }
      tar.finish();
    });
    files.push_back(exported_file(task.output, shards[s].name));
    progress.update(static_cast<double>(s + 1), shards[s].name);
  }
  progress.finish("");
  return files;
}

}  // namespace carillon::dataset::exporters
