#include "eval/studies/learning/trainings.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <cmath>
#include <optional>

#include "core/csv.hpp"
#include "core/error.hpp"
#include "core/files.hpp"
#include "core/hash.hpp"
#include "core/json.hpp"
#include "core/progress.hpp"
#include "core/trace.hpp"
#include "eval/networks/nearest_neighbour.hpp"
#include "eval/recognition/recognition.hpp"
#include "eval/studies/learning/detail/answers.hpp"
#include "eval/studies/learning/detail/mpi_learning.hpp"
#include "mpi/comm.hpp"
#include "mpi/interrupt.hpp"

namespace carillon::eval::studies {

using nlohmann::json;
using nlohmann::ordered_json;

namespace {

/// Raised whenever the same inputs would give other numbers.
constexpr int learning_version = 5;

json to_json(const learning::TaskSpec& task) {
  return {{"name", task.name},
          {"column", task.column},
          {"split", task.split},
          {"classes", task.classes},
          {"except", task.except}};
}

/// Of a training without validation samples, their loss and accuracy are nan.
std::string curves_csv(const networks::Trained& trained) {
  std::string text =
      core::csv_line({"epoch", "train_loss", "train_accuracy", "validation_loss",
                      "validation_accuracy", "learning_rate", "seconds", "waited_s", "ranks"});
  const auto number = [](double value) { return fmt::format("{:.6g}", value); };
  for (const learning::Epoch& epoch : trained.epochs) {
    text += core::csv_line({std::to_string(epoch.number), number(epoch.train_loss),
                            number(epoch.train_accuracy), number(epoch.validation_loss),
                            number(epoch.validation_accuracy), number(epoch.learning_rate),
                            fmt::format("{:.3f}", epoch.seconds),
                            fmt::format("{:.3f}", epoch.waited_s), std::to_string(epoch.ranks)});
  }
  return text;
}

ordered_json to_json(const recognition::RecognitionTrial& trial, double temperature) {
  ordered_json found = {
      {"temperature", core::number_or_null(temperature)},
      {"calibration_error", core::number_or_null(trial.calibration_error)},
      {"uncalibrated_error", core::number_or_null(trial.uncalibrated_error)},
      {"calibration_by_chance", core::number_or_null(trial.calibration_by_chance)},
      {"accepted", core::number_or_null(trial.accepted)},
      {"novel", ordered_json::object()}};
  for (const auto& [name, novel] : trial.novel) {
    found["novel"][name] = {
        {"sounds", novel.sounds},
        {"auroc", core::number_or_null(novel.auroc)},
        {"auroc95",
         {core::number_or_null(novel.auroc95.low), core::number_or_null(novel.auroc95.high)}},
        {"accepted", core::number_or_null(novel.accepted)}};
  }
  return found;
}

/// Line of progress of one job.
class Watched {
 public:
  Watched(const TrainingJob& job, const mpi::Context& context)
      : progress_(job.key, static_cast<double>(job.method.learning.epochs),
                  context.quiet || !context.speaks()) {
    watch.step = [this](double done, double of, const learning::Epoch& epoch) {
      progress_.update(
          static_cast<double>(epoch.number - 1) + done / of,
          fmt::format("epoch {}, loss {:.3f}{}", epoch.number, epoch.train_loss, last_));
    };
    watch.epoch = [this](const learning::Epoch& epoch) {
      last_ = std::isnan(epoch.validation_accuracy)
                  ? ""
                  : fmt::format(", validation {:.1f} %", 100 * epoch.validation_accuracy);
    };
    watch.stop = [] { return mpi::interrupt_requested(); };
  }
  void finish(const std::string& note) { progress_.finish(note); }
  networks::LearningWatch watch;

 private:
  core::Progress progress_;
  std::string last_;
};

ordered_json describe(const TrainingJob& job, const learning::SampleSource& source,
                      const learning::LabelledSamples& samples) {
  ordered_json found = {{"key", job.key},
                        {"inputs", job.inputs},
                        {"source", source.name()},
                        {"source_content", source.content()},
                        {"source_folder", std::filesystem::absolute(source.name()).string()},
                        {"task", to_json(job.task)},
                        {"method", learning::to_json(job.method)},
                        {"classes", samples.classes}};
  found["samples"] = {{"train", samples.rows(learning::Part::train).size()},
                      {"validation", samples.rows(learning::Part::validation).size()},
                      {"test", samples.rows(learning::Part::test).size()}};
  return found;
}

void add_training(ordered_json& found, const networks::Trained& trained) {
  double seconds = 0, waited = 0;
  for (const learning::Epoch& epoch : trained.epochs) {
    seconds += epoch.seconds;
    waited += epoch.waited_s;
  }
  found["parameters"] = trained.parameters;
  found["epochs"] = trained.epochs.size();
  found["best_epoch"] = trained.best;
  const double loss =
      trained.best > 0 ? trained.epochs[static_cast<std::size_t>(trained.best - 1)].validation_loss
                       : NAN;
  found["validation_loss"] = core::number_or_null(loss);
  found["silent_samples"] = trained.silent;
  found["timing"] = {{"training_s", seconds}, {"waited_s", waited}};
}

}  // namespace

ordered_json read_record(const std::filesystem::path& folder) {
  const std::filesystem::path path = folder / "training.json";
  ordered_json record = core::read_ordered_json(path);
  if (record.is_null()) {
    throw core::InputError(fmt::format("{} is not there or damaged", path.string()),
                           "delete its folder, and it is trained again");
  }
  return record;
}

TrainingJob make_job(const learning::SampleSource& source, const learning::TaskSpec& task,
                     const learning::Method& method, const std::filesystem::path& models) {
  TrainingJob job;
  job.task = task;
  job.method = method;
  job.key = fmt::format("{}/{}/seed-{}", task.name, method.name, method.learning.seed);
  ordered_json decides = {{"version", learning_version},
                          {"source", source.content()},
                          {"task", to_json(task)},
                          {"method", learning::to_json(method)}};
  job.inputs = core::sha256(decides.dump());
  job.folder = models / task.name / method.name /
               fmt::format("seed-{}-{}", method.learning.seed, job.inputs.substr(0, 8));
  return job;
}

namespace {

/// What a training leaves beside its record.
struct Learnt {
  std::unique_ptr<networks::Learner> learner;  ///< none of neighbours
  networks::Trained trained;
  Answers answers;
  std::optional<recognition::Recognition> recognition;
};

/// The record of a job that was done before, on every rank; null where there is none.
ordered_json found_record(const TrainingJob& job, const mpi::Context& context) {
  ordered_json found;
  mpi::agreed(context.world, [&] {
    if (context.speaks() && std::filesystem::exists(job.folder / "training.json")) {
      found = read_record(job.folder);
    }
  });
  return ordered_json::parse(mpi::broadcast(found.dump(), 0, context.world));
}

Learnt learn(const TrainingJob& job, learning::SampleSource& source,
             const learning::LabelledSamples& samples, const networks::LearningRanks& ranks,
             const networks::LearningWatch& watch, const mpi::Context& context) {
  Learnt learnt;
  if (job.method.kind == learning::MethodKind::nearest_neighbour) return learnt;
  mpi::agreed(context.world, [&] {
    std::vector<learning::SenseExtent> extents;
    for (const learning::Sense sense : job.method.senses) {
      extents.push_back(learning::require_layout(source, sense).extent);
    }
    learnt.learner = std::make_unique<networks::Learner>(job.method, extents, samples.classes);
  });
  learnt.trained =
      learnt.learner->train(source, samples, ranks, {job.folder / "checkpoint", job.inputs}, watch);
  return learnt;
}

/// For what was held out.
void answer(const TrainingJob& job, learning::SampleSource& source,
            const learning::LabelledSamples& samples, const networks::LearningRanks& ranks,
            Learnt& learnt) {
  const auto answers_for = [&](learning::Part part) {
    const std::vector<std::uint32_t> rows = samples.rows(part);
    PartAnswers answers = asked(samples, rows);
    answers.scores = learnt.learner
                         ? learnt.learner->predict(source, samples, rows, ranks)
                         : networks::ask_neighbours(job.method, source, samples, rows, ranks);
    return answers;
  };
  learnt.answers = {samples.classes, answers_for(learning::Part::validation),
                    answers_for(learning::Part::test)};
}

/// What a network that only hears needs to answer for single sounds, and how well it does.
void try_recognition(const TrainingJob& job, learning::SampleSource& source,
                     const learning::LabelledSamples& samples, const networks::LearningRanks& ranks,
                     Learnt& learnt, ordered_json& found) {
  if (!learnt.learner || !learning::only_hears(job.method) || !source.clip_format()) return;
  const Answers& answers = learnt.answers;
  learnt.recognition = recognition::learn_recognition(*learnt.learner, source, samples,
                                                      answers.validation.scores, ranks);
  found["recognition"] =
      to_json(recognition::try_recognition(*learnt.recognition, *learnt.learner, source, samples,
                                           answers.test.scores,
                                           groups_of(answers.test, job.task.split), ranks),
              learnt.recognition->temperature);
}

void add_accuracies(ordered_json& found, const Answers& answers) {
  const std::size_t classes = answers.classes.size();
  const classification::Confusion tested = confusion_of(answers.test, classes);
  found["validation_accuracy"] =
      core::number_or_null(classification::accuracy(confusion_of(answers.validation, classes)));
  found["test_accuracy"] = core::number_or_null(classification::accuracy(tested));
  found["test_balanced_accuracy"] = core::number_or_null(classification::balanced_accuracy(tested));
}

/// The record is written last: what has one is whole.
void keep(const TrainingJob& job, const Learnt& learnt, const ordered_json& found) {
  std::filesystem::create_directories(job.folder);
  if (learnt.learner) {
    learnt.learner->save(job.folder / "model", found);
    core::write_text_durably(job.folder / "curves.csv", curves_csv(learnt.trained));
  }
  if (learnt.recognition)
    recognition::save_recognition(job.folder / "recognition", *learnt.recognition);
  write_answers(job.folder / "answers.h5", learnt.answers);
  core::write_text_durably(job.folder / "training.json", found.dump(1) + "\n");
  std::filesystem::remove(job.folder / "checkpoint");
}

}  // namespace

JobEnd run_job(const TrainingJob& job, learning::SampleSource& source,
               const mpi::Context& context) {
  JobEnd end;
  end.found = found_record(job, context);
  if (!end.found.is_null()) {
    end.was_there = true;
    return end;
  }
  const double start = core::monotonic_seconds();
  const networks::LearningRanks ranks = learning_ranks(context.world);
  learning::LabelledSamples samples;
  mpi::agreed(context.world, [&] {
    samples = learning::label_samples(source, job.task);
    learning::require_learnable(samples, source, job.task);
  });
  end.found = describe(job, source, samples);
  Watched watched(job, context);
  Learnt learnt = learn(job, source, samples, ranks, watched.watch, context);
  if (learnt.trained.interrupted) {
    watched.finish(fmt::format("stopped after {} epochs; the same command goes on",
                               learnt.trained.epochs.size()));
    end.interrupted = true;
    return end;
  }
  if (learnt.learner) add_training(end.found, learnt.trained);
  answer(job, source, samples, ranks, learnt);
  if (job.is_for_use) try_recognition(job, source, samples, ranks, learnt, end.found);
  add_accuracies(end.found, learnt.answers);
  std::vector<std::string> remarks = learning::remarks(samples);
  remarks.insert(remarks.end(), learnt.trained.remarks.begin(), learnt.trained.remarks.end());
  end.found["timing"]["seconds"] = core::monotonic_seconds() - start;
  end.found["ranks"] = ranks.size;
  end.found["remarks"] = remarks;
  // Who chooses sizes sees the validation samples alone.
  const char* part = job.is_for_use ? "test" : "validation";
  const ordered_json& reached = end.found[fmt::format("{}_accuracy", part)];
  watched.finish(reached.is_null() ? fmt::format("no {} samples", part)
                                   : fmt::format("{} {:.1f} %", part, 100 * reached.get<double>()));
  end.found = ordered_json::parse(mpi::broadcast(end.found.dump(), 0, context.world));
  mpi::agreed(context.world, [&] {
    if (!context.speaks()) return;
    keep(job, learnt, end.found);
    for (const std::string& remark : remarks) spdlog::warn("{}: {}", job.key, remark);
  });
  return end;
}

}  // namespace carillon::eval::studies
