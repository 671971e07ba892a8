#include "solvers/mesh/shape_source.hpp"

#include <fmt/core.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <set>
#include <string_view>
#include <type_traits>
#include <utility>

#include "core/error.hpp"
#include "core/json.hpp"

namespace carillon::solvers::mesh {
namespace {

using nlohmann::json;

static_assert(std::endian::native == std::endian::little,
              "arrays are stored as they lie in memory");

/// Values as bytes. T: float64 or int32, little-endian.
template <class T>
json to_binary(const std::vector<T>& values) {
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(values.data());
  return json::binary(std::vector<std::uint8_t>(bytes, bytes + values.size() * sizeof(T)));
}

template <class T>
std::vector<T> from_binary(const json& value) {
  const auto& bytes = value.get_binary();
  if (bytes.size() % sizeof(T) != 0) throw core::FileError("an array of the mesh is cut off");
  std::vector<T> values(bytes.size() / sizeof(T));
  if (!values.empty()) std::memcpy(values.data(), bytes.data(), bytes.size());
  return values;
}

json to_binary(const std::vector<Vec3>& points) {
  std::vector<double> flat;
  flat.reserve(3 * points.size());
  for (const Vec3& p : points) flat.insert(flat.end(), {p.x(), p.y(), p.z()});
  return to_binary(flat);
}

std::vector<Vec3> points_from_binary(const json& value) {
  const auto flat = from_binary<double>(value);
  if (flat.size() % 3 != 0) throw core::FileError("the mesh's nodes are cut off");
  std::vector<Vec3> points;
  points.reserve(flat.size() / 3);
  for (std::size_t i = 0; i < flat.size(); i += 3) {
    points.emplace_back(flat[i], flat[i + 1], flat[i + 2]);
  }
  return points;
}

// One list of fields serves both directions: `visit(name, member)`.

template <class D, class Visit>
void visit_fields(D& d, Visit visit) {
  using Plain = std::remove_const_t<D>;
  if constexpr (std::is_same_v<Plain, Diagnosis>) {
    visit("vertices", d.vertices);
    visit("triangles", d.triangles);
    visit("duplicate_vertices", d.duplicate_vertices);
    visit("unreferenced_vertices", d.unreferenced_vertices);
    visit("degenerate_triangles", d.degenerate_triangles);
    visit("duplicate_triangles", d.duplicate_triangles);
    visit("boundary_edges", d.boundary_edges);
    visit("nonmanifold_edges", d.nonmanifold_edges);
    visit("nonmanifold_vertices", d.nonmanifold_vertices);
    visit("misoriented_edges", d.misoriented_edges);
    visit("self_intersections", d.self_intersections);
    visit("components", d.components);
    visit("nested_components", d.nested_components);
    visit("touching_components", d.touching_components);
    visit("closed", d.closed);
    visit("clean", d.clean);
    visit("volume", d.volume);
    visit("area", d.area);
    visit("extent", d.extent);
  } else if constexpr (std::is_same_v<Plain, RepairReport>) {
    visit("used_as_is", d.used_as_is);
    visit("actions", d.actions);
    visit("volume_change", d.volume_change);
    visit("area_change", d.area_change);
    visit("swallowed_volume", d.swallowed_volume);
    visit("swallowed_surfaces", d.swallowed_surfaces);
    visit("filled_area", d.filled_area);
    visit("joined", d.joined);
    visit("wrap_alpha", d.wrap_alpha);
  } else if constexpr (std::is_same_v<Plain, MeshQuality>) {
    visit("elements", d.elements);
    visit("nodes", d.nodes);
    visit("min_dihedral_deg", d.min_dihedral_deg);
    visit("max_dihedral_deg", d.max_dihedral_deg);
    visit("min_radius_ratio", d.min_radius_ratio);
    visit("median_radius_ratio", d.median_radius_ratio);
    visit("volume", d.volume);
    visit("straightened", d.straightened);
    visit("volume_error", d.volume_error);
    visit("volume_added", d.volume_added);
    visit("area_error", d.area_error);
    visit("hausdorff", d.hausdorff);
  } else if constexpr (std::is_same_v<Plain, GeneratedShape>) {
    visit("family", d.family);
    visit("parameters", d.parameters);
    visit("profile", d.profile);
  } else if constexpr (std::is_same_v<Plain, MeshFile>) {
    visit("path", d.path);
    visit("node", d.node);
    visit("length", d.length);
    visit("unit", d.unit);
    visit("any_size", d.any_size);
    visit("thickness", d.thickness);
    visit("wrap_tolerance", d.wrap_tolerance);
  } else if constexpr (std::is_same_v<Plain, MeshOptions>) {
    visit("order", d.order);
    visit("element_size", d.element_size);
    visit("max_elements", d.max_elements);
    visit("edge_layers", d.edge_layers);
  }
}

template <class D>
json fields_to_json(const D& d) {
  json out = json::object();
  visit_fields(d, [&out](const char* name, const auto& value) {
    if constexpr (std::is_same_v<std::decay_t<decltype(value)>, double>) {
      out[name] = core::number_or_null(value);
    } else {
      out[name] = value;
    }
  });
  return out;
}

/// Fields that requests and reports in older datasets lack.
const std::set<std::string_view> newer_fields = {"node", "joined"};

template <class D>
D fields_from_json(const json& in) {
  D d;
  visit_fields(d, [&in](const char* name, auto& value) {
    // What an earlier version did not write has its default.
    if (!in.contains(name) && newer_fields.contains(name)) return;
    if constexpr (std::is_same_v<std::decay_t<decltype(value)>, double>) {
      value = core::number_or_nan(in.at(name));
    } else {
      in.at(name).get_to(value);
    }
  });
  return d;
}

void check_indices(const std::vector<std::int32_t>& indices, std::size_t end, const char* what) {
  for (const std::int32_t i : indices) {
    if (i < 0 || static_cast<std::size_t>(i) >= end) {
      throw core::FileError(fmt::format("the mesh's {} point outside of it", what));
    }
  }
}

TetMesh tet_mesh_from_json(const json& in) {
  TetMesh mesh;
  mesh.order = in.at("order").get<int>();
  if (mesh.order < 1 || mesh.order > 4) throw core::FileError("the mesh's order is damaged");
  mesh.nodes = points_from_binary(in.at("nodes"));
  mesh.elements = from_binary<std::int32_t>(in.at("elements"));
  mesh.regions = from_binary<std::int32_t>(in.at("regions"));
  mesh.faces = from_binary<std::int32_t>(in.at("faces"));
  mesh.region_names = in.at("region_names").get<std::vector<std::string>>();
  const auto per_element = static_cast<std::size_t>(elements::nodes_per_tetrahedron(mesh.order));
  if (mesh.elements.size() != mesh.element_count() * per_element ||
      mesh.faces.size() % static_cast<std::size_t>(elements::nodes_per_face(mesh.order)) != 0) {
    throw core::FileError("the mesh's arrays do not fit together");
  }
  mesh.finer_nodes = points_from_binary(in.at("finer_nodes"));
  mesh.finer_gaps = points_from_binary(in.at("finer_gaps"));
  check_indices(mesh.elements, mesh.nodes.size(), "elements");
  check_indices(mesh.faces, mesh.nodes.size(), "faces");
  check_indices(mesh.regions, mesh.region_names.size(), "regions");
  return mesh;
}

json surface_to_json(const SurfaceMesh& surface) {
  std::vector<std::int32_t> corners;
  for (const Triangle& triangle : surface.triangles)
    corners.insert(corners.end(), triangle.begin(), triangle.end());
  return {{"vertices", to_binary(surface.vertices)}, {"triangles", to_binary(corners)}};
}

SurfaceMesh surface_from_json(const json& in) {
  SurfaceMesh surface{points_from_binary(in.at("vertices")), {}};
  const auto corners = from_binary<std::int32_t>(in.at("triangles"));
  if (corners.size() % 3 != 0) throw core::FileError("the surface's triangles are cut off");
  check_indices(corners, surface.vertices.size(), "triangles");
  for (std::size_t i = 0; i < corners.size(); i += 3) {
    surface.triangles.push_back({corners[i], corners[i + 1], corners[i + 2]});
  }
  return surface;
}

/// Runs a reader; what nlohmann's library throws becomes a FileError.
template <class Read>
auto read_json(const char* what, Read read) {
  try {
    return read();
  } catch (const json::exception& error) {
    throw core::FileError(fmt::format("damaged {}: {}", what, error.what()));
  }
}

}  // namespace

json to_json(const MeshRequest& request) {
  json out = {{"shape", fields_to_json(request.shape)},
              {"file", fields_to_json(request.file)},
              {"options", fields_to_json(request.options)}};
  if (!request.file.surface.triangles.empty())
    out["surface"] = surface_to_json(request.file.surface);
  return out;
}

MeshRequest mesh_request_from_json(const json& in) {
  return read_json("mesh request", [&in] {
    MeshRequest request{fields_from_json<GeneratedShape>(in.at("shape")),
                        fields_from_json<MeshFile>(in.at("file")),
                        fields_from_json<MeshOptions>(in.at("options"))};
    if (in.contains("surface")) {
      request.file.surface = surface_from_json(in.at("surface"));
      if (request.file.path.empty()) request.file.path = "triangles";
    }
    return request;
  });
}

json to_json(const Diagnosis& diagnosis) {
  return fields_to_json(diagnosis);
}
json to_json(const RepairReport& report) {
  return fields_to_json(report);
}
json to_json(const MeshQuality& quality) {
  return fields_to_json(quality);
}

Diagnosis diagnosis_from_json(const json& in) {
  return read_json("diagnosis", [&in] { return fields_from_json<Diagnosis>(in); });
}

json to_json(const RepairedBody& body) {
  return {{"surface", surface_to_json(body.surface)},
          {"diagnosis", to_json(body.diagnosis)},
          {"repair", to_json(body.repair)}};
}

RepairedBody repaired_body_from_json(const json& in) {
  return read_json("body", [&in] {
    return RepairedBody{surface_from_json(in.at("surface")),
                        fields_from_json<Diagnosis>(in.at("diagnosis")),
                        fields_from_json<RepairReport>(in.at("repair"))};
  });
}

json to_json(const MeshResult& result) {
  const TetMesh& mesh = result.mesh;
  return {{"mesh",
           {{"order", mesh.order},
            {"nodes", to_binary(mesh.nodes)},
            {"elements", to_binary(mesh.elements)},
            {"regions", to_binary(mesh.regions)},
            {"region_names", mesh.region_names},
            {"faces", to_binary(mesh.faces)},
            {"finer_nodes", to_binary(mesh.finer_nodes)},
            {"finer_gaps", to_binary(mesh.finer_gaps)}}},
          {"quality", to_json(result.quality)},
          {"diagnosis", to_json(result.diagnosis)},
          {"repair", to_json(result.repair)}};
}

MeshResult mesh_result_from_json(const json& in) {
  return read_json("mesh", [&in] {
    return MeshResult{tet_mesh_from_json(in.at("mesh")),
                      fields_from_json<MeshQuality>(in.at("quality")),
                      fields_from_json<Diagnosis>(in.at("diagnosis")),
                      fields_from_json<RepairReport>(in.at("repair"))};
  });
}

}  // namespace carillon::solvers::mesh
