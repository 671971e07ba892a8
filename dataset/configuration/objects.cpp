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
#include "dataset/configuration/detail/manifest.hpp"

namespace carillon::dataset::configuration {

using core::ConfigNode;
using core::Dimension;

namespace {

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

void read_sizes(ConfigNode& node, ObjectSource& source) {
  source.drawn_size = read_drawn_size(node);
  if (!source.drawn_size || node.has("sizes")) {
    source.sizes = node.quantities("sizes", Dimension::none, 0, std::vector<double>{1});
    if (source.sizes.empty()) node.fail("sizes", "no size is named");
  }
  refuse_doubles(node, "sizes", source.sizes);
  for (const double size : source.sizes) {
    if (!(size > 0)) node.fail("sizes", "a size is a positive factor on every length");
  }
}

/// Pitches instead of sizes.
void read_tune(ConfigNode& node, ObjectSource& source) {
  for (const std::string other : {"sizes", "drawn_size", "length"}) {
    // A length of 0 asks for none.
    if (other == "length" ? !(source.object.file.length > 0) : !node.has(other)) continue;
    node.fail("tune", fmt::format("`tune` and `{}` both say how large the object is", other),
              "keep one of them");
  }
  source.sizes = {1};
  source.tune = node.is_list("tune") ? node.quantities("tune", Dimension::frequency)
                                     : std::vector{node.quantity("tune", Dimension::frequency)};
  if (source.tune.empty()) node.fail("tune", "no pitch is named");
  refuse_doubles(node, "tune", source.tune);
  for (const double pitch : source.tune) {
    if (!(pitch > 0)) node.fail("tune", "a pitch is positive", "write it as 440 Hz");
  }
  source.tune_mode = static_cast<int>(node.integer("tune_mode", 1, 100000, 1));
}

}  // namespace

std::vector<ObjectSource> read_objects(ConfigNode& node,
                                       const std::vector<std::string>& shared_materials,
                                       const std::vector<synth::material::Material>& own,
                                       const std::string& file_name) {
  ObjectSource source;
  source.object = scene::read_object(node, shared_materials, own, file_name);
  refuse_doubles(node, "materials", source.object.materials);
  if (!source.object.family.empty()) {
    source.count = static_cast<int>(node.integer("count", 1, 1000000, 1));
  }
  if (node.has("tune")) {
    read_tune(node, source);
  } else {
    if (node.has("tune_mode")) {
      node.fail("tune_mode", "there is no `tune`", "give the pitch too, as in tune: 440 Hz");
    }
    read_sizes(node, source);
  }
  if (source.object.manifest.empty()) return {source};
  return core::at_key(node, "manifest", [&] { return rows_of_manifest(source, own); });
}

ModelNetPlace modelnet_place(const std::string& path) {
  const std::filesystem::path part = std::filesystem::path(path).parent_path();
  return {part.parent_path().filename().string(), part.filename().string()};
}

std::vector<std::string> object_files(const scene::Object& object) {
  if (!object.manifest.empty()) return {object.pattern};
  std::vector<std::string> files;
  for (const auto& path : core::glob_files(object.pattern)) files.push_back(path.string());
  if (!object.modelnet) return files;
  const scene::ModelNet& wanted = *object.modelnet;
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
    const auto maximum = static_cast<std::size_t>(wanted.per_class);
    if (maximum > 0 && members.size() > maximum) members.resize(maximum);
    for (const auto& [rank, path] : members) files.push_back(path);
  }
  std::sort(files.begin(), files.end());
  return files;
}

std::string files_key(const scene::Object& object) {
  if (!object.manifest.empty()) return "=" + object.pattern;
  if (!object.modelnet) return object.pattern;
  return fmt::format("{}\n{} {}", object.pattern, object.modelnet->per_class,
                     fmt::join(object.modelnet->classes, " "));
}

VariantChoice read_variant_choice(ConfigNode node) {
  const auto which = [&](const char* key) {
    const std::string text = node.choice(key, {"all", "first", "last"}, "all");
    return text == "all" ? Which::all : text == "first" ? Which::first : Which::last;
  };
  VariantChoice choice{which("material_choice"), which("size_choice")};
  if (!node.has("materials_per_group")) return choice;
  choice.materials_per_group = static_cast<int>(node.integer("materials_per_group", 1, 1000));
  if (choice.materials != Which::all) {
    node.fail("materials_per_group", "draws the materials that `material_choice` chooses",
              "keep one of the two");
  }
  return choice;
}

MaterialSpread read_material_spread(ConfigNode node) {
  const auto factors = [&](const char* key) {
    const core::Range range = node.range(key, Dimension::none, core::Range{1, 1});
    if (!(range.low >= 0.01 && range.high <= 100)) {
      node.fail(key, "must be factors from 0.01 to 100", "[0.9, 1.1] is 10 % on either side");
    }
    return range;
  };
  return {factors("youngs_modulus"), factors("density"), factors("damping")};
}

}  // namespace carillon::dataset::configuration
