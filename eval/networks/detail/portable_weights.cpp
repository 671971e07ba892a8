#include "eval/networks/detail/portable_weights.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <torch/script.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <sstream>

#include "core/error.hpp"
#include "core/files.hpp"
#include "core/hash.hpp"

namespace carillon::eval::networks {

using nlohmann::ordered_json;

void write_safetensors(const std::filesystem::path& path, const ordered_json& table,
                       const std::map<std::string, torch::Tensor>& weights) {
  static_assert(std::endian::native == std::endian::little);
  ordered_json header;
  header["__metadata__"];
  std::string values;
  for (const auto& [name, weight] : weights) {
    const std::size_t first = values.size();
    values.append(reinterpret_cast<const char*>(weight.data_ptr<float>()), weight.nbytes());
    header[name] = {{"dtype", "F32"},
                    {"shape", weight.sizes().vec()},
                    {"data_offsets", {first, values.size()}}};
  }
  header["__metadata__"] = {{"carillon", table.dump()}, {"sha256", core::sha256(values)}};
  std::string text = header.dump();
  text.append((8 - text.size() % 8) % 8, ' ');  // values begin at a multiple of eight
  const auto length = static_cast<std::uint64_t>(text.size());
  std::string all(sizeof length, '\0');
  std::memcpy(all.data(), &length, sizeof length);
  core::write_text_durably(path, all.append(text).append(values));
}

namespace {

/// A name that TorchScript takes.
std::string attribute(std::string name) {
  std::replace(name.begin(), name.end(), '.', '_');
  return name;
}

/// `self.NAME` of a weight that a row names, or None.
std::string weight_of(const ordered_json& row, const char* key) {
  return row.at(key).is_null() ? "None" : "self." + attribute(row.at(key));
}

std::string dense(const ordered_json& row, const std::string& input) {
  return fmt::format("torch.linear({}, {}, {})", input, weight_of(row, "weight"),
                     weight_of(row, "bias"));
}

/// The expression of one layer of `x`.
std::string expression(const ordered_json& row) {
  const std::string kind = row.at("kind");
  if (kind == "dense") return dense(row, "x");
  if (kind == "convolution") {
    return fmt::format("torch.conv{}d(x, {}, {}, {}, {})", row.at("stride").size(),
                       weight_of(row, "weight"), weight_of(row, "bias"), row.at("stride").dump(),
                       row.at("padding").dump());
  }
  if (kind == "normalisation") {
    return fmt::format("torch.batch_norm(x, {}, {}, {}, {}, False, 0.1, {}, False)",
                       weight_of(row, "weight"), weight_of(row, "bias"), weight_of(row, "mean"),
                       weight_of(row, "variance"), row.at("epsilon").get<double>());
  }
  if (kind == "rectifier") {
    const double slope = row.at("slope");
    return slope > 0 ? fmt::format("torch.leaky_relu(x, {})", slope) : "torch.relu(x)";
  }
  if (kind == "maximum") {
    return fmt::format("torch.max_pool{}d(x, {})", row.at("window").size(),
                       row.at("window").dump());
  }
  if (kind == "adaptive_maximum") {
    return fmt::format("torch.adaptive_max_pool1d(x, [{}])[0]",
                       row.at("outputs").get<std::int64_t>());
  }
  if (kind == "mean") return "torch.mean(x, [2])";
  if (kind == "copies") {
    return fmt::format("x.reshape([-1, {}])",
                       fmt::join(row.at("shape").get<std::vector<std::int64_t>>(), ", "));
  }
  if (kind == "over_copies") {
    const std::string copies =
        fmt::format("torch.unflatten(x, 0, [-1, {}])", row.at("count").get<std::int64_t>());
    return row.at("by") == "mean" ? fmt::format("torch.mean({}, [1])", copies)
                                  : fmt::format("torch.amax({}, [1])", copies);
  }
  if (kind == "flatten") return "torch.flatten(x, 1)";
  throw core::Error(fmt::format("no TorchScript of a layer \"{}\"", kind));
}

/// Lines that join the branches' features y0, y1 and so on into x.
std::string joined_text(const ordered_json& fusion, std::size_t branches) {
  const std::string kind = fusion.at("kind");
  std::vector<std::string> features;
  for (std::size_t i = 0; i < branches; ++i) features.push_back(fmt::format("y{}", i));
  if (kind == "concatenate") {
    return fmt::format("    x = torch.cat([{}], 1)\n", fmt::join(features, ", "));
  }
  if (kind == "add") return fmt::format("    x = {}\n", fmt::join(features, " + "));
  const bool pools = kind == "bilinear";
  for (std::size_t i = 0; i < branches; ++i) {
    const std::string projected = dense(fusion.at("projections").at(i), features[i]);
    features[i] = pools ? projected : fmt::format("torch.tanh({})", projected);
  }
  std::string text = fmt::format("    x = {}\n", fmt::join(features, " * "));
  if (!pools) return text;
  const auto factors = fusion.at("factors").get<std::int64_t>();
  return text +
         fmt::format("    x = torch.sum(torch.reshape(x, [x.size(0), -1, {}]), [2])\n", factors) +
         "    x = torch.sign(x) * torch.sqrt(torch.abs(x) + 1e-12)\n"
         "    x = x / torch.clamp_min(torch.norm(x, 2, [1], True), 1e-12)\n";
}

}  // namespace

std::string torch_script(const ordered_json& table) {
  std::string text = "def forward(self";
  const std::size_t branches = table.at("branches").size();
  for (std::size_t i = 0; i < branches; ++i) text += fmt::format(", input{}", i);
  text += "):\n";
  for (std::size_t i = 0; i < branches; ++i) {
    text += fmt::format("    x = input{}\n", i);
    for (const ordered_json& row : table.at("branches").at(i)) {
      text += fmt::format("    x = {}\n", expression(row));
    }
    text += fmt::format("    y{} = x\n", i);
  }
  text += joined_text(table.at("fusion"), branches);
  return text + fmt::format("    return {}\n", dense(table.at("classify"), "x"));
}

void write_torch_script(const std::filesystem::path& path, const ordered_json& table,
                        const std::map<std::string, torch::Tensor>& weights) {
  torch::jit::Module module("carillon");
  module.register_attribute("training", c10::BoolType::get(), false);
  for (const auto& [name, weight] : weights) {
    module.register_buffer(attribute(name), weight.clone());
  }
  module.define(torch_script(table));
  std::ostringstream bytes;
  module.save(bytes);
  core::write_text_durably(path, bytes.str());
}

}  // namespace carillon::eval::networks
