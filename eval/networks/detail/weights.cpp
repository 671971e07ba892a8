#include "eval/networks/detail/weights.hpp"

#include <sstream>

namespace carillon::eval::networks {

namespace {

template <class Source>
std::string bytes_of(const Source& source) {
  torch::serialize::OutputArchive archive;
  source.save(archive);
  std::ostringstream stream;
  archive.save_to(stream);
  return stream.str();
}

template <class Target>
void load_bytes(const std::string& bytes, Target& target, const torch::Device& device) {
  std::istringstream stream(bytes);
  torch::serialize::InputArchive archive;
  archive.load_from(stream, device);
  target.load(archive);
}

bool is_running_statistic(const torch::Tensor& buffer) {
  return buffer.is_floating_point();
}

}  // namespace

std::string to_bytes(const torch::nn::Module& module) {
  return bytes_of(module);
}

std::string to_bytes(const torch::optim::Optimizer& optimizer) {
  return bytes_of(optimizer);
}

void from_bytes(const std::string& bytes, torch::nn::Module& module, const torch::Device& device) {
  load_bytes(bytes, module, device);
}

void from_bytes(const std::string& bytes, torch::optim::Optimizer& optimizer,
                const torch::Device& device) {
  load_bytes(bytes, optimizer, device);
}

std::int64_t parameter_count(const torch::nn::Module& module) {
  std::int64_t count = 0;
  for (const torch::Tensor& parameter : module.parameters()) count += parameter.numel();
  return count;
}

void bind_gradients(torch::nn::Module& module, const torch::Tensor& flat) {
  std::int64_t at = 0;
  for (torch::Tensor& parameter : module.parameters()) {
    parameter.mutable_grad() = flat.slice(0, at, at + parameter.numel()).view_as(parameter);
    at += parameter.numel();
  }
}

std::vector<float> running_statistics(const torch::nn::Module& module) {
  std::vector<float> flat;
  for (const torch::Tensor& buffer : module.buffers()) {
    if (!is_running_statistic(buffer)) continue;
    const torch::Tensor held = buffer.to(torch::kCPU).contiguous();
    flat.insert(flat.end(), held.data_ptr<float>(), held.data_ptr<float>() + held.numel());
  }
  return flat;
}

void set_running_statistics(std::span<const float> flat, torch::nn::Module& module) {
  std::size_t at = 0;
  for (torch::Tensor& buffer : module.buffers()) {
    if (!is_running_statistic(buffer)) continue;
    const auto count = static_cast<std::size_t>(buffer.numel());
    const auto values = flat.subspan(at, count);
    buffer.copy_(torch::tensor(std::vector<float>(values.begin(), values.end())).view_as(buffer));
    at += count;
  }
}

}  // namespace carillon::eval::networks
