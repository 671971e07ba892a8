#include "scene/sounding_gltf.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include "core/error.hpp"
#include "core/units.hpp"
#include "scene/detail/gltf_reader.hpp"
#include "solvers/mesh/readers/file_kind.hpp"

namespace carillon::scene {

namespace {

using nlohmann::json;

constexpr const char* extension = "KHR_audio_rigid_bodies";

/// A node that has a modal model, with the transform from its place to the file's.
struct SoundingNode {
  std::string name;
  std::size_t model;
  Eigen::Matrix4d transform;
};

Eigen::Matrix4d own_transform(const json& node) {
  Eigen::Matrix4d whole = Eigen::Matrix4d::Identity();
  if (node.contains("matrix")) {
    const auto values = node.at("matrix").get<std::array<double, 16>>();
    return Eigen::Map<const Eigen::Matrix4d>(values.data());  // column by column
  }
  const auto t = node.value("translation", std::array<double, 3>{0, 0, 0});
  const auto r = node.value("rotation", std::array<double, 4>{0, 0, 0, 1});
  const auto s = node.value("scale", std::array<double, 3>{1, 1, 1});
  whole.topLeftCorner<3, 3>() =
      Eigen::Quaterniond(r[3], r[0], r[1], r[2]).normalized().toRotationMatrix() *
      Vec3(s[0], s[1], s[2]).asDiagonal();
  whole.topRightCorner<3, 1>() = Vec3(t[0], t[1], t[2]);
  return whole;
}

void find_nodes(const GltfReader& file, std::size_t number, const Eigen::Matrix4d& above, int depth,
                std::vector<SoundingNode>& found) {
  constexpr int deepest = 100;
  if (depth > deepest) file.fail("its nodes are nested without end");
  const json& node = file.document().at("nodes").at(number);
  const Eigen::Matrix4d transform = above * own_transform(node);
  const json extensions = node.value("extensions", json::object());
  if (extensions.contains(extension) && extensions.at(extension).contains("modalModel")) {
    const std::string name = node.value("name", fmt::format("node-{}", number));
    found.push_back(
        {name, extensions.at(extension).at("modalModel").get<std::size_t>(), transform});
  }
  for (const json& child : node.value("children", json::array()))
    find_nodes(file, child.get<std::size_t>(), transform, depth + 1, found);
}

std::vector<SoundingNode> sounding_nodes(const GltfReader& file) {
  // glTF has y up.
  Eigen::Matrix4d upright = Eigen::Matrix4d::Identity();
  upright.topLeftCorner<3, 3>() << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  std::vector<SoundingNode> found;
  const json& scenes = file.document().at("scenes");
  const auto scene = file.document().value("scene", std::size_t{0});
  for (const json& root : scenes.at(scene).value("nodes", json::array()))
    find_nodes(file, root.get<std::size_t>(), upright, 0, found);
  return found;
}

SoundingNode chosen_node(const GltfReader& file, const std::string& name) {
  const std::vector<SoundingNode> nodes = sounding_nodes(file);
  std::vector<std::string> names;
  for (const SoundingNode& node : nodes) names.push_back(node.name);
  if (nodes.empty()) file.fail("no node of it has a modal model");
  if (name.empty()) {
    if (nodes.size() > 1)
      file.fail(fmt::format("several nodes have a modal model: name one of {} as node",
                            fmt::join(names, ", ")));
    return nodes.front();
  }
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end())
    file.fail(fmt::format("no node \"{}\" has a modal model; {} do", name, fmt::join(names, ", ")));
  return nodes[static_cast<std::size_t>(found - names.begin())];
}

/// Numbers of a modal model, as they stand.
struct ModalModel {
  std::vector<double> frequencies, decay_rates, positions, shapes;
  std::vector<std::int32_t> indices;
  double mass = 0;
  json material;  ///< null: none
};

ModalModel read_model(const GltfReader& file, std::size_t number) {
  const json& resources = file.document().at("extensions").at(extension);
  const json& in = resources.at("modalModels").at(number);
  ModalModel model;
  model.frequencies = file.numbers(in.at("frequencies").get<std::size_t>(), "SCALAR");
  model.decay_rates = file.numbers(in.at("decayRates").get<std::size_t>(), "SCALAR");
  model.positions = file.numbers(in.at("positions").get<std::size_t>(), "VEC3");
  model.shapes = file.numbers(in.at("shapes").get<std::size_t>(), "VEC3");
  if (in.contains("indices")) model.indices = file.indices(in.at("indices").get<std::size_t>());
  model.mass = in.value("massProperties", json::object()).value("mass", 0.0);
  if (in.contains("material"))
    model.material = resources.at("acousticMaterials").at(in.at("material").get<std::size_t>());
  const std::size_t modes = model.frequencies.size(), points = model.positions.size() / 3;
  if (modes == 0 || points == 0 || model.decay_rates.size() != modes ||
      model.shapes.size() != 3 * modes * points) {
    file.fail(
        fmt::format("{} frequencies, {} decay rates, {} points and {} shapes are no modal model",
                    modes, model.decay_rates.size(), points, model.shapes.size() / 3));
  }
  const auto last = static_cast<std::int32_t>(points);
  if (model.indices.empty() || model.indices.size() % 3 != 0 ||
      std::any_of(model.indices.begin(), model.indices.end(),
                  [last](std::int32_t index) { return index >= last; })) {
    file.fail("a modal model is struck here where it has triangles between its points (`indices`)");
  }
  for (std::size_t i = 0; i < modes; ++i) {
    if (!(model.frequencies[i] > 0 && model.decay_rates[i] >= 0))
      file.fail(fmt::format("mode {} has {} Hz and decays by {} 1/s", i, model.frequencies[i],
                            model.decay_rates[i]));
  }
  return model;
}

/// Mass- and stiffness-proportional parts of decay rates by least squares, none below zero: what
/// the material of a file without alpha and beta is said to have.
std::array<double, 2> rayleigh_like(const std::vector<double>& eigenvalues,
                                    const std::vector<double>& decay_rates) {
  const double top = *std::max_element(eigenvalues.begin(), eigenvalues.end());
  double n = 0, x = 0, xx = 0, y = 0, xy = 0;
  for (std::size_t i = 0; i < eigenvalues.size(); ++i) {
    const double at = eigenvalues[i] / top, c = 2 * decay_rates[i];
    n += 1, x += at, xx += at * at, y += c, xy += at * c;
  }
  const double determinant = n * xx - x * x;
  double alpha = y / n, beta = 0;
  if (determinant > 1e-12 * n * xx) {
    alpha = (y * xx - x * xy) / determinant;
    beta = (n * xy - x * y) / determinant;
  }
  if (alpha < 0) alpha = 0, beta = xy / xx;
  if (beta < 0) alpha = y / n, beta = 0;
  return {alpha, beta / top};
}

/// @param assumed  gets what the file does not say, with what stands in for it
synth::material::Material material_of(const GltfReader& file, const ModalModel& model,
                                      const solvers::modes::Modes& modes,
                                      std::vector<std::string>& assumed) {
  const json& in = model.material;
  const bool is_given = in.is_object();
  synth::material::Material material;
  material.name = is_given ? in.value("name", "unnamed") : "unnamed";
  // Strikers and, without massProperties, the mass need constants; those of aluminium stand in.
  const auto constant = [&](const char* key, double otherwise) {
    if (is_given && in.contains(key)) return in.at(key).get<double>();
    assumed.push_back(fmt::format("{} {:g}", key, otherwise));
    return otherwise;
  };
  material.elastic.youngs_modulus = constant("youngsModulus", 7e10);
  material.elastic.poisson_ratio = constant("poissonRatio", 0.33);
  material.elastic.density = constant("density", 2700);
  const bool has_both = is_given && in.contains("alpha") && in.contains("beta");
  const auto [alpha, beta] =
      has_both ? std::array{in.at("alpha").get<double>(), in.at("beta").get<double>()}
               : rayleigh_like(modes.eigenvalues, modes.given_decay_rates);
  material.damping = synth::damping::rayleigh_damping(alpha, beta);
  material.source = "the file";
  try {
    check_material(material);
  } catch (const core::InputError& error) {
    file.fail(fmt::format("its acoustic material: {}", error.message()));
  }
  return material;
}

}  // namespace

bool has_modal_model(const std::string& path) {
  const std::string ending = solvers::mesh::readers::mesh_extension(path);
  if (ending != ".glb" && ending != ".gltf") return false;
  try {
    const GltfReader file(path);
    return !sounding_nodes(file).empty();
  } catch (const std::exception&) {
    return false;
  }
}

SolvedObject read_sounding_gltf(const std::string& path, const std::string& name) {
  const GltfReader file(path);
  try {
    const SoundingNode node = chosen_node(file, name);
    const ModalModel model = read_model(file, node.model);
    const Eigen::Matrix3d linear = node.transform.topLeftCorner<3, 3>();
    const double scale = std::cbrt(std::abs(linear.determinant()));
    const Eigen::Matrix3d turn = linear / scale;
    if (!(scale > 0) || !(turn.transpose() * turn).isIdentity(1e-4))
      file.fail(fmt::format("node \"{}\" is not scaled alike in all directions", node.name));

    SolvedObject object;
    object.solver = {ObjectSolver::automatic, "its modes are in the file"};
    solvers::modes::Modes& modes = object.modes;
    const std::size_t points = model.positions.size() / 3, count = model.frequencies.size();
    for (std::size_t p = 0; p < points; ++p) {
      const Vec3 at(model.positions[3 * p], model.positions[3 * p + 1], model.positions[3 * p + 2]);
      modes.surface.nodes.emplace_back(linear * at + node.transform.topRightCorner<3, 1>());
    }
    modes.surface.faces = model.indices;
    if (turn.determinant() < 0)
      for (std::size_t i = 0; i < modes.surface.faces.size(); i += 3)
        std::swap(modes.surface.faces[i], modes.surface.faces[i + 1]);
    std::vector<std::size_t> ascending(count);
    std::iota(ascending.begin(), ascending.end(), std::size_t{0});
    std::stable_sort(ascending.begin(), ascending.end(), [&](std::size_t a, std::size_t b) {
      return model.frequencies[a] < model.frequencies[b];
    });
    const bool by_material = model.material.is_object() && model.material.contains("alpha") &&
                             model.material.contains("beta");
    solvers::modes::ModeShapes::Rows rows(count, 3 * points);
    for (std::size_t row = 0; row < count; ++row) {
      const std::size_t mode = ascending[row];
      double d = model.decay_rates[mode];
      const double omega = 2 * std::numbers::pi * model.frequencies[mode];
      // Of a body of another size: undamped frequencies are inverse to it.
      double eigenvalue = (omega * omega + d * d) / (scale * scale);
      if (std::abs(scale - 1) > 1e-9 && by_material) {
        d = (model.material.at("alpha").get<double>() +
             model.material.at("beta").get<double>() * eigenvalue) /
            2;
      }
      modes.eigenvalues.push_back(eigenvalue);
      modes.given_decay_rates.push_back(d);
      for (std::size_t p = 0; p < points; ++p) {
        const double* at = &model.shapes[3 * (mode * points + p)];
        const Vec3 shape = turn * Vec3(at[0], at[1], at[2]) / std::pow(scale, 1.5);
        for (int k = 0; k < 3; ++k)
          rows(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(3 * p) + k) =
              static_cast<float>(shape[k]);
      }
    }
    modes.shapes = solvers::modes::ModeShapes(std::move(rows));
    modes.residuals.assign(count, std::numeric_limits<double>::quiet_NaN());
    modes.kinetic_fraction = modes.strain_fraction =
        Eigen::MatrixXd::Ones(static_cast<Eigen::Index>(count), 1);
    modes.certificate.modes_found = static_cast<std::int64_t>(count);
    modes.certificate.min_frequency = modes.frequency(0);
    modes.certificate.max_frequency = modes.frequency(count - 1);
    std::vector<std::string> assumed;
    object.materials = {material_of(file, model, modes, assumed)};
    if (!assumed.empty())
      object.warnings.push_back(fmt::format(
          "the file does not say all of its material; for strikers{} it is taken to have {}",
          model.mass > 0 ? "" : " and the mass", fmt::join(assumed, ", ")));
    const double volume =
        std::abs(solvers::mesh::signed_volume(solvers::modes::flatten(modes.surface)));
    modes.mass = model.mass > 0 ? model.mass * std::pow(scale, 3)
                                : object.materials.front().elastic.density * volume;
    object.mesh.mesh.region_names = {"body"};
    return object;
  } catch (const json::exception& error) {
    file.fail(fmt::format("its modal model cannot be read: {}", error.what()));
  }
}

}  // namespace carillon::scene
