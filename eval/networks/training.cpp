#include "eval/networks/training.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "core/error.hpp"
#include "core/random.hpp"
#include "core/trace.hpp"
#include "eval/learning/sealed_file.hpp"
#include "eval/networks/detail/learner_state.hpp"
#include "eval/networks/detail/linear_training.hpp"
#include "eval/networks/detail/weights.hpp"

namespace carillon::eval::networks {

namespace {

bool normalises_over_batch(learning::Branch branch) {
  return branch == learning::Branch::soundnet5 || branch == learning::Branch::soundnet8;
}

constexpr double missing = std::numeric_limits<double>::quiet_NaN();

/// One training on its way.
class Training {
 public:
  Training(Learner::State& learner, learning::SampleSource& source,
           const learning::LabelledSamples& samples, const LearningRanks& ranks,
           const Checkpoint& checkpoint, const LearningWatch& watch);
  Trained run();

 private:
  using Optimizer = std::unique_ptr<torch::optim::Optimizer>;
  void remark_on_batch();
  void resume();
  void keep() const;
  std::optional<learning::Epoch> one_epoch();
  Tally step(std::size_t share);
  Tally validate();
  Tally sum(Tally tally, bool gradients, const std::exception_ptr& error);
  torch::Tensor gradients() const { return flat_.slice(0, 0, trained_.parameters); }
  void set_rate(double rate);
  /// The share of the memory that falls to so many of the samples for training and validation.
  double memory_of(std::size_t rows) const {
    return method_.learning.memory * static_cast<double>(rows) /
           static_cast<double>(std::max<std::size_t>(1, train_rows_ + validation_rows_));
  }

  Learner::State& learner_;
  const LearningRanks& ranks_;
  const Checkpoint& checkpoint_;
  const LearningWatch& watch_;
  const learning::Method& method_;
  std::size_t train_rows_, validation_rows_;  ///< of all ranks
  learning::BatchReader reader_, validation_;
  Optimizer optimizer_;
  torch::Tensor flat_;  ///< gradients, and the tally behind them
  std::string best_;
  Trained trained_;
};

Training::Training(Learner::State& learner, learning::SampleSource& source,
                   const learning::LabelledSamples& samples, const LearningRanks& ranks,
                   const Checkpoint& checkpoint, const LearningWatch& watch)
    : learner_(learner),
      ranks_(ranks),
      checkpoint_(checkpoint),
      watch_(watch),
      method_(learner.method),
      train_rows_(samples.rows(learning::Part::train).size()),
      validation_rows_(samples.rows(learning::Part::validation).size()),
      reader_(source, samples, method_,
              learning::rows_of_rank(samples.rows(learning::Part::train), ranks.rank, ranks.size),
              memory_of(train_rows_)),
      validation_(
          source, samples, method_,
          learning::rows_of_rank(samples.rows(learning::Part::validation), ranks.rank, ranks.size),
          memory_of(validation_rows_)) {
  const learning::LearningOptions& options = method_.learning;
  optimizer_ = std::make_unique<torch::optim::Adam>(
      learner_.classifier->parameters(),
      torch::optim::AdamOptions(options.learning_rate).weight_decay(options.weight_decay));
  remark_on_batch();
  trained_.parameters = parameter_count(*learner_.classifier);
  flat_ = torch::zeros({trained_.parameters + static_cast<std::int64_t>(Tally::numbers)},
                       learner_.device);
}

void require_finite(double loss) {
  if (std::isfinite(loss)) return;
  throw core::InputError("training: the loss is no number any more",
                         "a lower learning_rate; carillon check tells whether the data are whole");
}

void Training::remark_on_batch() {
  const std::int64_t batch = method_.learning.batch;
  if (batch < ranks_.size) {
    trained_.remarks.push_back(fmt::format("a batch of {} on {} ranks becomes one of {}", batch,
                                           ranks_.size, ranks_.size));
  }
  const std::int64_t of_rank = std::max<std::int64_t>(1, batch / ranks_.size);
  const auto& branches = method_.branches;
  const bool normalises = std::any_of(branches.begin(), branches.end(), normalises_over_batch);
  if (normalises && of_rank < 8) {
    trained_.remarks.push_back(
        fmt::format("SoundNet normalises over the {} samples of a step that a rank has: a larger "
                    "batch is steadier",
                    of_rank));
  }
}

/// Goes on from the checkpoint where there is one that can be used.
void Training::resume() {
  std::string found;
  if (ranks_.rank == 0 && !checkpoint_.file.empty()) {
    try {
      if (std::filesystem::exists(checkpoint_.file)) {
        const learning::SealedFile file = learning::read_sealed(checkpoint_.file);
        if (file.header.value("inputs", "") == checkpoint_.inputs) found = "there";
      }
    } catch (const std::exception& error) {
      trained_.remarks.push_back(fmt::format("{}; training begins anew", error.what()));
    }
  }
  if (ranks_.share(found).empty()) return;
  // Weights are no text: every rank reads the file.
  std::exception_ptr error;
  try {
    const learning::SealedFile file = learning::read_sealed(checkpoint_.file);
    from_bytes(file.blocks.at(0), *learner_.classifier, learner_.device);
    from_bytes(file.blocks.at(1), *optimizer_, learner_.device);
    best_ = file.blocks.at(2);
    for (const nlohmann::json& epoch : file.header.at("epochs")) {
      trained_.epochs.push_back(learning::epoch_from(epoch));
    }
    trained_.silent = file.header.at("silent");
  } catch (...) {
    error = std::current_exception();
  }
  ranks_.agree(error);
  trained_.resumed = static_cast<std::int64_t>(trained_.epochs.size());
  if (!trained_.epochs.empty() && trained_.epochs.back().ranks != ranks_.size) {
    trained_.remarks.push_back(
        fmt::format("goes on with {} ranks after {} epochs with {}: the same samples in another "
                    "order, so the numbers are not those of either alone",
                    ranks_.size, trained_.epochs.size(), trained_.epochs.back().ranks));
  }
}

void Training::keep() const {
  if (ranks_.rank != 0 || checkpoint_.file.empty()) return;
  nlohmann::json header = {{"inputs", checkpoint_.inputs}, {"silent", trained_.silent}};
  for (const learning::Epoch& epoch : trained_.epochs)
    header["epochs"].push_back(learning::to_json(epoch));
  learning::write_sealed(checkpoint_.file,
                         {header, {to_bytes(*learner_.classifier), to_bytes(*optimizer_), best_}});
}

/// Adds up over ranks; the gradients too where there are some. All throw where one met an error.
Tally Training::sum(Tally tally, bool gradients, const std::exception_ptr& error) {
  tally.failed = error ? 1 : 0;
  tally.stop = watch_.stop && watch_.stop() ? 1 : 0;
  // Ranks add up in the processor's memory, which gradients are in there already.
  torch::Tensor held = flat_.to(torch::kCPU);
  const std::span<float> whole(held.data_ptr<float>(), static_cast<std::size_t>(held.numel()));
  const std::span<float> all = gradients ? whole : whole.last(Tally::numbers);
  tally.put(all.last(Tally::numbers));
  ranks_.sum(all);
  if (gradients && !flat_.is_cpu()) flat_.copy_(held);
  const Tally total = Tally::of(all.last(Tally::numbers));
  if (total.failed > 0) {
    ranks_.agree(error);
    throw core::Error("another rank failed");  // not reached: agree throws on all
  }
  return total;
}

/// One step of this rank's share; all ranks move by the mean gradient of all their samples.
Tally Training::step(std::size_t share) {
  Tally tally;
  const std::exception_ptr error = [&]() -> std::exception_ptr {
    try {
      gradients().zero_();
      learning::Batch batch;
      if (reader_.next(share, batch)) tally = learner_.look_at(batch, reader_.layouts(), true);
    } catch (...) {
      return std::current_exception();
    }
    return nullptr;
  }();
  const Tally total = sum(tally, true, error);
  require_finite(total.loss);
  if (!(total.samples > 0)) throw core::Error("training: a step without a sample");
  gradients().div_(total.samples);
  optimizer_->step();
  return total;
}

Tally Training::validate() {
  learner_.classifier->eval();
  Tally tally;
  std::exception_ptr error;
  try {
    const torch::NoGradGuard no_gradient;
    validation_.begin({});
    for (learning::Batch batch; validation_.next(answer_batch, batch);) {
      const Tally of_batch = learner_.look_at(batch, validation_.layouts(), false);
      tally.loss += of_batch.loss;
      tally.right += of_batch.right;
      tally.samples += of_batch.samples;
    }
  } catch (...) {
    error = std::current_exception();
  }
  const Tally total = sum(tally, false, error);
  learner_.classifier->train();
  return total;
}

void Training::set_rate(double rate) {
  for (torch::optim::OptimizerParamGroup& group : optimizer_->param_groups()) {
    static_cast<torch::optim::AdamOptions&>(group.options()).lr(rate);
  }
}

/// @return nothing when a rank asked to stop
std::optional<learning::Epoch> Training::one_epoch() {
  const double start = core::monotonic_seconds();
  const learning::LearningOptions& options = method_.learning;
  learning::Epoch epoch{.number = static_cast<std::int64_t>(trained_.epochs.size()) + 1,
                        .validation_loss = missing,
                        .validation_accuracy = missing,
                        .learning_rate = learning::learning_rate_after(trained_.epochs, options),
                        .ranks = ranks_.size};
  set_rate(epoch.learning_rate);
  const auto random = [&](const char* what) {
    return core::stable_hash(
        fmt::format("{} {} {} {}", what, options.seed, epoch.number, ranks_.rank));
  };
  torch::manual_seed(random("dropout"));
  const double waited = reader_.waited_s() + validation_.waited_s();
  ranks_.agree([&]() -> std::exception_ptr {
    try {
      reader_.begin(random("order"));
    } catch (...) {
      return std::current_exception();
    }
    return nullptr;
  }());
  const auto size = static_cast<std::size_t>(ranks_.size),
             rank = static_cast<std::size_t>(ranks_.rank);
  const auto batch = static_cast<std::size_t>(options.batch);
  const std::size_t share = std::max<std::size_t>(1, batch / size + (rank < batch % size ? 1 : 0));
  const auto all = static_cast<double>(train_rows_);
  double loss = 0, right = 0, samples = 0;
  while (samples < all) {
    const Tally of_step = step(share);
    loss += of_step.loss;
    right += of_step.right;
    samples += of_step.samples;
    if (of_step.stop > 0) return std::nullopt;
    epoch.train_loss = loss / samples;
    epoch.train_accuracy = right / samples;
    if (watch_.step) watch_.step(samples, all, epoch);
  }
  if (ranks_.size > 1) {
    // The mean over samples, of which ranks may have unlike numbers, or none.
    const float weight = static_cast<float>(reader_.rows()) / static_cast<float>(train_rows_);
    std::vector<float> statistics = running_statistics(*learner_.classifier);
    for (float& value : statistics) value *= weight;
    ranks_.sum(statistics);
    set_running_statistics(statistics, *learner_.classifier);
  }
  const Tally validated = validate();
  if (validated.stop > 0) return std::nullopt;
  if (validated.samples > 0) {
    require_finite(validated.loss);
    epoch.validation_loss = validated.loss / validated.samples;
    epoch.validation_accuracy = validated.right / validated.samples;
  }
  epoch.waited_s = reader_.waited_s() + validation_.waited_s() - waited;
  epoch.seconds = core::monotonic_seconds() - start;
  return epoch;
}

Trained Training::run() {
  resume();
  bind_gradients(*learner_.classifier, flat_);
  learner_.classifier->train();
  while (!learning::ends_after(trained_.epochs, method_.learning)) {
    const std::optional<learning::Epoch> epoch = one_epoch();
    if (!epoch) {
      trained_.interrupted = true;
      break;
    }
    if (trained_.epochs.empty()) {
      float silent = static_cast<float>(reader_.silent());
      ranks_.sum(std::span(&silent, 1));
      trained_.silent = static_cast<std::size_t>(silent);
    }
    trained_.epochs.push_back(*epoch);
    if (learning::best_of(trained_.epochs) == epoch->number) best_ = to_bytes(*learner_.classifier);
    std::exception_ptr error;
    try {
      keep();
    } catch (...) {
      error = std::current_exception();
    }
    ranks_.agree(error);
    if (watch_.epoch) watch_.epoch(*epoch);
  }
  trained_.best = learning::best_of(trained_.epochs);
  if (method_.learning.schedule == learning::Schedule::plateau &&
      trained_.best == method_.learning.epochs && validation_rows_ > 0) {
    trained_.remarks.push_back(fmt::format(
        "the last of {} epochs was the best: more of them may do better", method_.learning.epochs));
  }
  if (!best_.empty()) from_bytes(best_, *learner_.classifier, learner_.device);
  learner_.classifier->eval();
  return std::move(trained_);
}

}  // namespace

Trained Learner::train(learning::SampleSource& source, const learning::LabelledSamples& samples,
                       const LearningRanks& ranks, const Checkpoint& checkpoint,
                       const LearningWatch& watch) {
  if (method().kind == learning::MethodKind::linear_svm) {
    return train_linear_machines(*state_, source, samples, ranks, watch);
  }
  const auto format = source.clip_format();
  std::exception_ptr error;
  try {
    if (method().learning.outliers > 0 && learning::only_hears(method()) && format) {
      state_->outliers.emplace(method(), *format);
    }
  } catch (...) {
    error = std::current_exception();
  }
  ranks.agree(error);
  Trained trained = Training(*state_, source, samples, ranks, checkpoint, watch).run();
  state_->outliers.reset();
  return trained;
}

}  // namespace carillon::eval::networks
