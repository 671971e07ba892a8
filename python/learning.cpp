#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "core/error.hpp"
#include "eval/learning/batches.hpp"
#include "eval/learning/dataset_source.hpp"
#include "eval/learning/half.hpp"
#include "eval/scoring/score.hpp"
#include "python/runtime.hpp"

namespace carillon::python {

namespace {

namespace learning = eval::learning;

using RowNumbers = py::array_t<std::uint64_t, py::array::c_style | py::array::forcecast>;

learning::Modality modality_named(const std::string& name) {
  const auto* found =
      std::find_if(std::begin(learning::all_modalities), std::end(learning::all_modalities),
                   [&](learning::Modality modality) { return name_of(modality) == name; });
  if (found == std::end(learning::all_modalities)) {
    throw core::InputError(fmt::format("no modality \"{}\"", name));
  }
  return *found;
}

/// Entries of a modality for some samples of a dataset, as networks get them: each is read once.
std::vector<float> read_entries(learning::SampleSource& source, learning::Modality modality,
                                const learning::ModalityLayout& layout,
                                std::vector<std::uint32_t> entries) {
  const std::vector<std::uint32_t> wanted = entries;
  std::sort(entries.begin(), entries.end());
  entries.erase(std::unique(entries.begin(), entries.end()), entries.end());
  const std::size_t each = learning::values_in(layout.extent);
  std::vector<float> read(entries.size() * each);
  source.read(modality, entries, read);
  if (learning::is_kept_as_halves(modality)) {
    std::vector<std::uint16_t> halves(read.size());
    learning::to_half(read, halves);
    learning::from_half(halves, read);
  }
  std::vector<float> values;
  values.reserve(wanted.size() * each);
  for (const std::uint32_t entry : wanted) {
    const auto at = std::lower_bound(entries.begin(), entries.end(), entry) - entries.begin();
    const auto first = read.begin() + at * static_cast<std::ptrdiff_t>(each);
    values.insert(values.end(), first, first + static_cast<std::ptrdiff_t>(each));
  }
  return values;
}

py::array_t<float> prepared(const std::string& folder, std::size_t listener,
                            const std::string& name, const RowNumbers& numbers) {
  std::vector<float> values;
  std::vector<py::ssize_t> shape = {numbers.size()};
  {
    const std::vector<std::uint64_t> rows(numbers.data(), numbers.data() + numbers.size());
    const py::gil_scoped_release unlocked;
    const auto source = learning::open_dataset_source(folder, listener);
    const learning::Modality modality = modality_named(name);
    const learning::ModalityLayout layout = learning::require_layout(*source, modality);
    const std::vector<std::uint32_t> shared =
        layout.shared ? source->entries_of(modality) : std::vector<std::uint32_t>{};
    std::vector<std::uint32_t> entries;
    for (const std::uint64_t row : rows) {
      if (row >= source->size()) {
        throw core::InputError(fmt::format("{} has no sample {}", folder, row),
                               fmt::format("it has {}, counted from 0", source->size()));
      }
      entries.push_back(layout.shared ? shared[row] : static_cast<std::uint32_t>(row));
    }
    shape.insert(shape.end(), layout.extent.begin(), layout.extent.end());
    if (!entries.empty()) values = read_entries(*source, modality, layout, std::move(entries));
  }
  py::array_t<float> array(shape);
  std::copy(values.begin(), values.end(), array.mutable_data());
  return array;
}

/// @param answers  files and names of their entries
std::string score(const std::string& dataset, const std::string& task,
                  const std::vector<std::pair<std::string, std::string>>& answers,
                  const std::string& tasks, const std::string& sealed, const std::string& output,
                  const std::string& cache) {
  eval::scoring::ScoreRequest request{dataset, task, {}, tasks, sealed, output, cache};
  for (const auto& [path, name] : answers) request.answers.push_back({path, name});
  start_solver();
  return interruptible([request](const Waiting&) {
    const eval::scoring::Scored scored = eval::scoring::score(request);
    return nlohmann::ordered_json{{"entries", scored.entries},
                                  {"leaderboard", to_json(scored.board)},
                                  {"folder", scored.folder.string()},
                                  {"text", to_text(scored.board)}}
        .dump();
  });
}

}  // namespace

void bind_learning(py::module_& module) {
  module.def("prepared", &prepared);
  module.def("score", &score);
}

}  // namespace carillon::python
