#include "eval/scoring/test_set.hpp"

#include <fmt/format.h>

#include "core/error.hpp"
#include "eval/learning/dataset_source.hpp"
#include "eval/scoring/clean_split.hpp"

namespace carillon::eval::scoring {

TestSet open_test_set(const std::filesystem::path& folder, const learning::TaskSpec& task,
                      const std::optional<dataset::exporters::Seal>& seal,
                      const std::filesystem::path& cache) {
  const auto source = learning::open_dataset_source(folder);
  const learning::LabelledSamples samples = learning::label_samples(*source, task);
  require_clean_split(folder, task.split, cache);
  if (seal && seal->split != task.split) {
    throw core::InputError(
        fmt::format("task {} is held out by {}, and the export hides parts of {}", task.name,
                    task.split, seal->split),
        fmt::format("carillon export --hide test --split {}", task.split));
  }
  const std::vector<std::uint32_t> rows = samples.rows(learning::Part::test);
  if (rows.empty()) {
    throw core::InputError(
        fmt::format("{}: task {}: {} holds no sample to test", folder.string(), task.name,
                    task.split),
        "more objects or strikes, or a larger split.test in the dataset's configuration");
  }
  TestSet set{
      folder.string(), source->content(), task, samples.classes, asked(samples, rows), {}, {}};
  const auto id_of = [&](const std::string& key) { return seal ? seal->id_of(key) : key; };
  for (std::size_t i = 0; i < rows.size(); ++i) set.row_of[id_of(set.asked.keys[i])] = i;
  for (std::size_t i = 0; i < samples.keys.size(); ++i) {
    // Test samples of a sealed export have no other name there; others may be hidden, or not.
    const bool has_key = !seal || samples.part[i] != learning::Part::test;
    for (const std::string& id : {id_of(samples.keys[i]), has_key ? samples.keys[i] : ""}) {
      if (!id.empty() && !set.row_of.contains(id)) set.part_of[id] = samples.part[i];
    }
  }
  if (seal && !seal->is_of(samples.keys)) {
    throw core::InputError(fmt::format("the seal is of another dataset than {}", folder.string()),
                           "--sealed names the file that carillon export --hide wrote with it");
  }
  return set;
}

learning::TaskSpec task_of_column(const std::string& name) {
  learning::TaskSpec task;
  task.name = name;
  task.column = name == "geometry" ? "shape" : name;
  task.split = task.column == "shape" ? "split_strike" : "split_shape";
  return task;
}

}  // namespace carillon::eval::scoring
