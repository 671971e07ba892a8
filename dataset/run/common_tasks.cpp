#include "dataset/run/common_tasks.hpp"

#include "dataset/run/costs.hpp"

namespace carillon::dataset::run {

CommonTasks common_tasks(const std::vector<BuildRun>& builds) {
  CommonTasks common;
  for (const BuildRun& run : builds) {
    const auto first = static_cast<std::int64_t>(common.tasks.size());
    common.first.push_back(common.tasks.size());
    for (mpi::Task& task : board_tasks(run.build.plan, run.build.config)) {
      task.key = run.name + task.key;
      for (std::int64_t& earlier : task.after) earlier += first;
      common.tasks.push_back(std::move(task));
    }
  }
  common.first.push_back(common.tasks.size());
  common.done.assign(common.tasks.size(), false);
  return common;
}

}  // namespace carillon::dataset::run
