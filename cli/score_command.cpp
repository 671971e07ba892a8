#include <fmt/format.h>

#include <memory>

#include "cli/command_line.hpp"
#include "cli/commands.hpp"
#include "core/error.hpp"
#include "eval/scoring/score.hpp"

namespace carillon::cli {

using nlohmann::ordered_json;

namespace {

struct ScoreOptions {
  std::string dataset, task, name, tasks, seal, output;
  std::vector<std::string> answers;
};

void print_score(const ScoreOptions& options, const Context& context) {
  eval::scoring::ScoreRequest request{options.dataset, options.task,   {},           options.tasks,
                                      options.seal,    options.output, context.cache};
  for (const std::string& path : options.answers) {
    request.answers.push_back({path, options.name});
  }
  const eval::scoring::Scored scored = eval::scoring::score(request);
  if (context.json) {
    ordered_json document = {{"entries", scored.entries},
                             {"leaderboard", to_json(scored.board)},
                             {"folder", scored.folder.string()}};
    fmt::print("{}\n", document.dump(1));
    return;
  }
  for (const std::string& text : scored.texts) fmt::print("{}\n", text);
  fmt::print("{}\n{}: leaderboard-{}.json, .csv, .md\n", to_text(scored.board),
             scored.folder.string(), scored.board.task);
}

void run_score(const ScoreOptions& options, const Context& context) {
  if (options.answers.size() > 1 && !options.name.empty()) {
    throw core::InputError("--name names one entry, and there are several files of answers",
                           "without it each is called as its file");
  }
  on_one_rank(context, [&] { print_score(options, context); });
}

}  // namespace

void add_score(Program& program, Context& context) {
  Command& command = program.add(
      "score", "anyone's answers for a dataset's test samples, and where they stand among others",
      Needs::ranks);
  auto options = std::make_shared<ScoreOptions>();
  command.option("dataset", options->dataset, "folder of a dataset").required();
  command
      .option("--task", options->task,
              "what was asked: a column of labels (material, family, label_NAME; geometry: which "
              "shape), a task of --tasks; damping, modes: of each object that is held out")
      .required();
  command.option(
      "--answers", options->answers,
      "CSV, .npz, .npy or .parquet with columns sample and class, or one of "
      "probabilities for each class; each file is an entry. Without it: the board alone");
  command.option("--name", options->name, "of the entry (default: the file's)");
  command.option("--tasks", options->tasks,
                 "configuration whose section train.tasks has the task, with groups of labels or "
                 "another split");
  command.option("--sealed", options->seal,
                 "what `carillon export --hide test` kept: samples go by the export's names");
  command.option("-o,--output", options->output,
                 "folder that keeps entries and board in evaluation/ (default: the dataset's)");
  command.footer(
      "Examples:\n"
      "  carillon score carillon-smoke --task material --answers mine.csv\n"
      "  carillon score carillon-smoke --task damping --answers fits.csv --name \"my fit\"\n"
      "  carillon score carillon-smoke --task material --sealed carillon-smoke-wav-sealed.json "
      "--answers theirs.csv\n"
      "docs/service.md");
  command.does([&context, options] { run_score(*options, context); });
}

}  // namespace carillon::cli
