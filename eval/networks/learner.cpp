#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#ifdef __GLIBC__
#include <malloc.h>
#endif

#include "core/error.hpp"
#include "core/random.hpp"
#include "eval/learning/sealed_file.hpp"
#include "eval/networks/detail/equaliser.hpp"
#include "eval/networks/detail/layer_table.hpp"
#include "eval/networks/detail/learner_state.hpp"
#include "eval/networks/detail/portable_weights.hpp"
#include "eval/networks/detail/weights.hpp"

namespace carillon::eval::networks {

std::vector<torch::Tensor> tensors_of(learning::Batch& batch,
                                      const std::vector<learning::ModalityLayout>& layouts) {
  std::vector<torch::Tensor> modalities;
  for (std::size_t s = 0; s < layouts.size(); ++s) {
    std::vector<std::int64_t> extent = {static_cast<std::int64_t>(batch.rows.size())};
    extent.insert(extent.end(), layouts[s].extent.begin(), layouts[s].extent.end());
    modalities.push_back(torch::from_blob(batch.modalities[s].data(), extent));
  }
  return modalities;
}

std::vector<torch::Tensor> moved_to(const torch::Device& device,
                                    std::vector<torch::Tensor> modalities) {
  for (torch::Tensor& modality : modalities) modality = modality.to(device);
  return modalities;
}

namespace {

/// @throws InputError  a graphics card is asked for, and there is none
torch::Device torch_device(learning::Device device) {
  const bool has_cuda = device != learning::Device::cpu && torch::cuda::is_available();
  if (device == learning::Device::cuda && !has_cuda) {
    throw core::InputError(
        torch::hasCUDA() ? "no graphics card that CUDA can use was found"
                         : "this program's libtorch is one without CUDA, as Debian's is",
        torch::hasCUDA() ? "--device cpu, or look what nvidia-smi says"
                         : "--device cpu, or build with one that has it: -DTorch_DIR=...");
  }
  return has_cuda ? torch::kCUDA : torch::kCPU;
}

}  // namespace

Tally Learner::State::look_at(learning::Batch& batch,
                              const std::vector<learning::ModalityLayout>& layouts, bool learn) {
  namespace functional = torch::nn::functional;
  const torch::Tensor labels = torch::from_blob(
      batch.labels.data(), {static_cast<std::int64_t>(batch.labels.size())}, torch::kInt64);
  std::vector<torch::Tensor> modalities = tensors_of(batch, layouts);
  if (learn && method.learning.equaliser > 0) {
    for (std::size_t s = 0; s < modalities.size(); ++s) {
      if (method.modalities[s] == learning::Modality::spectrogram)
        modalities[s] = equalised(modalities[s], method.spectrogram, method.learning.equaliser);
    }
  }
  const bool unsure = learn && outliers;
  if (unsure) {
    // In one pass: what a layer normalises is the same mixture that its running statistics are of.
    const std::vector<torch::Tensor> drawn = outliers->draw(modalities, labels);
    for (std::size_t s = 0; s < modalities.size(); ++s)
      modalities[s] = torch::cat({modalities[s], drawn[s]});
  }
  const torch::Tensor all = classifier->forward(moved_to(device, std::move(modalities)));
  const torch::Tensor wanted = labels.to(device);
  const std::int64_t samples = labels.size(0);
  const torch::Tensor logits = all.slice(0, 0, samples);
  // The samples' sum: ranks add theirs up.
  const torch::Tensor lost = functional::cross_entropy(
      logits, wanted, functional::CrossEntropyFuncOptions().reduction(torch::kSum));
  if (unsure) {
    const double weight = method.learning.outliers * static_cast<double>(samples);
    (lost + weight * Outliers::loss(all.slice(0, samples))).backward();
  } else if (learn) {
    lost.backward();
  }
  return {.loss = lost.item<float>(),
          .right = logits.argmax(1).eq(wanted).sum().item<float>(),
          .samples = static_cast<float>(batch.rows.size())};
}

Learner::Learner(const learning::Method& method,
                 const std::vector<learning::ModalityExtent>& extents,
                 const std::vector<std::string>& classes)
    : state_(std::make_unique<State>()) {
  torch::manual_seed(core::stable_hash(fmt::format("weights {}", method.learning.seed)));
  state_->method = method;
  state_->extents = extents;
  state_->classes = classes;
  state_->device = torch_device(method.learning.device);
  state_->classifier = make_classifier(method, extents, static_cast<std::int64_t>(classes.size()));
  state_->classifier->to(state_->device);
  state_->classifier->eval();
}

namespace {

/// Logits in memory, rows x classes.
torch::Tensor answers_to(const Learner::State& state, std::vector<torch::Tensor> modalities) {
  return state.classifier->forward(moved_to(state.device, std::move(modalities)))
      .to(torch::kCPU)
      .contiguous();
}

}  // namespace

Learner::~Learner() = default;
Learner::Learner(Learner&&) noexcept = default;

std::vector<float> Learner::predict(learning::SampleSource& source,
                                    const learning::LabelledSamples& samples,
                                    const std::vector<std::uint32_t>& rows,
                                    const LearningRanks& ranks) {
  const std::size_t classes = state_->classes.size();
  std::vector<float> values(rows.size() * classes, 0.0F);
  std::exception_ptr error;
  try {
    const torch::NoGradGuard no_gradient;
    const learning::Method& method = state_->method;
    learning::BatchReader reader(source, samples, method,
                                 learning::rows_of_rank(rows, ranks.rank, ranks.size),
                                 method.learning.memory);
    reader.begin({});
    for (learning::Batch batch; reader.next(answer_batch, batch);) {
      const torch::Tensor logits = answers_to(*state_, tensors_of(batch, reader.layouts()));
      for (std::size_t i = 0; i < batch.rows.size(); ++i) {
        const auto at = static_cast<std::size_t>(
            std::lower_bound(rows.begin(), rows.end(), batch.rows[i]) - rows.begin());
        std::copy_n(logits.data_ptr<float>() + i * classes, classes,
                    values.begin() + static_cast<std::ptrdiff_t>(at * classes));
      }
    }
  } catch (...) {
    error = std::current_exception();
  }
  ranks.agree(error);
  ranks.sum(values);
  return values;
}

std::vector<float> Learner::logits_of(const std::vector<std::vector<float>>& modalities) const {
  const torch::NoGradGuard no_gradient;
  std::vector<torch::Tensor> tensors;
  for (std::size_t s = 0; s < modalities.size(); ++s) {
    std::vector<std::int64_t> extent = {1};
    extent.insert(extent.end(), state_->extents[s].begin(), state_->extents[s].end());
    tensors.push_back(torch::tensor(modalities[s]).view(extent));
  }
  const torch::Tensor logits = answers_to(*state_, tensors);
  return {logits.data_ptr<float>(), logits.data_ptr<float>() + logits.numel()};
}

std::vector<float> Learner::exciting_input(std::size_t class_number, std::span<const float> start,
                                           double mean_square) const {
  constexpr int steps = 150;
  constexpr double step_length = 0.05;
  if (state_->extents.size() != 1) {
    throw core::InputError(
        fmt::format("{} perceives several modalities: none of them alone excites a class",
                    state_->method.name));
  }
  if (!(mean_square > 0 && mean_square <= 1)) {
    throw core::InputError(
        fmt::format("a mean square of {} is none of values from 0 to 1", mean_square));
  }
  std::vector<std::int64_t> extent = {1};
  extent.insert(extent.end(), state_->extents[0].begin(), state_->extents[0].end());
  if (start.size() != learning::values_in(state_->extents[0])) {
    throw core::InputError(fmt::format("a start of {} values for an input of {}", start.size(),
                                       learning::values_in(state_->extents[0])));
  }
  torch::Tensor input =
      torch::tensor(std::vector<float>(start.begin(), start.end())).view(extent).to(state_->device);
  const double length = std::sqrt(mean_square * static_cast<double>(start.size()));
  const double own = input.norm().item<double>();
  if (!(own > 0)) throw core::InputError("a start of zeros has no direction to be scaled in");
  input = input * (length / own);
  for (int step = 0; step < steps; ++step) {
    input = input.detach().requires_grad_();
    state_->classifier->forward({input})[0][static_cast<std::int64_t>(class_number)].backward();
    const torch::NoGradGuard no_gradient;
    const double slope = input.grad().norm().item<double>();
    if (!(slope > 0)) break;
    // Clamping shortens what rescaling lengthens: the last of the two keeps the range.
    input = (input + input.grad() * (step_length * length / slope)).clamp(0, 1);
    input = (input * (length / input.norm().item<double>())).clamp(0, 1);
  }
  const torch::Tensor found = input.detach().to(torch::kCPU).contiguous();
  return {found.data_ptr<float>(), found.data_ptr<float>() + found.numel()};
}

Learner::Activations Learner::first_activations(const std::vector<float>& spectrogram) const {
  const learning::Method& method = state_->method;
  if (method.modalities != std::vector{learning::Modality::spectrogram} ||
      method.branches != std::vector{learning::Branch::isnn}) {
    throw core::InputError(
        fmt::format("{} does not begin with a convolution of spectrograms alone", method.name));
  }
  const learning::ModalityExtent& extent = state_->extents.front();
  if (spectrogram.size() != learning::values_in(extent)) {
    throw core::InputError(fmt::format("{} values for an input of {}", spectrogram.size(),
                                       learning::values_in(extent)));
  }
  const torch::NoGradGuard no_gradient;
  torch::Tensor activations =
      torch::tensor(spectrogram).view({1, extent[0], extent[1], extent[2]}).to(state_->device);
  for (const auto& layer : state_->classifier->modules(false)) {
    if (auto* convolution = layer->as<torch::nn::Conv2d>()) {
      activations = torch::relu(convolution->forward(activations)).to(torch::kCPU).contiguous();
      break;
    }
  }
  const auto size = [&](std::int64_t axis) {
    return static_cast<std::size_t>(activations.size(axis));
  };
  return {size(1),
          size(2),
          size(3),
          {activations.data_ptr<float>(), activations.data_ptr<float>() + activations.numel()}};
}

void Learner::save(const std::filesystem::path& path) const {
  learning::write_sealed(path, {{{"method", learning::to_json(state_->method)},
                                 {"extents", state_->extents},
                                 {"classes", state_->classes}},
                                {to_bytes(*state_->classifier)}});
}

void Learner::save_for_others(const std::filesystem::path& folder) const {
  const nlohmann::ordered_json table =
      layer_table(*state_->classifier, state_->method, state_->extents, state_->classes);
  const auto weights = weights_of(*state_->classifier);
  write_safetensors(folder / "model.safetensors", table, weights);
  write_torch_script(folder / "model.pt", table, weights);
}

Learner Learner::load(const std::filesystem::path& path, learning::Device device) {
  const learning::SealedFile file = learning::read_sealed(path);
  learning::Method method = learning::method_from(file.header.at("method"));
  method.learning.device = device;
  Learner learner(method, file.header.at("extents").get<std::vector<learning::ModalityExtent>>(),
                  file.header.at("classes").get<std::vector<std::string>>());
  from_bytes(file.blocks.at(0), *learner.state_->classifier, learner.state_->device);
  return learner;
}

std::string Learner::device() const {
  return state_->device.str();
}

const learning::Method& Learner::method() const {
  return state_->method;
}

const std::vector<std::string>& Learner::classes() const {
  return state_->classes;
}

void set_up_learning(int threads) {
#ifdef __GLIBC__
  mallopt(M_MMAP_MAX, 0);
  mallopt(M_TRIM_THRESHOLD, -1);
#endif
  torch::set_num_threads(threads);
}

}  // namespace carillon::eval::networks
