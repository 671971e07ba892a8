#include "cli/learn/transfer.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include "cli/learn/answers.hpp"
#include "cli/learn/learning_sources.hpp"
#include "cli/learn/tables.hpp"
#include "cli/learn/trainings.hpp"
#include "core/error.hpp"
#include "core/files.hpp"
#include "core/random.hpp"
#include "eval/learning/selected_source.hpp"
#include "mpi/comm.hpp"

namespace carillon::cli {

using core::ConfigNode;
using eval::Part;
using eval::Selection;
using nlohmann::ordered_json;

namespace {

std::size_t dataset_called(ConfigNode& node, const std::string& key, const std::string& name,
                           const EvaluatedDatasets& datasets) {
  std::vector<std::string> names;
  for (std::size_t c = 0; c < datasets.conditions().size(); ++c) {
    names.push_back(datasets.conditions()[c].name);
    if (names.back() == name) return c;
  }
  node.fail(key, fmt::format("there is no dataset \"{}\"", name),
            fmt::format("there are {}", fmt::join(names, "; ")));
}

std::vector<eval::Method> read_methods(ConfigNode& node, const LearningConfig& learning) {
  std::vector<std::string> known, networks;
  for (const eval::Method& method : learning.methods) {
    known.push_back(method.name);
    if (method.kind == eval::MethodKind::network) networks.push_back(method.name);
  }
  const std::vector<std::string> first = {networks.empty() ? known.front() : networks.front()};
  std::vector<eval::Method> methods;
  for (const std::string& name : node.texts("methods", first)) {
    const auto found = std::find(known.begin(), known.end(), name);
    if (found == known.end()) {
      node.fail("methods", fmt::format("train.methods has no \"{}\"", name));
    }
    methods.push_back(learning.methods[static_cast<std::size_t>(found - known.begin())]);
  }
  return methods;
}

void read_mixes(ConfigNode& node, const EvaluatedDatasets& datasets, TransferSpec& spec) {
  if (!node.has("mixes")) return;
  ConfigNode mixes = node.child("mixes");
  spec.mixed_with = dataset_called(mixes, "with", mixes.text("with"), datasets);
  spec.shares = mixes.quantities("shares", core::Dimension::none, 0,
                                 std::vector<double>{0, 0.1, 0.3, 0.6, 1});
  for (const double share : spec.shares) {
    if (!(share >= 0 && share <= 1)) mixes.fail("shares", "lie within 0 and 1");
  }
  if (spec.shares.empty()) mixes.fail("shares", "names no share");
}

/// A source, and its samples of the task.
struct OpenCondition {
  std::unique_ptr<eval::SampleSource> source;
  eval::LabelledSamples samples;

  std::vector<Selection> part(Part part, std::uint32_t number) const {
    std::vector<Selection> some;
    for (const std::uint32_t row : samples.rows(part)) some.push_back({number, row, part});
    return some;
  }
  /// So many of the samples for training, the same ones of more always among them.
  std::vector<Selection> some_for_training(std::size_t count, std::uint32_t number) const {
    std::vector<Selection> all = part(Part::train, number);
    std::sort(all.begin(), all.end(),
              [&](const Selection& a, const Selection& b) { return order_of(a) < order_of(b); });
    all.resize(count);
    return all;
  }
  std::pair<std::uint64_t, std::uint32_t> order_of(const Selection& one) const {
    return {core::stable_hash("mix " + samples.keys[one.row]), one.row};
  }
};

/// What a build took for each sample [s], where it was built here.
std::optional<double> seconds_per_sample(const Condition& condition, std::size_t samples) {
  const std::filesystem::path path = condition.folder / "trace.json";
  if (condition.recordings || !std::filesystem::exists(path)) return std::nullopt;
  const nlohmann::json trace = nlohmann::json::parse(core::read_file(path));
  double seconds = 0;
  for (const nlohmann::json& task : trace.at("tasks")) {
    if (task.at("kind") == "samples") seconds += task.at("seconds").get<double>();
  }
  return seconds / static_cast<double>(samples);
}

/// One transfer on its way.
class Run {
 public:
  Run(const TransferSpec& spec, const EvaluatedDatasets& datasets, const Context& context)
      : spec_(spec),
        datasets_(datasets),
        context_(context),
        models_(datasets.output() / "evaluation" / "transfer"),
        target_(open(spec.target)) {}

  /// @return whether it was not interrupted
  bool learn_elsewhere(std::size_t condition);
  /// Before anything is trained: mixes have as many samples as they take.
  void require_enough();
  bool mix();

  std::vector<TransferRow> rows;

 private:
  OpenCondition open(const Condition& condition) const {
    OpenCondition opened;
    opened.source = open_source(condition, spec_.learning, context_);
    mpi::agreed(context_.world, [&] {
      opened.samples = eval::label_samples(*opened.source, spec_.task);
      if (&condition != &spec_.target) {
        eval::require_learnable(opened.samples, *opened.source, spec_.task);
      }
    });
    return opened;
  }
  /// Trains with a selection of two sources, of which the second is the target.
  /// @return whether it was not interrupted
  bool learn(eval::SampleSource& other, const std::vector<Selection>& selected,
             const eval::Method& method, TransferRow row);

  const TransferSpec& spec_;
  const EvaluatedDatasets& datasets_;
  const Context& context_;
  std::filesystem::path models_;
  OpenCondition target_;
};

void append(std::vector<Selection>& all, const std::vector<Selection>& some) {
  all.insert(all.end(), some.begin(), some.end());
}

/// Refuses a target whose test samples are learnt from in another condition of the same sweep,
/// where keys and shapes name the same strikes and bodies.
void require_apart(const OpenCondition& other, const OpenCondition& target,
                   const eval::TaskSpec& task, const std::string& name) {
  const bool bodies = task.split == "split_shape";
  const auto names = [&](const OpenCondition& one) {
    return bodies ? one.source->labels("shape") : one.samples.keys;
  };
  const std::vector<std::string> there = names(other), tested = names(target);
  std::set<std::string> learnt;
  for (const Part part : {Part::train, Part::validation}) {
    for (const std::uint32_t row : other.samples.rows(part)) learnt.insert(there[row]);
  }
  for (const std::uint32_t row : target.samples.rows(Part::test)) {
    if (!learnt.contains(tested[row])) continue;
    throw core::InputError(
        fmt::format("{} is tested in the target and learnt in {}", tested[row], name),
        "a sweep over seed or split puts samples into other parts: leave these out of it");
  }
}

/// The samples of a part whose keys begin with a source's number.
PartAnswers answers_of(const PartAnswers& part, char source, std::size_t classes) {
  PartAnswers own;
  for (std::size_t i = 0; i < part.samples(); ++i) {
    if (part.keys[i].front() != source) continue;
    own.keys.push_back(part.keys[i]);
    own.labels.push_back(part.labels[i]);
    own.bodies.push_back(part.bodies[i]);
    const auto first = part.scores.begin() + static_cast<std::ptrdiff_t>(i * classes);
    own.scores.insert(own.scores.end(), first, first + static_cast<std::ptrdiff_t>(classes));
  }
  return own;
}

ordered_json summary_of(const PartAnswers& part, std::size_t classes, const TrainingJob& job) {
  if (part.samples() == 0) return nullptr;
  std::vector<std::size_t> groups(part.bodies.begin(), part.bodies.end());
  if (job.task.split != "split_shape") std::iota(groups.begin(), groups.end(), std::size_t{0});
  const std::vector<std::size_t> truth = true_classes(part);
  return accuracy_summary({truth, groups, classes}, {likely_classes(part, classes)},
                          eval::AccuracyKind::plain, job.inputs);
}

bool Run::learn(eval::SampleSource& other, const std::vector<Selection>& selected,
                const eval::Method& method, TransferRow row) {
  std::unique_ptr<eval::SampleSource> source;
  mpi::agreed(context_.world, [&] {
    source = eval::select_samples({&other, target_.source.get()}, selected);
  });
  eval::TaskSpec task = spec_.task;
  task.except.clear();  // none of them is selected
  TrainingJob job = make_job(*source, task, method, models_);
  job.key = row.share > 0 || row.own.is_null()
                ? fmt::format("{:.0f} % {}/{}", 100 * row.share, row.trained_on, method.name)
                : fmt::format("{}/{}", row.trained_on, method.name);
  job.is_for_use = false;
  const JobEnd end = run_job(job, *source, context_);
  if (end.interrupted) return false;
  mpi::agreed(context_.world, [&] {
    const Answers answers = read_answers(job.folder / "answers.h5");
    const std::size_t classes = answers.classes.size();
    const PartAnswers own = answers_of(answers.test, '0', classes);
    const PartAnswers there = answers_of(answers.test, '1', classes);
    row.method = method.name;
    row.samples = end.found.at("samples").at("train");
    row.own = summary_of(own, classes, job);
    row.there = summary_of(there, classes, job);
    if (own.samples() > 0 && there.samples() > 0) {
      const eval::ConfusionDifference difference =
          eval::confusion_difference(confusion_of(own, classes), confusion_of(there, classes));
      if (difference.rows > 0) row.confusion_norm = difference.norm;
      row.compared_classes = difference.rows;
    }
  });
  rows.push_back(std::move(row));
  return true;
}

bool Run::learn_elsewhere(std::size_t condition) {
  const Condition& named = datasets_.conditions()[condition];
  const OpenCondition other = open(named);
  if (named.build != nullptr && spec_.target.build != nullptr) {
    mpi::agreed(context_.world, [&] { require_apart(other, target_, spec_.task, named.name); });
  }
  std::vector<Selection> selected;
  for (const Part part : {Part::train, Part::validation, Part::test}) {
    append(selected, other.part(part, 0));
  }
  append(selected, target_.part(Part::test, 1));
  TransferRow row;
  row.trained_on = named.name;
  row.own = ordered_json::object();
  mpi::agreed(context_.world,
              [&] { row.sample_s = seconds_per_sample(named, other.source->size()); });
  for (const eval::Method& method : spec_.methods) {
    if (!learn(*other.source, selected, method, row)) return false;
  }
  return true;
}

void Run::require_enough() {
  if (!spec_.mixed_with) return;
  const Condition& named = datasets_.conditions()[*spec_.mixed_with];
  const OpenCondition other = open(named);
  const double least = *std::min_element(spec_.shares.begin(), spec_.shares.end());
  const std::size_t all = target_.part(Part::train, 1).size();
  const std::size_t wanted =
      all - static_cast<std::size_t>(std::llround(least * static_cast<double>(all)));
  const std::size_t there = other.part(Part::train, 0).size();
  mpi::agreed(context_.world, [&] {
    if (all == 0) {
      throw core::InputError(
          fmt::format("{} has no samples for training to be mixed", spec_.target.name));
    }
    if (wanted <= there) return;
    throw core::InputError(
        fmt::format("a mix with {:.0f} % of {} takes {} samples of {}, which has {} for training",
                    100 * least, spec_.target.name, wanted, named.name, there),
        "build more of them, or leave small shares out");
  });
}

bool Run::mix() {
  const OpenCondition other = open(datasets_.conditions()[*spec_.mixed_with]);
  const std::size_t all = target_.part(Part::train, 1).size();
  for (const double share : spec_.shares) {
    const auto own = static_cast<std::size_t>(std::llround(share * static_cast<double>(all)));
    for (const bool mixed : {true, false}) {
      if ((!mixed && own == 0) || (mixed && own == all)) continue;
      std::vector<Selection> selected = target_.some_for_training(own, 1);
      if (mixed) append(selected, other.some_for_training(all - own, 0));
      // Without samples of the target, none of them may say when training ends.
      append(selected,
             own > 0 ? target_.part(Part::validation, 1) : other.part(Part::validation, 0));
      append(selected, target_.part(Part::test, 1));
      TransferRow row;
      row.kind = mixed ? "mixed" : "alone";
      row.trained_on = mixed ? "mixed" : "target alone";
      row.share = share;
      for (const eval::Method& method : spec_.methods) {
        if (!learn(*other.source, selected, method, row)) return false;
      }
    }
  }
  return true;
}

}  // namespace

TransferSpec read_transfer(ConfigNode& node, ConfigNode& root, const EvaluatedDatasets& datasets) {
  TransferSpec spec;
  spec.learning = read_train_section(root, datasets.config());
  std::vector<std::string> tasks;
  for (const eval::TaskSpec& task : spec.learning.tasks) tasks.push_back(task.name);
  const std::string task = node.choice("task", tasks, tasks.front());
  spec.task = spec.learning.tasks[static_cast<std::size_t>(
      std::find(tasks.begin(), tasks.end(), task) - tasks.begin())];
  spec.methods = read_methods(node, spec.learning);
  std::optional<std::size_t> own_target;
  if (auto given = read_given(node, "target", datasets.config())) {
    spec.target = std::move(*given);
  } else {
    own_target = dataset_called(node, "target", node.text("target"), datasets);
    spec.target = datasets.conditions()[*own_target];
  }
  for (std::size_t c = 0; c < datasets.conditions().size(); ++c) {
    if (c != own_target) spec.trained_on.push_back(c);
  }
  read_mixes(node, datasets, spec);
  if (spec.mixed_with && spec.mixed_with == own_target) {
    node.fail("mixes", "the target cannot be mixed with itself");
  }
  if (spec.trained_on.empty() && !spec.mixed_with) {
    node.fail("target", "there is no other dataset to learn from",
              "a sweep makes several; data or recordings take a target from elsewhere");
  }
  return spec;
}

std::optional<std::vector<TransferRow>> run_transfer(const TransferSpec& spec,
                                                     const EvaluatedDatasets& datasets,
                                                     const Context& context) {
  Run run(spec, datasets, context);
  run.require_enough();
  for (const std::size_t condition : spec.trained_on) {
    if (!run.learn_elsewhere(condition)) return std::nullopt;
  }
  if (spec.mixed_with && !run.mix()) return std::nullopt;
  return run.rows;
}

ordered_json transfer_document(const TransferSpec& spec, const EvaluatedDatasets& datasets,
                               const std::vector<TransferRow>& rows) {
  ordered_json document = {{"name", datasets.name()},  {"task", spec.task.name},
                           {"split", spec.task.split}, {"target", spec.target.name},
                           {"mixed_with", nullptr},    {"rows", ordered_json::array()}};
  if (spec.mixed_with) {
    document["mixed_with"] = datasets.conditions()[*spec.mixed_with].name;
  }
  for (const TransferRow& row : rows) {
    ordered_json line = {{"kind", row.kind},
                         {"trained_on", row.trained_on},
                         {"method", row.method},
                         {"share", row.share},
                         {"samples", row.samples},
                         {"own", row.own},
                         {"target", row.there},
                         {"confusion_norm", nullptr},
                         {"compared_classes", row.compared_classes},
                         {"sample_s", nullptr}};
    if (row.confusion_norm) line["confusion_norm"] = *row.confusion_norm;
    if (row.sample_s) line["sample_s"] = *row.sample_s;
    document["rows"].push_back(std::move(line));
  }
  return document;
}

std::string transfer_text(const ordered_json& document) {
  std::vector<std::vector<std::string>> elsewhere = {{"trained on", "method", "samples",
                                                      "accuracy there", "in the target",
                                                      "confusions apart", "ms a sample"}};
  std::vector<std::vector<std::string>> mixes = {
      {"of the target", "method", "with", "samples", "in the target"}};
  for (const ordered_json& row : document.at("rows")) {
    const std::string trained_on = row.at("trained_on");
    const std::string samples = fmt::format("{}", row.at("samples").get<std::size_t>());
    if (const std::string kind = row.at("kind"); kind != "elsewhere") {
      mixes.push_back({fmt::format("{:.0f} %", 100 * row.at("share").get<double>()),
                       row.at("method"),
                       kind == "mixed" ? document.at("mixed_with").get<std::string>() : "-",
                       samples, with_interval(row.at("target"))});
      continue;
    }
    const ordered_json& norm = row.at("confusion_norm");
    const ordered_json& seconds = row.at("sample_s");
    elsewhere.push_back(
        {trained_on, row.at("method"), samples, with_interval(row.at("own")),
         with_interval(row.at("target")),
         norm.is_null() ? "-"
                        : fmt::format("{:.3f} of {} classes", norm.get<double>(),
                                      row.at("compared_classes").get<std::size_t>()),
         seconds.is_null() ? "-" : fmt::format("{:.1f}", 1e3 * seconds.get<double>())});
  }
  std::string text =
      fmt::format("# {}: {} in {}\n", document.at("name").get<std::string>(),
                  document.at("task").get<std::string>(), document.at("target").get<std::string>());
  if (elsewhere.size() > 1) {
    text += "\nLearnt in one condition, tested where it learnt and in the target; percent.\n\n" +
            markdown(elsewhere);
  }
  if (mixes.size() > 1) {
    text +=
        "\nTraining sets with shares of the target's own samples; percent.\n\n" + markdown(mixes);
  }
  return text;
}

}  // namespace carillon::cli
