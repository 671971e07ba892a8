#include "cli/learn/learning_data.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "cli/build/run_builds.hpp"
#include "cli/check/leaks.hpp"
#include "core/error.hpp"
#include "mpi/comm.hpp"

namespace carillon::cli {

LearningData::LearningData(const BuildOptions& options, MPI_Comm world) {
  const std::string text = shared_text(options.config, world);
  std::string data, name;
  mpi::agreed(world, [&] {
    core::ConfigNode root = core::ConfigNode::parse(text, options.config, options.overrides);
    if (!root.has("data")) return;
    name = root.text("name", std::filesystem::path(options.config).stem().string());
    data = core::path_beside(options.config, root.text("data"));
    root.leave_alone({"train", "evaluate"});
    root.finish();
    if (!std::filesystem::exists(std::filesystem::path(data) / "index.h5")) {
      root.fail("data", fmt::format("{} is no dataset: it has no index.h5", data),
                "give the folder that carillon build wrote");
    }
  });
  if (data.empty()) {
    datasets_.emplace(options, world);
    output_ = datasets_->output();
    const bool alone = datasets_->conditions().size() == 1;
    for (const Condition& condition : datasets_->conditions()) {
      sources_.push_back({alone ? "" : condition.name, condition.folder});
    }
    return;
  }
  output_ = options.output.empty() ? name : options.output;
  sources_.push_back({"", data});
}

int LearningData::build(const Context& context) const {
  return datasets_ ? datasets_->build(context) : exit_done;
}

void require_clean_split(const std::filesystem::path& folder, const std::string& split) {
  const DatasetFolder opened = open_folder(folder, "");
  const std::vector<Row> rows = read_rows(opened, opened.present);
  const Finding findings[] = {
      split == "split_shape" ? check_split_shape(opened, rows) : check_split_strike(opened, rows),
      check_rooms(rows), check_noise(rows)};
  for (const Finding& finding : findings) {
    if (finding.verdict != Verdict::fail) continue;
    throw core::InputError(
        fmt::format(
            "{}: {} leaks from one part into another: {}: {}", folder.string(), split, finding.text,
            fmt::join(finding.items.begin(),
                      finding.items.begin() + static_cast<std::ptrdiff_t>(
                                                  std::min<std::size_t>(3, finding.items.size())),
                      "; ")),
        "what is learnt from it would seem better than it is; carillon check tells all");
  }
}

}  // namespace carillon::cli
