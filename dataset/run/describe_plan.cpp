#include <algorithm>
#include <map>
#include <set>

#include "dataset/plan/disk.hpp"
#include "dataset/plan/solver_plan.hpp"
#include "dataset/run/build.hpp"
#include "dataset/run/costs.hpp"
#include "dataset/samples/cast.hpp"
#include "scene/scene.hpp"

namespace carillon::dataset::run {

nlohmann::json describe_plan(const LoadedBuild& build) {
  nlohmann::json effects = scene::describe_effects(build.config.scene, build.config.band.max_modes);
  for (nlohmann::json& effect : effects) {
    effect["seconds"] = effect.at("seconds_per_sound").get<double>() *
                            static_cast<double>(build.plan.samples.size()) +
                        effect.at("seconds_per_shape").get<double>() *
                            static_cast<double>(build.plan.shapes.size());
  }
  double seconds = 0, memory = 0;
  std::map<int, std::size_t> tasks_of_width;
  std::size_t modes_tasks = 0, samples_tasks = 0;
  for (const mpi::Task& task : board_tasks(build.plan, build.config)) {
    seconds += task.cost;
    memory = std::max(memory, task.memory / task.width + idle_rank_bytes);
    ++tasks_of_width[task.width];
  }
  for (const plan::BuildTask& task : build.plan.tasks) {
    ++(task.kind == plan::TaskKind::modes ? modes_tasks : samples_tasks);
  }
  nlohmann::json groups = nlohmann::json::array();
  for (const auto& [width, tasks] : tasks_of_width) {
    groups.push_back({{"ranks", width}, {"tasks", tasks}});
  }
  nlohmann::json shared = nlohmann::json::array();
  if (build.config.motion) {
    std::set<std::string> played;
    for (const scene::motion::CastBody& body : build.config.motion->bodies)
      played.insert(body.object);
    for (const std::string& object : played) {
      if (!samples::held_out(build.config, build.plan, object)) shared.push_back(object);
    }
  }
  return {{"name", build.config.name},
          {"shared_between_parts", shared},
          {"shapes", build.plan.shapes.size()},
          {"samples", build.plan.samples.size()},
          {"tasks", {{"modes", modes_tasks}, {"samples", samples_tasks}}},
          {"groups", groups},
          {"solver", plan::plan_solver(build.config)},
          {"effects", effects},
          {"estimate",
           {{"rank_seconds", seconds},
            {"memory_bytes_per_rank", memory},
            {"disk_bytes",
             plan::sample_bytes(build.config) * static_cast<double>(build.plan.samples.size())}}}};
}

}  // namespace carillon::dataset::run
