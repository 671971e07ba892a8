#pragma once

#include <span>
#include <string>
#include <vector>

#include "eval/networks/detail/networks.hpp"

namespace carillon::eval::networks {

/// Bytes of torch's archive.
std::string to_bytes(const torch::nn::Module& module);
std::string to_bytes(const torch::optim::Optimizer& optimizer);
/// @param device  what the module is on
void from_bytes(const std::string& bytes, torch::nn::Module& module,
                const torch::Device& device = torch::kCPU);
void from_bytes(const std::string& bytes, torch::optim::Optimizer& optimizer,
                const torch::Device& device = torch::kCPU);

/// Numbers that are learnt.
std::int64_t parameter_count(const torch::nn::Module& module);

/// Makes all gradients views of one row, to which torch adds and over which ranks sum without a
/// copy.
/// @param flat  at least parameter_count() values
void bind_gradients(torch::nn::Module& module, const torch::Tensor& flat);

/// Running means and variances of batch normalisation.
std::vector<float> running_statistics(const torch::nn::Module& module);
void set_running_statistics(std::span<const float> flat, torch::nn::Module& module);

}  // namespace carillon::eval::networks
