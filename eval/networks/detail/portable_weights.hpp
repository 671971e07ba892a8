#pragma once

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>

#include "eval/networks/detail/networks.hpp"

namespace carillon::eval::networks {

/// Weights as safetensors: eight bytes with the length of a JSON header, the header with type,
/// shape and place of each, their values, all little-endian. `__metadata__` has the table as
/// `carillon` and the SHA-256 of all values as `sha256`.
/// https://github.com/huggingface/safetensors, "Format"
/// @throws FileError  not writable
void write_safetensors(const std::filesystem::path& path, const nlohmann::ordered_json& table,
                       const std::map<std::string, torch::Tensor>& weights);

/// The TorchScript program of a table: from one tensor for each input to logits.
std::string torch_script(const nlohmann::ordered_json& table);

/// That program with its weights, for torch.jit.load.
/// @throws FileError  not writable
void write_torch_script(const std::filesystem::path& path, const nlohmann::ordered_json& table,
                        const std::map<std::string, torch::Tensor>& weights);

}  // namespace carillon::eval::networks
