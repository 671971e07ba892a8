#include "dataset/configuration/objects.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <set>
#include <utility>

#include "core/error.hpp"
#include "core/files.hpp"
#include "core/random.hpp"
#include "solvers/families/families.hpp"

namespace carillon::dataset::configuration {

using core::at_key;
using core::ConfigNode;
using core::Dimension;
using core::path_beside;
using core::Range;

namespace {

void read_family(ConfigNode& node, ObjectSource& source, const std::string& file_name) {
  source.family = node.text("shape");
  at_key(node, "shape", [&] { solvers::families::find_family(source.family); });
  const solvers::families::Family& family = solvers::families::find_family(source.family);
  source.name = node.text("name", source.family);
  source.count = static_cast<int>(node.integer("count", 1, 1000000, 1));
  source.file.length = node.not_negative("length", Dimension::length, 0);
  if (source.family == "turned") {
    if (node.has("svg")) {
      source.svg = path_beside(file_name, node.text("svg"));
      const double height = node.quantity("height", Dimension::length);
      at_key(node, "svg",
             [&] { source.profile = solvers::families::profile_from_svg(source.svg, height); });
    } else {
      for (ConfigNode& point : node.children("profile")) {
        source.profile.push_back({point.quantity("radius", Dimension::length),
                                  point.quantity("height", Dimension::length)});
      }
    }
  }
  ConfigNode parameters = node.child("parameters");
  for (const solvers::families::FamilyParameter& p : family.parameters) {
    source.parameters[p.name] = parameters.range(p.name, Dimension::length, Range{p.low, p.high});
  }
}

void read_files(ConfigNode& node, ObjectSource& source, const std::string& file_name) {
  if (node.has("modelnet")) {
    const std::string folder = path_beside(file_name, node.text("modelnet"));
    source.pattern = (std::filesystem::path(folder) / "*" / "t[er]*" / "*.off").string();
    source.modelnet = ModelNet{node.texts("classes", std::vector<std::string>{}),
                               static_cast<int>(node.integer("per_class", 0, 1000000, 0))};
  } else {
    source.pattern = path_beside(file_name, node.text("mesh"));
  }
  source.name = node.text("name", "");
  source.file.length = node.not_negative("length", Dimension::length, 0);
  source.file.thickness = node.not_negative("thickness", Dimension::length, 0);
  source.file.wrap_tolerance = node.quantity("wrap_tolerance", Dimension::none, 0.002);
  if (!(source.file.wrap_tolerance >= 1e-4 && source.file.wrap_tolerance <= 0.05)) {
    node.fail("wrap_tolerance", "must lie between 0.0001 and 0.05 of the box diagonal");
  }
}

/// Equal variants would be the same samples twice.
template <class T>
void refuse_doubles(const ConfigNode& node, const std::string& key, const std::vector<T>& values) {
  if (std::set<T>(values.begin(), values.end()).size() != values.size()) {
    node.fail(key, "the same value stands here twice");
  }
}

std::optional<DrawnSize> read_drawn_size(ConfigNode& node) {
  if (!node.has("drawn_size")) return {};
  ConfigNode drawn = node.child("drawn_size");
  const DrawnSize size{drawn.quantity("mean", Dimension::none),
                       drawn.quantity("deviation", Dimension::none)};
  if (!(size.mean > 0)) drawn.fail("mean", "a size is a positive factor on every length");
  if (!(size.deviation >= 1e-3 * size.mean && size.deviation <= size.mean / 4)) {
    drawn.fail("deviation", "must lie between a thousandth and a quarter of the mean",
               "sizes are drawn within three deviations of it");
  }
  return size;
}

void read_object_materials(ConfigNode& node, ObjectSource& source,
                           const std::vector<std::string>& shared,
                           const std::vector<synth::material::Material>& own) {
  if (node.is_mapping("materials")) {
    ConfigNode groups = node.child("materials");
    for (const std::string& group : groups.keys()) source.groups[group] = groups.text(group);
  } else {
    source.materials = node.texts("materials", shared);
    if (source.materials.empty()) node.fail("materials", "no material is named");
  }
  at_key(node, "materials", [&] {
    for (const std::string& name : source.materials) {
      synth::material::parse_material(name, own);
    }
    for (const auto& [group, name] : source.groups) {
      synth::material::parse_material(name, own);
    }
  });
  source.drawn_size = read_drawn_size(node);
  if (!source.drawn_size || node.has("sizes")) {
    source.sizes = node.quantities("sizes", Dimension::none, 0, std::vector<double>{1});
    if (source.sizes.empty()) node.fail("sizes", "no size is named");
  }
  refuse_doubles(node, "materials", source.materials);
  refuse_doubles(node, "sizes", source.sizes);
  for (const double size : source.sizes) {
    if (!(size > 0)) node.fail("sizes", "a size is a positive factor on every length");
  }
}

}  // namespace

ObjectSource read_object(ConfigNode& node, const std::vector<std::string>& shared_materials,
                         const std::vector<synth::material::Material>& own,
                         const std::string& file_name) {
  ObjectSource source;
  if (node.has("shape") + node.has("mesh") + node.has("modelnet") != 1) {
    node.fail("",
              "an object is a `shape:` (a family), a `mesh:` (files) or a `modelnet:` (a folder)");
  }
  if (node.has("shape")) {
    read_family(node, source, file_name);
  } else {
    read_files(node, source, file_name);
  }
  source.file.any_size = node.flag("any_size", false);
  read_object_materials(node, source, shared_materials, own);
  return source;
}

ModelNetPlace modelnet_place(const std::string& path) {
  const std::filesystem::path part = std::filesystem::path(path).parent_path();
  return {part.parent_path().filename().string(), part.filename().string()};
}

std::vector<std::string> object_files(const ObjectSource& source) {
  std::vector<std::string> files;
  for (const auto& path : core::glob_files(source.pattern)) files.push_back(path.string());
  if (!source.modelnet) return files;
  const ModelNet& wanted = *source.modelnet;
  using Ranked = std::pair<std::uint64_t, std::string>;
  std::map<std::string, std::vector<Ranked>> by_class;
  for (const std::string& path : files) {
    const auto [family, part] = modelnet_place(path);
    const bool named =
        wanted.classes.empty() ||
        std::find(wanted.classes.begin(), wanted.classes.end(), family) != wanted.classes.end();
    if (!named || (part != "train" && part != "test")) continue;
    const std::string name = std::filesystem::path(path).filename().string();
    by_class[family].emplace_back(core::stable_hash(part + "/" + name), path);
  }
  files.clear();
  for (auto& [family, members] : by_class) {
    std::sort(members.begin(), members.end());
    const auto most = static_cast<std::size_t>(wanted.per_class);
    if (most > 0 && members.size() > most) members.resize(most);
    for (const auto& [rank, path] : members) files.push_back(path);
  }
  std::sort(files.begin(), files.end());
  return files;
}

std::string files_key(const ObjectSource& source) {
  if (!source.modelnet) return source.pattern;
  return fmt::format("{}\n{} {}", source.pattern, source.modelnet->per_class,
                     fmt::join(source.modelnet->classes, " "));
}

VariantChoice read_variant_choice(ConfigNode node) {
  const auto which = [&](const char* key) {
    const std::string text = node.choice(key, {"all", "first", "last"}, "all");
    return text == "all" ? Which::all : text == "first" ? Which::first : Which::last;
  };
  return {which("materials"), which("sizes")};
}

}  // namespace carillon::dataset::configuration
