#include "cli/learn/trainings.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>

#include "cli/learn/mpi_learning.hpp"
#include "core/files.hpp"
#include "core/hash.hpp"
#include "core/hdf5.hpp"
#include "core/progress.hpp"
#include "core/trace.hpp"
#include "eval/learning/nearest_neighbour.hpp"
#include "mpi/comm.hpp"
#include "mpi/interrupt.hpp"

namespace carillon::cli {

using nlohmann::json;
using nlohmann::ordered_json;

namespace {

/// Raised whenever the same inputs would give other numbers.
constexpr int learning_version = 1;

json to_json(const eval::TaskSpec& task) {
  return {{"name", task.name},
          {"column", task.column},
          {"split", task.split},
          {"classes", task.classes}};
}

std::string part_name(eval::Part part) {
  return part == eval::Part::validation ? "validation" : "test";
}

/// What a classifier says of one part, and how often it is right.
struct Answers {
  std::vector<std::uint32_t> rows;
  std::vector<float> scores;  ///< rows x classes
  double accuracy = 0;        ///< NaN of no rows
};

double accuracy_of(const Answers& answers, const eval::LabelledSamples& samples) {
  const std::size_t classes = samples.classes.size();
  std::size_t right = 0;
  for (std::size_t i = 0; i < answers.rows.size(); ++i) {
    const auto first = answers.scores.begin() + static_cast<std::ptrdiff_t>(i * classes);
    const auto best = std::max_element(first, first + static_cast<std::ptrdiff_t>(classes)) - first;
    if (best == samples.label[answers.rows[i]]) ++right;
  }
  return static_cast<double>(right) / static_cast<double>(answers.rows.size());
}

void write_answers(const std::filesystem::path& path, const Answers* parts,
                   const eval::LabelledSamples& samples) {
  core::write_durably(path, [&](const std::filesystem::path& temporary) {
    const core::Hdf5Group file = core::Hdf5Group::create_file(temporary);
    file.write<std::string>("classes", samples.classes, {samples.classes.size()});
    for (const eval::Part part : {eval::Part::validation, eval::Part::test}) {
      const Answers& answers = parts[part == eval::Part::test ? 1 : 0];
      std::vector<std::string> keys;
      std::vector<std::int32_t> labels;
      std::vector<std::uint32_t> bodies;
      for (const std::uint32_t row : answers.rows) {
        keys.push_back(samples.keys[row]);
        labels.push_back(samples.label[row]);
        bodies.push_back(samples.bodies[row]);
      }
      const core::Hdf5Group group = file.create_group(part_name(part));
      const std::uint64_t count = answers.rows.size();
      group.write<std::string>("key", keys, {count});
      group.write<std::int32_t>("label", labels, {count});
      group.write<std::uint32_t>("body", bodies, {count});
      group.write<float>("scores", answers.scores, {count, samples.classes.size()});
    }
    file.flush();
  });
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
                        {"task", to_json(job.task)},
                        {"method", eval::to_json(job.method)},
                        {"classes", samples.classes}};
  for (const eval::Part part : {eval::Part::train, eval::Part::validation, eval::Part::test}) {
    found["samples"][part == eval::Part::train ? "train" : part_name(part)] =
        samples.rows(part).size();
  }
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
  found["silent_samples"] = trained.silent;
  found["timing"] = {{"training_s", seconds}, {"waited_s", waited}};
}

}  // namespace

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
  const std::string there = mpi::broadcast(
      context.speaks() && std::filesystem::exists(record) ? core::read_file(record) : "", 0,
      context.world);
  JobEnd end;
  if (!there.empty()) {
    end.found = ordered_json::parse(there);
    end.was_there = true;
    return end;
  }
  const eval::LearningRanks ranks = learning_ranks(context.world);
  eval::LabelledSamples samples;
  mpi::agreed(context.world, [&] { samples = eval::label_samples(source, job.task); });
  end.found = describe(job, source, samples);
  std::vector<std::string> remarks = eval::remarks(samples);
  Answers answers[2] = {{samples.rows(eval::Part::validation), {}},
                        {samples.rows(eval::Part::test), {}}};
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
  for (Answers& part : answers) {
    part.scores = neighbours ? eval::ask_neighbours(job.method, source, samples, part.rows, ranks)
                             : learner->predict(source, samples, part.rows, ranks);
    part.accuracy = accuracy_of(part, samples);
  }
  const auto number = [](double value) { return std::isfinite(value) ? json(value) : json(); };
  end.found["validation_accuracy"] = number(answers[0].accuracy);
  end.found["test_accuracy"] = number(answers[1].accuracy);
  end.found["timing"]["seconds"] = core::monotonic_seconds() - start;
  end.found["ranks"] = ranks.size;
  end.found["remarks"] = remarks;
  watched.finish(fmt::format("test {:.1f} %", 100 * answers[1].accuracy));
  end.found = ordered_json::parse(mpi::broadcast(end.found.dump(), 0, context.world));
  mpi::agreed(context.world, [&] {
    if (!context.speaks()) return;
    std::filesystem::create_directories(job.folder);
    if (learner) {
      learner->save(job.folder / "model", end.found);
      core::write_text_durably(job.folder / "curves.csv", curves_csv(trained));
    }
    write_answers(job.folder / "answers.h5", answers, samples);
    core::write_text_durably(record, end.found.dump(1) + "\n");
    std::filesystem::remove(job.folder / "checkpoint");
    for (const std::string& remark : remarks) spdlog::warn("{}: {}", job.key, remark);
  });
  return end;
}

}  // namespace carillon::cli
