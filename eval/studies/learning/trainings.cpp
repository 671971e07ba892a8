#include "eval/studies/learning/trainings.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <cmath>
#include <optional>

#include "core/csv.hpp"
#include "core/error.hpp"
#include "core/files.hpp"
#include "core/hash.hpp"
#include "core/progress.hpp"
#include "core/trace.hpp"
#include "eval/networks/nearest_neighbour.hpp"
#include "eval/recognition/recognition.hpp"
#include "eval/scoring/answers.hpp"
#include "eval/studies/learning/detail/mpi_learning.hpp"
#include "mpi/comm.hpp"
#include "mpi/interrupt.hpp"

namespace carillon::eval::studies {

namespace {

/// Raised whenever the same inputs would give other numbers.
constexpr int learning_version = 7;

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

/// Line of progress of one job.
class Watched {
 public:
  Watched(const TrainingJob& job, bool silent)
      : progress_(job.key, static_cast<double>(job.method.learning.epochs), silent) {
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

TrainingRecord describe(const TrainingJob& job, const learning::SampleSource& source,
                        const learning::LabelledSamples& samples) {
  TrainingRecord record;
  record.key = job.key;
  record.inputs = job.inputs;
  record.source = source.name();
  record.source_content = source.content();
  record.source_folder = std::filesystem::absolute(source.name()).string();
  record.task = job.task;
  record.method = job.method;
  record.classes = samples.classes;
  record.train_samples = samples.rows(learning::Part::train).size();
  record.validation_samples = samples.rows(learning::Part::validation).size();
  record.test_samples = samples.rows(learning::Part::test).size();
  return record;
}

TrainingRecord::Learnt summary_of(const networks::Trained& trained) {
  TrainingRecord::Learnt learnt{.parameters = trained.parameters,
                                .epochs = trained.epochs.size(),
                                .best_epoch = trained.best,
                                .silent_samples = trained.silent};
  if (trained.best > 0) {
    learnt.validation_loss =
        trained.epochs[static_cast<std::size_t>(trained.best - 1)].validation_loss;
  }
  learnt.training_s = trained.seconds;
  for (const learning::Epoch& epoch : trained.epochs) {
    learnt.training_s += epoch.seconds;
    learnt.waited_s += epoch.waited_s;
  }
  return learnt;
}

/// Rank 0's record on every rank; nothing where it has none.
std::optional<TrainingRecord> shared(const std::optional<TrainingRecord>& record, MPI_Comm world) {
  const std::string text = record ? to_json(*record).dump() : "null";
  const auto found = nlohmann::json::parse(mpi::broadcast(text, 0, world));
  if (found.is_null()) return std::nullopt;
  return record_from(found);
}

}  // namespace

TrainingJob make_job(const learning::SampleSource& source, const learning::TaskSpec& task,
                     const learning::Method& method, const std::filesystem::path& models) {
  TrainingJob job;
  job.task = task;
  job.method = method;
  job.key = fmt::format("{}/{}/seed-{}", task.name, method.name, method.learning.seed);
  nlohmann::ordered_json decides = {{"version", learning_version},
                                    {"source", source.content()},
                                    {"task", learning::to_json(task)},
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
  scoring::Answers answers;
  std::optional<recognition::Recognition> recognition;
};

/// The record of a job that was done before, on every rank.
std::optional<TrainingRecord> found_record(const TrainingJob& job, MPI_Comm world) {
  std::optional<TrainingRecord> record;
  mpi::agreed(world, [&] {
    if (mpi::rank(world) == 0 && std::filesystem::exists(job.folder / "training.json")) {
      record = read_record(job.folder);
    }
  });
  return shared(record, world);
}

Learnt learn(const TrainingJob& job, learning::SampleSource& source,
             const learning::LabelledSamples& samples, const networks::LearningRanks& ranks,
             const networks::LearningWatch& watch, MPI_Comm world) {
  Learnt learnt;
  if (job.method.kind == learning::MethodKind::nearest_neighbour) return learnt;
  mpi::agreed(world, [&] {
    std::vector<learning::ModalityExtent> extents;
    for (const learning::Modality modality : job.method.modalities) {
      extents.push_back(learning::require_layout(source, modality).extent);
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
    scoring::PartAnswers answers = scoring::asked(samples, rows);
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
                     Learnt& learnt, TrainingRecord& record) {
  if (!learnt.learner || !learning::only_hears(job.method) || !source.clip_format()) return;
  const scoring::Answers& answers = learnt.answers;
  learnt.recognition = recognition::learn_recognition(*learnt.learner, source, samples,
                                                      answers.validation.scores, ranks);
  record.recognition = recognition::try_recognition(
      *learnt.recognition, *learnt.learner, source, samples, answers.test.scores,
      scoring::groups_of(answers.test, job.task.split), ranks);
}

void add_accuracies(TrainingRecord& record, const scoring::Answers& answers) {
  const std::size_t classes = answers.classes.size();
  const classification::Confusion tested = scoring::confusion_of(answers.test, classes);
  record.validation_accuracy =
      classification::accuracy(scoring::confusion_of(answers.validation, classes));
  record.test_accuracy = classification::accuracy(tested);
  record.test_balanced_accuracy = classification::balanced_accuracy(tested);
}

/// The record is written last: what has one is whole.
void keep(const TrainingJob& job, const Learnt& learnt, const TrainingRecord& record) {
  std::filesystem::create_directories(job.folder);
  if (learnt.learner) {
    learnt.learner->save(job.folder / "model");
    learnt.learner->save_for_others(job.folder);
  }
  if (!learnt.trained.epochs.empty()) {
    core::write_text_durably(job.folder / "curves.csv", curves_csv(learnt.trained));
  }
  if (learnt.recognition)
    recognition::save_recognition(job.folder / "recognition", *learnt.recognition);
  scoring::write_answers(job.folder / "answers.h5", learnt.answers);
  core::write_text_durably(job.folder / "training.json", to_json(record).dump(1) + "\n");
  std::filesystem::remove(job.folder / "checkpoint");
}

/// Where classes are not equally many, the mean of their recalls first.
std::string reached(const char* part, double accuracy, std::optional<double> balanced) {
  if (std::isnan(accuracy)) return fmt::format("no {} samples", part);
  if (!balanced || *balanced == accuracy) return fmt::format("{} {:.1f} %", part, 100 * accuracy);
  return fmt::format("{} {:.1f} % balanced, {:.1f} % of all", part, 100 * *balanced,
                     100 * accuracy);
}

}  // namespace

JobEnd run_job(const TrainingJob& job, learning::SampleSource& source, MPI_Comm world) {
  JobEnd end;
  if (auto record = found_record(job, world)) {
    end.was_there = true;
    end.record = std::move(*record);
    return end;
  }
  const double start = core::monotonic_seconds();
  const networks::LearningRanks ranks = learning_ranks(world);
  learning::LabelledSamples samples;
  mpi::agreed(world, [&] {
    samples = learning::label_samples(source, job.task);
    learning::require_learnable(samples, source, job.task);
  });
  TrainingRecord record = describe(job, source, samples);
  Watched watched(job, mpi::rank(world) != 0);
  Learnt learnt = learn(job, source, samples, ranks, watched.watch, world);
  if (learnt.trained.interrupted) {
    watched.finish(learnt.trained.epochs.empty()
                       ? "stopped"
                       : fmt::format("stopped after {} epochs; the same command goes on",
                                     learnt.trained.epochs.size()));
    end.interrupted = true;
    return end;
  }
  if (learnt.learner) {
    record.learnt = summary_of(learnt.trained);
    record.device = learnt.learner->device();
  }
  answer(job, source, samples, ranks, learnt);
  if (job.is_for_use) try_recognition(job, source, samples, ranks, learnt, record);
  add_accuracies(record, learnt.answers);
  record.remarks = learning::remarks(samples);
  record.remarks.insert(record.remarks.end(), learnt.trained.remarks.begin(),
                        learnt.trained.remarks.end());
  record.seconds = core::monotonic_seconds() - start;
  record.ranks = ranks.size;
  // Who chooses sizes sees the validation samples alone.
  watched.finish(job.is_for_use
                     ? reached("test", record.test_accuracy, record.test_balanced_accuracy)
                     : reached("validation", record.validation_accuracy, {}));
  end.record = *shared(record, world);
  mpi::agreed(world, [&] {
    if (mpi::rank(world) != 0) return;
    keep(job, learnt, end.record);
    for (const std::string& remark : end.record.remarks) spdlog::warn("{}: {}", job.key, remark);
  });
  return end;
}

}  // namespace carillon::eval::studies
