#include "eval/studies/learning/detail/transfer.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "core/error.hpp"
#include "eval/recognition/recognition.hpp"
#include "eval/scoring/answers.hpp"
#include "eval/scoring/seed_answers.hpp"
#include "eval/studies/learning/detail/mpi_learning.hpp"
#include "eval/studies/learning/detail/open_condition.hpp"
#include "eval/studies/learning/detail/sample_costs.hpp"
#include "eval/studies/learning/learning_sources.hpp"
#include "eval/studies/learning/trainings.hpp"
#include "mpi/comm.hpp"

namespace carillon::eval::studies {

using learning::Part;
using learning::Selection;

namespace {

void append(std::vector<Selection>& all, const std::vector<Selection>& some) {
  all.insert(all.end(), some.begin(), some.end());
}

/// One transfer on its way.
class Run {
 public:
  Run(const TransferSpec& spec, const EvaluatedDatasets& datasets, MPI_Comm world)
      : spec_(spec),
        datasets_(datasets),
        world_(world),
        models_(datasets.output() / "evaluation" / "transfer"),
        target_(open_target()) {
    mpi::agreed(world, [&] { sample_s_ = seconds_per_sample(datasets.conditions()); });
  }

  /// What the target's own samples teach: what others are held against.
  /// @return whether it was not interrupted
  bool learn_at_home();
  bool learn_elsewhere(std::size_t condition);
  /// Before anything is trained: mixes have as many samples as they take.
  void require_enough();
  bool mix();
  /// The rows, each held against the target's own samples and the dataset `against`.
  std::vector<TransferRow> compared() const;

 private:
  /// Recordings are clipped as the sounds are that classifiers learn from.
  OpenCondition open_target() {
    std::optional<learning::ClipFormat> format;
    if (spec_.target.recordings) {
      const std::size_t first = spec_.mixed_with.value_or(spec_.trained_on.front());
      format = opened(first).source->clip_format();
    }
    return open(spec_.target, format);
  }
  OpenCondition open(const Condition& condition,
                     const std::optional<learning::ClipFormat>& format = {}) const {
    OpenCondition opened;
    opened.source = open_source(condition, spec_.learning, datasets_.cache(), world_, format);
    mpi::agreed(world_, [&] {
      opened.samples = learning::label_samples(*opened.source, spec_.task);
      if (&condition != &spec_.target) {
        learning::require_learnable(opened.samples, *opened.source, spec_.task);
      }
    });
    return opened;
  }
  /// One of the datasets, which is opened and checked once.
  const OpenCondition& opened(std::size_t condition) {
    const auto found = opened_.find(condition);
    if (found != opened_.end()) return found->second;
    return opened_.emplace(condition, open(datasets_.conditions()[condition])).first->second;
  }
  /// Recordings that nothing is learnt from are tested whole.
  bool tests_all() const { return spec_.target.recordings && !spec_.mixed_with; }
  std::vector<Selection> tested() const {
    std::vector<Selection> tested = target_.part(Part::test, 1);
    if (!tests_all()) return tested;
    for (const Part part : {Part::train, Part::validation}) append(tested, target_.part(part, 1));
    for (Selection& one : tested) one.part = Part::test;
    return tested;
  }
  /// Trains with a selection of two sources, of which the second is the target, once for each seed.
  /// @return whether it was not interrupted
  bool learn(learning::SampleSource& other, const std::vector<Selection>& selected,
             const learning::Method& method, TransferRow row);

  const TransferSpec& spec_;
  const EvaluatedDatasets& datasets_;
  const MPI_Comm world_;
  std::filesystem::path models_;
  std::map<std::size_t, OpenCondition> opened_;
  OpenCondition target_;
  std::optional<KeyedSounds> target_sounds_;     ///< once they are compared
  std::vector<std::optional<double>> sample_s_;  ///< of each dataset
  std::vector<TransferRow> rows_;
  std::vector<scoring::SeedAnswers> there_;  ///< of each row, in the target
  std::vector<std::string> inputs_;          ///< of each row: what it was trained with
};

/// The samples of a part whose keys begin with a source's number.
scoring::PartAnswers answers_of(const scoring::PartAnswers& part, char source,
                                std::size_t classes) {
  scoring::PartAnswers own;
  for (std::size_t i = 0; i < part.samples(); ++i) {
    if (part.keys[i].front() != source) continue;
    own.keys.push_back(part.keys[i]);
    own.labels.push_back(part.labels[i]);
    own.objects.push_back(part.objects[i]);
    own.strikes.push_back(part.strikes[i]);
    const auto first = part.scores.begin() + static_cast<std::ptrdiff_t>(i * classes);
    own.scores.insert(own.scores.end(), first, first + static_cast<std::ptrdiff_t>(classes));
  }
  return own;
}

bool Run::learn(learning::SampleSource& other, const std::vector<Selection>& selected,
                const learning::Method& method, TransferRow row) {
  std::unique_ptr<learning::SampleSource> source;
  mpi::agreed(world_, [&] {
    source = learning::select_samples({&other, target_.source.get()}, selected);
  });
  learning::TaskSpec task = spec_.task;
  task.except.clear();  // none of them is selected
  scoring::SeedAnswers own(task.split), there(task.split);
  std::string inputs;
  std::vector<double> unknown;
  for (const learning::Method& seeded : with_seeds(method, spec_.seeds)) {
    TrainingJob job = make_job(*source, task, seeded, models_);
    const std::string seed = fmt::format("{}/seed-{}", method.name, seeded.learning.seed);
    job.key = row.kind == LearntFrom::mixed || row.kind == LearntFrom::alone
                  ? fmt::format("{:.0f} % {}/{}", 100 * row.fraction, row.trained_on, seed)
                  : fmt::format("{}/{}", row.trained_on, seed);
    job.is_for_use = false;
    const JobEnd end = run_job(job, *source, world_);
    if (end.interrupted) return false;
    mpi::agreed(world_, [&] {
      const scoring::Answers answers = scoring::read_answers(job.folder / "answers.h5");
      own.add(answers_of(answers.test, '0', answers.classes.size()), answers.classes);
      const scoring::PartAnswers target = answers_of(answers.test, '1', answers.classes.size());
      there.add(target, answers.classes);
      if (learning::only_hears(method) && answers.classes.size() > 1 && target.samples() > 0 &&
          answers.validation.samples() > 0) {
        unknown.push_back(recognition::unknown_fraction(answers.validation.scores,
                                                        scoring::true_classes(answers.validation),
                                                        target.scores, answers.classes.size()));
      }
      row.samples = end.record.train_samples;
    });
    inputs += job.inputs;
  }
  mpi::agreed(world_, [&] {
    row.method = method.name;
    row.own = own.summary(classification::AccuracyKind::plain, inputs);
    row.there = there.summary(classification::AccuracyKind::plain, inputs);
    row.balanced_there = there.summary(classification::AccuracyKind::balanced, inputs);
    row.classes = there.classes();
    row.confusion_there = there.confusion();
    if (!unknown.empty()) row.unknown_there = statistics::mean(unknown);
    if (own.empty() || there.empty()) return;
    const classification::ConfusionDifference difference =
        classification::confusion_difference(own.confusion(), there.confusion());
    row.compared_classes = difference.rows;
    if (difference.rows == 0) return;
    row.confusion_norm = difference.norm;
    row.norm_by_chance = own.norm_by_chance(there);
  });
  rows_.push_back(std::move(row));
  there_.push_back(std::move(there));
  inputs_.push_back(std::move(inputs));
  return true;
}

std::vector<TransferRow> Run::compared() const {
  const auto place_of = [&](LearntFrom kind, const std::string& trained_on,
                            const std::string& method) {
    std::size_t place = 0;
    while (place < rows_.size() &&
           !(rows_[place].kind == kind && rows_[place].trained_on == trained_on &&
             rows_[place].method == method)) {
      ++place;
    }
    return place;
  };
  const std::string& against = datasets_.conditions()[spec_.against].name;
  std::vector<TransferRow> rows = rows_;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const auto less = [&](std::size_t other) -> std::optional<scoring::Estimate> {
      if (other == rows.size() || inputs_[other] == inputs_[r]) return std::nullopt;  // itself
      return there_[r].less(there_[other]);
    };
    rows[r].less_home = less(place_of(LearntFrom::target, spec_.target.name, rows[r].method));
    rows[r].gain = less(place_of(LearntFrom::elsewhere, against, rows[r].method));
  }
  return rows;
}

bool Run::learn_at_home() {
  if (tests_all() || target_.part(Part::train, 1).empty()) return true;
  std::vector<Selection> selected;
  for (const Part part : {Part::train, Part::validation, Part::test}) {
    append(selected, target_.part(part, 1));
  }
  // The same source beside it as in mixes, whose last share this is.
  const OpenCondition& other = opened(spec_.mixed_with.value_or(spec_.trained_on.front()));
  TransferRow row;
  row.kind = LearntFrom::target;
  row.trained_on = spec_.target.name;
  row.fraction = 1;
  if (spec_.own_target) row.sample_s = sample_s_[*spec_.own_target];
  for (const learning::Method& method : spec_.methods) {
    if (!learn(*other.source, selected, method, row)) return false;
  }
  return true;
}

bool Run::learn_elsewhere(std::size_t condition) {
  const Condition& named = datasets_.conditions()[condition];
  const OpenCondition& other = opened(condition);
  mpi::agreed(world_, [&] {
    require_one_part({other.source.get(), target_.source.get()}, spec_.task.split);
  });
  TransferRow row;
  row.trained_on = named.name;
  if (named.build != nullptr && spec_.target.build != nullptr && spec_.heard > 0) {
    std::vector<std::string> keys;
    mpi::agreed(world_, [&] {
      if (!target_sounds_) target_sounds_.emplace(spec_.target.folder, spec_.learning.listener);
      keys = common_keys(target_, other, spec_.heard);
    });
    row.heard = heard_difference(*target_sounds_, named.folder, keys, spec_.learning.listener,
                                 learning_ranks(world_));
  }
  std::vector<Selection> selected;
  for (const Part part : {Part::train, Part::validation, Part::test}) {
    append(selected, other.part(part, 0));
  }
  append(selected, tested());
  row.sample_s = sample_s_[condition];
  for (const learning::Method& method : spec_.methods) {
    if (!learn(*other.source, selected, method, row)) return false;
  }
  return true;
}

void Run::require_enough() {
  if (!spec_.mixed_with) return;
  const Condition& named = datasets_.conditions()[*spec_.mixed_with];
  const OpenCondition& other = opened(*spec_.mixed_with);
  const double minimum = *std::min_element(spec_.fractions.begin(), spec_.fractions.end());
  const std::size_t all = target_.part(Part::train, 1).size();
  const std::size_t wanted =
      all - static_cast<std::size_t>(std::llround(minimum * static_cast<double>(all)));
  const std::size_t there = other.part(Part::train, 0).size();
  mpi::agreed(world_, [&] {
    if (all == 0) {
      throw core::InputError(
          fmt::format("{} has no samples for training to be mixed", spec_.target.name));
    }
    if (wanted <= there) return;
    throw core::InputError(
        fmt::format("a mix with {:.0f} % of {} takes {} samples of {}, which has {} for training",
                    100 * minimum, spec_.target.name, wanted, named.name, there),
        "build more of them, or leave small shares out");
  });
}

/// Few samples are met as much more often: as many steps as of all of them. (Others know no
/// epochs.)
void take_steps_of(std::size_t all, std::size_t few, learning::Method& method) {
  if (method.kind != learning::MethodKind::network) return;
  const auto steps = [&](std::size_t samples) {
    return std::ceil(static_cast<double>(samples) / static_cast<double>(method.learning.batch));
  };
  const double more = steps(all) / steps(few);
  for (std::int64_t* passes : {&method.learning.epochs, &method.learning.patience}) {
    *passes = std::llround(more * static_cast<double>(*passes));
  }
}

bool Run::mix() {
  const OpenCondition& other = opened(*spec_.mixed_with);
  const auto fraction_of = [&](double fraction, Part part) {
    const auto all = static_cast<double>(target_.part(part, 1).size());
    return std::pair{static_cast<std::size_t>(std::llround(fraction * all)),
                     static_cast<std::size_t>(all)};
  };
  for (const double fraction : spec_.fractions) {
    const auto [own, all] = fraction_of(fraction, Part::train);
    for (const bool mixed : {true, false}) {
      if ((!mixed && own == 0) || (mixed && own == all)) continue;
      std::vector<Selection> selected;
      // What says when training ends is had at the same share: it is paid for alike.
      for (const Part part : {Part::train, Part::validation}) {
        const auto [of_target, whole] = fraction_of(fraction, part);
        append(selected, target_.first_of(part, of_target, 1));
        if (mixed) append(selected, other.last_of(part, whole - of_target, 0));
      }
      append(selected, target_.part(Part::test, 1));
      TransferRow row;
      row.kind = mixed ? LearntFrom::mixed : LearntFrom::alone;
      row.trained_on = mixed ? "mixed" : "target alone";
      row.fraction = fraction;
      for (learning::Method method : spec_.methods) {
        if (!mixed) take_steps_of(all, own, method);
        if (!learn(*other.source, selected, method, row)) return false;
      }
    }
  }
  return true;
}

}  // namespace

std::optional<std::vector<TransferRow>> run_transfer(const TransferSpec& spec,
                                                     const EvaluatedDatasets& datasets,
                                                     MPI_Comm world) {
  Run run(spec, datasets, world);
  run.require_enough();
  if (!run.learn_at_home()) return std::nullopt;
  for (const std::size_t condition : spec.trained_on) {
    if (!run.learn_elsewhere(condition)) return std::nullopt;
  }
  if (spec.mixed_with && !run.mix()) return std::nullopt;
  std::vector<TransferRow> rows;
  mpi::agreed(world, [&] { rows = run.compared(); });
  return rows;
}

}  // namespace carillon::eval::studies
