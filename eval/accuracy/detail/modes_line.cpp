#include "eval/accuracy/detail/modes_line.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <string_view>

namespace carillon::eval::accuracy {

namespace {

/// A word as a shell takes it literally.
std::string shell_word(const std::string& word) {
  const bool plain = !word.empty() && std::all_of(word.begin(), word.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 ||
           std::string_view("_-+./:=,").find(static_cast<char>(c)) != std::string_view::npos;
  });
  if (plain) return word;
  std::string out = "'";
  for (const char c : word) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

}  // namespace

std::string modes_line(const StudiedObject& object, const solvers::modes::Band& band,
                       std::int64_t max_elements, double cents) {
  const auto& shape = object.request.shape;
  const auto& file = object.request.file;
  const double usual_tolerance = solvers::mesh::MeshFile().wrap_tolerance;
  if (!shape.profile.empty() || file.wrap_tolerance != usual_tolerance) return "";
  std::string named = file.path;
  if (!shape.family.empty()) {
    named = shape.family;
    for (const auto& [name, value] : shape.parameters) {
      named += fmt::format("{}{}={}m", named == shape.family ? ':' : ',', name, value);
    }
  }
  std::string line = "carillon modes " + shell_word(named);
  if (file.length > 0) line += fmt::format(" --length {}m", file.length);
  if (file.thickness > 0) line += fmt::format(" --thickness {}m", file.thickness);
  if (object.any_size) line += " --any-size";
  return line + fmt::format(
                    " --solver tetrahedra --material {} --min-frequency {}Hz --max-frequency {}Hz "
                    "--max-modes {} "
                    "--max-elements {} --max-unknowns 1000000000 --pitch-cents {}",
                    shell_word(object.material_text), band.min_frequency, band.max_frequency,
                    band.max_modes, max_elements, cents);
}

}  // namespace carillon::eval::accuracy
