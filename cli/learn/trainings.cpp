#include "cli/learn/trainings.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <cmath>
#include <optional>

#include "cli/json_number.hpp"
#include "cli/learn/answers.hpp"
#include "cli/learn/mpi_learning.hpp"
#include "core/error.hpp"
#include "core/files.hpp"
#include "core/hash.hpp"
#include "core/progress.hpp"
#include "core/trace.hpp"
#include "eval/learning/nearest_neighbour.hpp"
#include "eval/learning/recognition.hpp"
#include "mpi/comm.hpp"
#include "mpi/interrupt.hpp"

namespace carillon::cli {

using nlohmann::json;
using nlohmann::ordered_json;

namespace {

/// Raised whenever the same inputs would give other numbers.
constexpr int learning_version = 3;

json to_json(const eval::TaskSpec& task) {
  return {{"name", task.name},
          {"column", task.column},
          {"split", task.split},
          {"classes", task.classes},
          {"except", task.except}};
}

std::string curves_csv(const eval::Trained& trained) {
  std::string text =
      "epoch,train_loss,train_accuracy,validation_loss,validation_accuracy,learning_rate,"
      "seconds,waited_s,ranks\n";
  for (const eval::Epoch& epoch : trained.epochs) {
    text += fmt::format("{},{:.6g},{:.6g},{:.6g},{:.6g},{:.6g},{:.3f},{:.3f},{}\n", epoch.number,
                        epoch.train_loss, epoch.train_accuracy, epoch.validation_loss,
                        epoch.validation_accuracy, epoch.learning_rate, epoch.seconds,
                        epoch.waited_s, epoch.ranks);
  }
  return text;
}

ordered_json to_json(const eval::RecognitionTrial& trial, double temperature) {
  ordered_json found = {{"temperature", number_or_null(temperature)},
                        {"calibration_error", number_or_null(trial.calibration_error)},
                        {"uncalibrated_error", number_or_null(trial.uncalibrated_error)},
                        {"accepted", number_or_null(trial.accepted)},
                        {"novel", ordered_json::object()}};
  for (const auto& [name, novel] : trial.novel) {
    found["novel"][name] = {
        {"sounds", novel.sounds},
        {"auroc", number_or_null(novel.auroc)},
        {"auroc95", {number_or_null(novel.auroc95.low), number_or_null(novel.auroc95.high)}},
        {"accepted", number_or_null(novel.accepted)}};
  }
  return found;
}

/// Line of progress of one job.
class Watched {
 public:
  Watched(const TrainingJob& job, const Context& context)
      : progress_(job.key, static_cast<double>(job.method.learning.epochs),
                  context.quiet || !context.speaks()) {
    watch.step = [this](double done, double of, const eval::Epoch& epoch) {
      progress_.update(
          static_cast<double>(epoch.number - 1) + done / of,
          fmt::format("epoch {}, loss {:.3f}{}", epoch.number, epoch.train_loss, last_));
    };
    watch.epoch = [this](const eval::Epoch& epoch) {
      last_ = std::isnan(epoch.validation_accuracy)
                  ? ""
                  : fmt::format(", validation {:.1f} %", 100 * epoch.validation_accuracy);
    };
    watch.stop = [] { return mpi::interrupt_requested(); };
  }
  void finish(const std::string& note) { progress_.finish(note); }
  eval::LearningWatch watch;

 private:
  core::Progress progress_;
  std::string last_;
};

ordered_json describe(const TrainingJob& job, const eval::SampleSource& source,
                      const eval::LabelledSamples& samples) {
  ordered_json found = {{"key", job.key},
                        {"inputs", job.inputs},
                        {"source", source.name()},
                        {"source_content", source.content()},
                        {"source_folder", std::filesystem::absolute(source.name()).string()},
                        {"task", to_json(job.task)},
                        {"method", eval::to_json(job.method)},
                        {"classes", samples.classes}};
  found["samples"] = {{"train", samples.rows(eval::Part::train).size()},
                      {"validation", samples.rows(eval::Part::validation).size()},
                      {"test", samples.rows(eval::Part::test).size()}};
  return found;
}

void add_training(ordered_json& found, const eval::Trained& trained) {
  double seconds = 0, waited = 0;
  for (const eval::Epoch& epoch : trained.epochs) {
    seconds += epoch.seconds;
    waited += epoch.waited_s;
  }
  found["parameters"] = trained.parameters;
  found["epochs"] = trained.epochs.size();
  found["best_epoch"] = trained.best;
  const double loss =
      trained.best > 0 ? trained.epochs[static_cast<std::size_t>(trained.best - 1)].validation_loss
                       : NAN;
  found["validation_loss"] = number_or_null(loss);
  found["silent_samples"] = trained.silent;
  found["timing"] = {{"training_s", seconds}, {"waited_s", waited}};
}

}  // namespace

ordered_json read_record(const std::filesystem::path& folder) {
  const std::filesystem::path path = folder / "training.json";
  try {
    return ordered_json::parse(core::read_file(path));
  } catch (const json::exception& error) {
    throw core::InputError(fmt::format("{}: {}", path.string(), error.what()),
                           "delete its folder, and it is trained again");
  }
}

TrainingJob make_job(const eval::SampleSource& source, const eval::TaskSpec& task,
                     const eval::Method& method, const std::filesystem::path& models) {
  TrainingJob job;
  job.task = task;
  job.method = method;
  job.key = fmt::format("{}/{}/seed-{}", task.name, method.name, method.learning.seed);
  ordered_json decides = {{"version", learning_version},
                          {"source", source.content()},
                          {"task", to_json(task)},
                          {"method", eval::to_json(method)}};
  job.inputs = core::sha256(decides.dump());
  job.folder = models / task.name / method.name /
               fmt::format("seed-{}-{}", method.learning.seed, job.inputs.substr(0, 8));
  return job;
}

JobEnd run_job(const TrainingJob& job, eval::SampleSource& source, const Context& context) {
  const std::filesystem::path record = job.folder / "training.json";
  JobEnd end;
  mpi::agreed(context.world, [&] {
    if (context.speaks() && std::filesystem::exists(record)) end.found = read_record(job.folder);
  });
  end.found = ordered_json::parse(mpi::broadcast(end.found.dump(), 0, context.world));
  if (!end.found.is_null()) {
    end.was_there = true;
    return end;
  }
  const eval::LearningRanks ranks = learning_ranks(context.world);
  eval::LabelledSamples samples;
  mpi::agreed(context.world, [&] {
    samples = eval::label_samples(source, job.task);
    eval::require_learnable(samples, source, job.task);
  });
  end.found = describe(job, source, samples);
  std::vector<std::string> remarks = eval::remarks(samples);
  const std::vector<std::uint32_t> validation = samples.rows(eval::Part::validation);
  const std::vector<std::uint32_t> test = samples.rows(eval::Part::test);
  Answers answers{samples.classes, asked(samples, validation), asked(samples, test)};
  const double start = core::monotonic_seconds();
  std::unique_ptr<eval::Learner> learner;
  const bool neighbours = job.method.kind == eval::MethodKind::nearest_neighbour;
  eval::Trained trained;
  Watched watched(job, context);
  if (!neighbours) {
    std::vector<eval::SenseExtent> extents;
    mpi::agreed(context.world, [&] {
      for (const eval::Sense sense : job.method.senses) {
        extents.push_back(eval::require_layout(source, sense).extent);
      }
      learner = std::make_unique<eval::Learner>(job.method, extents, samples.classes);
    });
    trained = learner->train(source, samples, ranks, {job.folder / "checkpoint", job.inputs},
                             watched.watch);
    remarks.insert(remarks.end(), trained.remarks.begin(), trained.remarks.end());
    if (trained.interrupted) {
      watched.finish(
          fmt::format("stopped after {} epochs; the same command goes on", trained.epochs.size()));
      end.interrupted = true;
      return end;
    }
    add_training(end.found, trained);
  }
  const auto ask = [&](const std::vector<std::uint32_t>& rows) {
    return neighbours ? eval::ask_neighbours(job.method, source, samples, rows, ranks)
                      : learner->predict(source, samples, rows, ranks);
  };
  answers.validation.scores = ask(validation);
  answers.test.scores = ask(test);
  std::optional<eval::Recognition> recognition;
  if (job.is_for_use && learner && eval::only_hears(job.method) && source.clip_format()) {
    recognition =
        eval::learn_recognition(*learner, source, samples, answers.validation.scores, ranks);
    end.found["recognition"] =
        to_json(eval::try_recognition(*recognition, *learner, source, samples, answers.test.scores,
                                      groups_of(answers.test, job.task.split), ranks),
                recognition->temperature);
  }
  const std::size_t classes = samples.classes.size();
  const eval::Confusion tested = confusion_of(answers.test, classes);
  end.found["validation_accuracy"] =
      number_or_null(eval::accuracy(confusion_of(answers.validation, classes)));
  end.found["test_accuracy"] = number_or_null(eval::accuracy(tested));
  end.found["test_balanced_accuracy"] = number_or_null(eval::balanced_accuracy(tested));
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
    std::filesystem::create_directories(job.folder);
    if (learner) {
      learner->save(job.folder / "model", end.found);
      core::write_text_durably(job.folder / "curves.csv", curves_csv(trained));
    }
    if (recognition) eval::save_recognition(job.folder / "recognition", *recognition);
    write_answers(job.folder / "answers.h5", answers);
    core::write_text_durably(record, end.found.dump(1) + "\n");
    std::filesystem::remove(job.folder / "checkpoint");
    for (const std::string& remark : remarks) spdlog::warn("{}: {}", job.key, remark);
  });
  return end;
}

}  // namespace carillon::cli
