#include "eval/learning/sealed_file.hpp"

#include <fmt/format.h>

#include "core/error.hpp"
#include "core/files.hpp"
#include "core/hash.hpp"

namespace carillon::eval::learning {

namespace {

std::string seal(const nlohmann::json& header, const nlohmann::json& sizes,
                 std::string_view payload) {
  std::string all = header.dump() + sizes.dump();
  return core::sha256(all.append(payload));
}

}  // namespace

void write_sealed(const std::filesystem::path& path, const SealedFile& file) {
  std::string payload;
  std::vector<std::size_t> sizes;
  for (const std::string& block : file.blocks) {
    payload += block;
    sizes.push_back(block.size());
  }
  const nlohmann::json line = {
      {"header", file.header}, {"blocks", sizes}, {"sha256", seal(file.header, sizes, payload)}};
  core::write_text_durably(path, line.dump() + "\n" + payload);
}

SealedFile read_sealed(const std::filesystem::path& path) {
  const std::string text = core::read_file(path);
  const std::size_t end = text.find('\n');
  const auto damaged = [&](const std::string& how) {
    return core::InputError(fmt::format("{}: {}", path.string(), how),
                            "take it from where it was made, or train again");
  };
  if (end == std::string::npos) throw damaged("cut short, or no file of this program");
  const nlohmann::json line = nlohmann::json::parse(
      text.begin(), text.begin() + static_cast<std::ptrdiff_t>(end), nullptr, false);
  if (!line.is_object() || !line.contains("sha256") || !line.contains("blocks") ||
      !line.contains("header")) {
    throw damaged("no file of this program");
  }
  const std::string payload = text.substr(end + 1);
  if (seal(line.at("header"), line.at("blocks"), payload) != line.at("sha256")) {
    throw damaged(fmt::format("cut short or changed ({} bytes after its header)", payload.size()));
  }
  SealedFile file;
  file.header = line.at("header");
  std::size_t at = 0;
  for (const std::size_t size : line.at("blocks").get<std::vector<std::size_t>>()) {
    file.blocks.push_back(payload.substr(at, size));
    at += size;
  }
  return file;
}

}  // namespace carillon::eval::learning
