#include "dataset/samples/detail/object_views.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "core/error.hpp"
#include "core/files.hpp"
#include "core/image.hpp"
#include "core/text.hpp"
#include "dataset/samples/shape_modes.hpp"
#include "solvers/mesher/file_contents.hpp"

namespace carillon::dataset::samples {

namespace {

/// The file's own colours at the vertices; none where it has none, or where they cannot be read: a
/// picture is no reason for an object to fail.
std::vector<Vec3> colours_of(const configuration::BuildConfig& config, const plan::Shape& shape,
                             const solvers::mesh::SurfaceMesh& surface) {
  if (shape.path.empty()) return {};
  try {
    return solvers::mesher::colours_in_child(shape.request.file, surface.vertices,
                                             config.limits.mesh);
  } catch (const core::Error& error) {
    spdlog::warn("{}: its colours are left out: {}", shape.id, error.message());
    return {};
  }
}

/// One axis more where there are turned copies.
void write_voxels(const render::VoxelOptions& options, const solvers::mesh::SurfaceMesh& flat,
                  const core::Hdf5Group& file) {
  const std::vector<render::VoxelGrid> grids = render::voxelize_turned(flat, options);
  const auto turns = static_cast<std::uint64_t>(grids.size());
  const auto n = static_cast<std::uint64_t>(options.resolution);
  std::vector<std::uint8_t> cells;
  std::vector<double> origins;
  for (const render::VoxelGrid& grid : grids) {
    cells.insert(cells.end(), grid.cells.begin(), grid.cells.end());
    origins.insert(origins.end(), grid.origin.begin(), grid.origin.end());
  }
  const double pitch = grids.front().pitch;
  file.write<std::uint8_t>("voxels", cells,
                           turns > 1 ? core::Extent{1, turns, n, n, n} : core::Extent{1, n, n, n},
                           {.chunk_rows = 1, .deflate = 4});
  file.write_attribute("pitch_m", pitch, "voxels");
  file.write<double>("voxel_pitch", std::vector<double>{pitch}, {1});
  file.write<double>("voxel_origin", origins,
                     turns > 1 ? core::Extent{1, turns, 3} : core::Extent{1, 3});
}

/// Materials of the mesh's regions in the first variant of a material.
std::vector<synth::material::Material> region_materials(const configuration::BuildConfig& config,
                                                        const plan::Shape& shape,
                                                        const std::string& name,
                                                        const std::vector<std::string>& regions) {
  for (const plan::Variant& variant : shape.variants) {
    if (variant.material != name) continue;
    return plan::variant_materials(config, shape, variant,
                                   regions.empty() ? std::vector<std::string>{"body"} : regions);
  }
  return {{}};
}

void write_pictures(const plan::Shape& shape, const std::string& material,
                    const std::vector<core::Image>& views, const BuildFolders& folders,
                    std::vector<std::string>& written) {
  for (std::size_t v = 0; v < views.size(); ++v) {
    const std::string name = plan::picture_name(shape, material, v);
    core::write_durably(folders.output / name, [&](const std::filesystem::path& path) {
      core::write_png(path, views[v]);
    });
    written.push_back(name);
  }
}

}  // namespace

void write_views(const configuration::BuildConfig& config, const plan::Shape& shape,
                 const solvers::mesh::TetMesh& mesh, const solvers::modes::ModeSurface& surface,
                 const BuildFolders& folders, const core::Hdf5Group& file, core::Trace& trace,
                 std::vector<std::string>& written) {
  const solvers::mesh::SurfaceMesh flat = solvers::modes::flatten(surface);
  const bool is_drawn = !config.cameras.empty() || (config.motion && config.motion->camera);
  ShapeLooks looks;
  if (is_drawn) {
    looks.colours = colours_of(config, shape, flat);
    if (mesh.region_names.size() > 1) looks.face_regions = solvers::mesh::face_regions(mesh);
  }
  write_looks(file, looks);
  if (config.voxels) {
    const core::ScopedTimer timer(trace.effects["voxels"]);
    write_voxels(*config.voxels, flat, file);
  }
  if (config.cameras.empty()) return;
  const core::ScopedTimer timer(trace.effects["frames"]);
  const std::vector<std::string> materials = plan::pictured_materials(shape);
  const core::Hdf5Group group = file.create_group("appearances");
  group.write<std::string>("material", materials, {materials.size()});
  const render::Camera& camera = config.cameras.front();
  group.create<std::uint8_t>(
      "frame",
      {materials.size(), config.cameras.size(), static_cast<std::uint64_t>(camera.height),
       static_cast<std::uint64_t>(camera.width), 3},
      {.chunk_rows = 1, .deflate = 4});
  for (std::size_t m = 0; m < materials.size(); ++m) {
    const auto of_regions = region_materials(config, shape, materials[m], mesh.region_names);
    const DrawnLooks drawn = looks_of(shape, of_regions, looks, surface);
    const std::vector<core::Image> views =
        render::render_frames(flat, config.cameras, drawn.body, drawn.faces);
    std::vector<std::uint8_t> pixels;
    for (const core::Image& view : views)
      pixels.insert(pixels.end(), view.pixels.begin(), view.pixels.end());
    group.write_rows<std::uint8_t>("frame", m, pixels);
    if (config.png) write_pictures(shape, materials[m], views, folders, written);
  }
}

}  // namespace carillon::dataset::samples
