#include <archive.h>
#include <archive_entry.h>
#include <fmt/core.h>

#include <cmath>
#include <memory>
#include <pugixml.hpp>
#include <string_view>

#include "core/error.hpp"
#include "core/files.hpp"
#include "solvers/mesh/imported/detail/formats.hpp"

namespace carillon::solvers::mesh::imported {

namespace {

/// The first file of a ZIP archive whose name ends so.
std::string unpacked(const std::string& path, std::string_view ending) {
  const std::string bytes = core::read_file(path);
  const std::unique_ptr<archive, int (*)(archive*)> zip(archive_read_new(), archive_read_free);
  const auto fail = [&] {
    const char* reason = archive_error_string(zip.get());
    throw core::InputError(fmt::format("{}: cannot be unpacked: {}", path, reason ? reason : "?"));
  };
  archive_read_support_format_zip(zip.get());
  if (archive_read_open_memory(zip.get(), bytes.data(), bytes.size()) != ARCHIVE_OK) fail();
  archive_entry* entry = nullptr;
  for (;;) {
    const int outcome = archive_read_next_header(zip.get(), &entry);
    if (outcome == ARCHIVE_EOF)
      throw core::InputError(fmt::format("{}: has no file *{}", path, ending));
    if (outcome != ARCHIVE_OK && outcome != ARCHIVE_WARN) fail();
    const char* name = archive_entry_pathname_utf8(entry);
    if (name == nullptr || !std::string_view(name).ends_with(ending)) continue;
    std::string text;
    char block[1 << 16];
    for (;;) {
      const la_ssize_t size = archive_read_data(zip.get(), block, sizeof block);
      if (size < 0) fail();
      if (size == 0) return text;
      text.append(block, static_cast<std::size_t>(size));
    }
  }
}

double metres_of(std::string_view name) {
  if (name == "micron") return 1e-6;
  if (name == "centimeter") return 1e-2;
  if (name == "inch") return 0.0254;
  if (name == "foot") return 0.3048;
  if (name == "meter") return 1;
  return 1e-3;  // millimeter, which is what a model without the attribute has
}

}  // namespace

double unit_in_xml(const std::string& path, const std::string& extension) {
  const std::string text = extension == ".3mf" ? unpacked(path, ".model") : core::read_file(path);
  pugi::xml_document document;
  if (const auto outcome = document.load_buffer(text.data(), text.size()); !outcome)
    throw core::InputError(
        fmt::format("{}: {} (byte {} of its XML)", path, outcome.description(), outcome.offset));
  if (extension == ".3mf") return metres_of(document.child("model").attribute("unit").value());
  double unit = 1;
  if (extension == ".dae") {
    unit = document.child("COLLADA").child("asset").child("unit").attribute("meter").as_double(1);
  } else {
    for (const pugi::xml_node one : document.child("X3D").child("head").children("unit")) {
      if (std::string_view(one.attribute("category").value()) == "length")
        unit = one.attribute("conversionFactor").as_double(1);
    }
  }
  if (!(unit > 0 && std::isfinite(unit)))
    throw core::InputError(fmt::format("{}: a unit of length of {} m", path, unit));
  return unit;
}

}  // namespace carillon::solvers::mesh::imported
