#include "dataset/plan/plan.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <set>

#include "core/error.hpp"
#include "core/files.hpp"
#include "core/hash.hpp"
#include "core/random.hpp"
#include "core/text.hpp"
#include "dataset/plan/disk.hpp"
#include "dataset/plan/identities.hpp"
#include "scene/solved_object.hpp"
#include "solvers/families/families.hpp"

namespace carillon::dataset::plan {

using core::InputError;

std::string part_of_split(const configuration::BuildConfig& config, const std::string& identity,
                          std::string_view purpose) {
  core::RandomStream random(config.seed, core::stable_hash(identity), purpose);
  const double draw = random.uniform();
  if (draw < config.split.test) return "test";
  if (draw < config.split.test + config.split.validation) return "validation";
  return "train";
}

namespace {

/// Where its folder says train or test, validation is a fraction of train.
std::string part_of_shape(const configuration::BuildConfig& config, const Shape& shape) {
  if (shape.given_part == "test" || (!shape.place.empty() && !shape.given_part.empty()))
    return shape.given_part;
  if (shape.given_part.empty()) return part_of_split(config, shape.identity, "split.shape");
  core::RandomStream random(config.seed, core::stable_hash(shape.identity), "split.shape");
  return random.uniform() < config.split.validation ? "validation" : "train";
}

constexpr std::size_t samples_per_task = 256;
/// A task of simulations holds about so many bytes of them at once.
constexpr double bytes_per_task = 2.5e8;
/// A simulation is seconds of work.
constexpr double simulations_per_task = 4;

/// Draws an instance's parameters, and scales them to the length that is asked for; combinations
/// that the family refuses are drawn again.
solvers::mesh::GeneratedShape draw_shape(const configuration::BuildConfig& config,
                                         const configuration::ObjectSource& source,
                                         const std::string& id) {
  constexpr int tries = 1000;
  const solvers::families::Family& family = solvers::families::find_family(source.object.family);
  core::RandomStream random(config.seed, core::stable_hash(id), "shape.parameters");
  std::string refusal;
  for (int i = 0; i < tries; ++i) {
    solvers::mesh::GeneratedShape shape{source.object.family, {}, source.object.profile};
    for (const auto& [name, range] : source.object.parameters) {
      shape.parameters[name] = random.uniform(range.low, range.high);
    }
    try {
      family.check(shape);
      if (source.object.file.length > 0)
        solvers::families::scale_to(shape, source.object.file.length);
      return shape;
    } catch (const InputError& error) {
      refusal = error.message();
    }
  }
  throw InputError(
      fmt::format("{}: no parameters in the given ranges fit together: {}", id, refusal),
      "change the ranges of objects[].parameters");
}

void add_family(const configuration::BuildConfig& config, std::size_t index, BuildPlan& plan) {
  const configuration::ObjectSource& source = config.objects[index];
  for (int i = 0; i < source.count; ++i) {
    Shape shape;
    shape.id = core::file_safe(fmt::format("{}-{:03}", source.object.name, i));
    shape.family = source.object.family;
    shape.source = index;
    shape.request.shape = draw_shape(config, source, shape.id);
    plan.shapes.push_back(std::move(shape));
  }
}

std::string joined_name(const std::string& entry, const std::string& file,
                        const std::string& node) {
  std::string name = entry.empty() ? file : fmt::format("{}-{}", entry, file);
  if (!node.empty()) name += "-" + node;
  return name;
}

/// Names tell files of one entry apart, in other folders too where a pattern looks there.
std::string name_of(const configuration::ObjectSource& source, const FoundMesh& mesh) {
  const scene::Object& object = source.object;
  std::filesystem::path path(mesh.path);
  if (source.row && !source.row->name.empty()) return joined_name("", source.row->name, mesh.node);
  if (!object.named_by_folder) return joined_name(object.name, path.stem().string(), mesh.node);
  std::filesystem::path fixed;
  for (const std::filesystem::path& part : std::filesystem::path(object.pattern)) {
    if (part.string().find_first_of("*?[") != std::string::npos) break;
    fixed /= part;
  }
  path = path.lexically_relative(fixed);
  std::string name = (path.parent_path() / path.stem()).generic_string();
  if (name == "." || name.empty()) name = path.stem().string();
  std::replace(name.begin(), name.end(), '/', '-');
  return joined_name(object.name, name, mesh.node);
}

void add_files(const configuration::BuildConfig& config, std::size_t index, const FindMeshes& find,
               BuildPlan& plan) {
  const scene::Object& object = config.objects[index].object;
  const std::vector<FoundMesh> meshes = find ? find(index) : find_meshes(object);
  if (meshes.empty()) {
    throw InputError(fmt::format("objects[{}].{}: nothing matches {}", config.objects[index].entry,
                                 object.modelnet          ? "modelnet"
                                 : object.named_by_folder ? "glob"
                                                          : "mesh",
                                 object.pattern));
  }
  for (const FoundMesh& mesh : meshes) {
    Shape shape;
    shape.id = core::file_safe(name_of(config.objects[index], mesh));
    shape.family = object.name.empty() ? "mesh" : object.name;
    if (const auto& row = config.objects[index].row) {
      if (!row->family.empty()) shape.family = row->family;
      shape.given_part = row->part;
      shape.place = row->place;
      shape.labels = row->labels;
    }
    if (object.modelnet) {
      const auto [family, part] = configuration::modelnet_place(mesh.path);
      shape.family = family;
      shape.given_part = part;
    }
    shape.path = mesh.path;
    shape.source = index;
    shape.request.file = object.file;
    shape.request.file.path = mesh.path;
    shape.request.file.node = mesh.node;
    shape.sha256 = mesh.sha256;
    shape.signature = mesh.signature;
    shape.surface = mesh.surface;
    plan.shapes.push_back(std::move(shape));
  }
}

/// @throws InputError  the axisymmetric solver is asked for of an object that it cannot take
scene::SolverDecision solver_of(const configuration::BuildConfig& config, const Shape& shape) {
  const scene::Object& object = config.objects[shape.source].object;
  scene::SolverRequest request = config.object_solver;
  if (object.solver != scene::ObjectSolver::automatic) request.solver = object.solver;
  std::vector<solvers::elements::Elastic> materials;
  if (object.groups.empty()) {
    for (const Variant& variant : shape.variants) {
      materials.push_back(
          scene::object_material(object, variant.material, config.own_materials).elastic);
    }
  }
  try {
    return scene::decide_solver(request, shape.request, materials);
  } catch (const InputError& error) {
    throw InputError(fmt::format("{}: {}", shape.id, error.message()), error.hint());
  }
}

/// Every given strike speaks of a shape that there is.
void check_given_strikes(const configuration::BuildConfig& config,
                         const std::set<std::string>& ids) {
  for (const scene::GivenStrike& strike : config.scene.strikes.given) {
    if (strike.shape.empty() || strike.shape == "*" || ids.contains(strike.shape)) continue;
    const std::string near =
        core::nearest_name(strike.shape, std::vector<std::string>(ids.begin(), ids.end()));
    throw InputError(
        fmt::format("strikes.csv names a shape \"{}\" that is not built", strike.shape),
        near.empty() ? fmt::format("shapes are {}", fmt::join(ids, ", "))
                     : fmt::format("did you mean \"{}\"?", near));
  }
}

/// Strike numbers of a shape: drawn ones, or those rows of the CSV that speak of it.
std::vector<int> strike_numbers(const configuration::BuildConfig& config, const Shape& shape) {
  std::vector<int> numbers;
  if (config.scene.strikes.given.empty()) {
    for (int i = 0; i < config.scene.strikes.per_object; ++i) numbers.push_back(i);
    return numbers;
  }
  for (std::size_t i = 0; i < config.scene.strikes.given.size(); ++i) {
    const std::string& wanted = config.scene.strikes.given[i].shape;
    if (wanted.empty() || wanted == "*" || wanted == shape.id)
      numbers.push_back(static_cast<int>(i));
  }
  return numbers;
}

void add_samples(const configuration::BuildConfig& config, std::size_t shape_index,
                 BuildPlan& plan) {
  const Shape& shape = plan.shapes[shape_index];
  const std::size_t first = plan.samples.size();
  for (const int strike : strike_numbers(config, shape)) {
    for (std::size_t v = 0; v < shape.variants.size(); ++v) {
      if (!shape.variants[v].sounds) continue;
      Sample sample;
      sample.key = fmt::format("{}/strike-{:04}", object_name(shape.id, shape.variants[v]), strike);
      sample.id = core::stable_hash(sample.key);
      sample.shape = shape_index;
      sample.variant = v;
      sample.strike = strike;
      plan.samples.push_back(std::move(sample));
    }
  }
  for (std::size_t from = first; from < plan.samples.size(); from += samples_per_task) {
    BuildTask task;
    task.kind = TaskKind::samples;
    task.key = fmt::format("samples/{}-{:04}", shape.id, (from - first) / samples_per_task);
    task.shape = shape_index;
    task.first = from;
    task.count = std::min(samples_per_task, plan.samples.size() - from);
    plan.tasks.push_back(std::move(task));
  }
}

void add_simulations(const configuration::BuildConfig& config, BuildPlan& plan) {
  std::vector<std::size_t> cast;
  for (std::size_t s = 0; s < plan.shapes.size(); ++s) {
    const std::string& object = config.objects[plan.shapes[s].source].object.name;
    const auto& bodies = config.motion->bodies;
    if (std::any_of(bodies.begin(), bodies.end(),
                    [&](const scene::motion::CastBody& body) { return body.object == object; })) {
      cast.push_back(s);
    }
  }
  for (int number = 0; number < config.motion->simulations; ++number) {
    Sample sample;
    sample.key = fmt::format("simulation-{:04}", number);
    sample.id = core::stable_hash(sample.key);
    sample.shape = cast.front();
    sample.variant = 0;
    sample.strike = number;
    plan.samples.push_back(std::move(sample));
  }
  const auto each = static_cast<std::size_t>(
      std::clamp(bytes_per_task / sample_bytes(config).total(), 1.0, simulations_per_task));
  for (std::size_t from = 0; from < plan.samples.size(); from += each) {
    BuildTask task;
    task.kind = TaskKind::samples;
    task.key = fmt::format("samples/simulations-{:04}", from / each);
    task.shape = cast.front();
    task.first = from;
    task.count = std::min(each, plan.samples.size() - from);
    task.cast = cast;
    plan.tasks.push_back(std::move(task));
  }
}

}  // namespace

BuildPlan make_plan(const configuration::BuildConfig& config, const FindMeshes& find) {
  BuildPlan plan;
  for (std::size_t i = 0; i < config.objects.size(); ++i) {
    config.objects[i].object.family.empty() ? add_files(config, i, find, plan)
                                            : add_family(config, i, plan);
  }
  decide_identities(plan.shapes);
  std::set<std::string> ids;
  for (Shape& shape : plan.shapes) {
    if (!ids.insert(shape.id).second) {
      throw InputError(fmt::format("two shapes are named \"{}\"", shape.id),
                       shape.place.empty() ? "give one of the entries of objects another `name:`"
                                           : shape.place + ": give the row a name of its own");
    }
    shape.request.options = config.mesh;
    shape.variants = make_variants(config, config.objects[shape.source], shape.id);
    shape.solver = solver_of(config, shape);
    shape.split_shape = part_of_shape(config, shape);
  }
  for (std::size_t i = 0; i < plan.shapes.size(); ++i) {
    plan.tasks.push_back({TaskKind::modes, "modes/" + plan.shapes[i].id, i, 0, 0});
  }
  if (config.motion) {
    add_simulations(config, plan);
    return plan;
  }
  check_given_strikes(config, ids);
  for (std::size_t i = 0; i < plan.shapes.size(); ++i) add_samples(config, i, plan);
  if (plan.samples.empty()) {
    throw InputError("the configuration makes no samples",
                     "no strike of strikes.csv speaks of any of its shapes");
  }
  return plan;
}

std::vector<std::string> pictured_materials(const Shape& shape) {
  std::vector<std::string> names;
  for (const Variant& variant : shape.variants) {
    if (!variant.sounds) continue;
    if (std::find(names.begin(), names.end(), variant.material) == names.end())
      names.push_back(variant.material);
  }
  return names;
}

std::size_t pictures(const BuildPlan& plan) {
  std::size_t count = 0;
  for (const Shape& shape : plan.shapes) count += pictured_materials(shape).size();
  return count;
}

std::string picture_name(const Shape& shape, const std::string& material, std::size_t view) {
  const std::string number = view == 0 ? "" : fmt::format(".{}", view + 1);
  return fmt::format("pictures/{}.{}{}.png", shape.id, core::file_safe(material), number);
}

std::vector<std::size_t> shapes_of(const BuildPlan& plan, const Sample& sample) {
  for (const BuildTask& task : plan.tasks) {
    if (task.kind == TaskKind::samples && !task.cast.empty()) return task.cast;
  }
  return {sample.shape};
}

namespace {

/// A damping model to the last bit. Rayleigh's parameters stand alone.
std::string identity_of(const synth::damping::DampingModel& model) {
  const std::string alphas = fmt::format("{}", fmt::join(model.parameters, " "));
  if (model.kind == synth::damping::DampingKind::rayleigh) return alphas;
  return fmt::format("{} {} {}", synth::damping::form_of(model.kind).name, alphas,
                     model.expression);
}

}  // namespace

std::string fingerprint(const configuration::BuildConfig& config, const BuildPlan& plan) {
  core::Sha256 hash;
  for (const synth::material::Material& m : config.own_materials) {
    hash.add(fmt::format("{} {} {}\n", m.name,
                         fmt::join(solvers::elements::identity_of(m.elastic), " "),
                         identity_of(m.damping)));
    if (m.appearance) hash.add(render::looks::to_json(*m.appearance).dump());
  }
  for (const scene::GivenStrike& s : config.scene.strikes.given) {
    const Vec3 direction = s.direction.value_or(Vec3::Zero());
    hash.add(fmt::format("{} {} {}\n", s.shape, s.impulse, s.contact_time));
    hash.add(std::span<const double>(s.position.data(), 3));
    hash.add(std::span<const double>(direction.data(), 3));
  }
  for (const scene::EffectDecision& effect : config.scene.effects) {
    if (effect.enabled && effect.in_scene.content) hash.add(effect.in_scene.content());
  }
  for (const Shape& shape : plan.shapes) {
    hash.add(shape.id)
        .add(shape.sha256)
        .add(shape.identity)
        .add(solvers::mesh::to_json(shape.request).dump());
    if (!shape.labels.empty()) hash.add(nlohmann::json(shape.labels).dump());
  }
  for (const Sample& sample : plan.samples) hash.add(sample.key).add("\n");
  return hash.hex();
}

std::string split_strike(const configuration::BuildConfig& config, const Shape& shape, int strike) {
  // Given strikes at one point are one strike to the split: that of the first row.
  const std::vector<scene::GivenStrike>& given = config.scene.strikes.given;
  const auto first = std::find_if(given.begin(), given.end(), [&](const scene::GivenStrike& other) {
    return other.position == given[static_cast<std::size_t>(strike)].position;
  });
  const auto number = given.empty() ? strike : static_cast<int>(first - given.begin());
  return part_of_split(config, fmt::format("{}/strike-{:04}", shape.identity, number),
                       "split.strike");
}

}  // namespace carillon::dataset::plan
