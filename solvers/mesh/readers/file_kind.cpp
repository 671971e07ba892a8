#include "solvers/mesh/readers/file_kind.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string_view>

#include "core/error.hpp"
#include "core/files.hpp"

namespace carillon::solvers::mesh::readers {
namespace {

struct Ending {
  std::string_view ending;
  FileKind kind;
};
constexpr Ending endings[] = {
    {".obj", FileKind::surface}, {".off", FileKind::surface},    {".ply", FileKind::surface},
    {".stl", FileKind::surface}, {".msh", FileKind::tetrahedra}, {".glb", FileKind::scene},
    {".gltf", FileKind::scene},  {".dae", FileKind::scene},      {".fbx", FileKind::scene},
    {".3mf", FileKind::scene},   {".x3d", FileKind::scene},      {".step", FileKind::cad},
    {".stp", FileKind::cad},     {".iges", FileKind::cad},       {".igs", FileKind::cad},
    {".brep", FileKind::cad}};

/// How formats that are not read become one that is.
struct Conversion {
  std::string_view endings;  ///< between blanks
  const char* how;
};
constexpr Conversion conversions[] = {
    {" .blend ", "in Blender: File > Export > glTF 2.0 (.glb)"},
    {" .usd .usda .usdc .usdz .abc ",
     "in Blender: File > Import, then File > Export > glTF 2.0 (.glb)"},
    {" .sldprt .sldasm .ipt .iam .prt .catpart .catproduct .f3d .par .jt .x_t .x_b .sat .fcstd "
     ".scad ",
     "in the CAD program (FreeCAD, OpenSCAD and others): export as STEP (.step), or STL"},
    {" .3dm .skp .max .ma .mb .c4d .lwo .3ds .wrl .vrml ",
     "in the program that made it, or in Blender: export as glTF (.glb) or OBJ"},
    {" .vtk .vtu .vtp .inp .bdf .nas .unv .mesh .med .cdb .xdmf .e .exo ",
     "meshio convert FILE out.msh keeps its tetrahedra (meshio is a Python package)"},
    {" .pcd .las .laz .xyz .e57 ",
     "points are no surface: reconstruct one, in MeshLab or CloudCompare, and save it as PLY"},
    {" .dxf .dwg ", "a drawing is no solid: in the CAD program, export the solid as STEP (.step)"},
    {" .node .ele .poly ", "meshio convert FILE.ele out.msh keeps its tetrahedra"},
    {" .gz .zip .7z .xz .bz2 .tar ", "unpack it first"}};

}  // namespace

std::string mesh_extension(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

FileKind kind_of(const std::string& path) {
  const std::string extension = mesh_extension(path);
  for (const Ending& known : endings)
    if (extension == known.ending) return known.kind;
  std::string hint =
      "read are surfaces (.obj, .off, .ply, .stl), scenes (.glb, .gltf, .dae, .fbx, .3mf, .x3d), "
      "CAD "
      "(.step, .iges, .brep) and tetrahedra (.msh)";
  for (const Conversion& conversion : conversions) {
    if (!extension.empty() &&
        conversion.endings.find(" " + extension + " ") != std::string_view::npos)
      hint = conversion.how;
  }
  throw core::InputError(fmt::format("{}: {} is no kind of mesh file that is read", path,
                                     extension.empty() ? "a name without an ending" : extension),
                         hint);
}

bool has_nodes(const std::string& path) {
  const FileKind kind = kind_of(path);
  return kind == FileKind::scene || kind == FileKind::cad;
}

bool is_old_msh(const std::string& path) {
  const std::string bytes = core::read_file(path);
  const std::string_view text(bytes);
  if (text.substr(0, 64).find("$NOD") != std::string_view::npos) return true;
  constexpr std::string_view begin = "$MeshFormat";
  const auto at = text.find(begin);
  double version = 0;
  int binary = 0;
  if (at == std::string_view::npos ||
      std::sscanf(bytes.c_str() + at + begin.size(), "%lf %d", &version, &binary) != 2) {
    return false;
  }
  return version < 2 || (version >= 3 && version < 4) ||
         (version < 4.05 && binary == 1 && version >= 4);
}

std::string decoded_uri(const std::string& uri) {
  std::string text;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    const auto digit = [&](std::size_t at) {
      return at < uri.size() && std::isxdigit(static_cast<unsigned char>(uri[at])) != 0;
    };
    if (uri[i] == '%' && digit(i + 1) && digit(i + 2)) {
      text += static_cast<char>(std::stoi(uri.substr(i + 1, 2), nullptr, 16));
      i += 2;
    } else {
      text += uri[i];
    }
  }
  return text;
}

std::vector<std::string> files_of(const std::string& path, bool pictures) {
  std::vector<std::string> files = {path};
  if (mesh_extension(path) != ".gltf") return files;
  const auto scene = nlohmann::json::parse(core::read_file(path), nullptr, false);
  const auto add = [&](const char* list) {
    if (!scene.is_object() || !scene.contains(list) || !scene.at(list).is_array()) return;
    for (const auto& part : scene.at(list)) {
      if (!part.is_object() || !part.contains("uri") || !part.at("uri").is_string()) continue;
      const std::string uri = part.at("uri");
      if (uri.starts_with("data:")) continue;  // the bytes themselves
      const auto file = std::filesystem::path(path).parent_path() / decoded_uri(uri);
      std::error_code missing;
      if (std::filesystem::is_regular_file(file, missing)) files.push_back(file.string());
    }
  };
  add("buffers");
  if (pictures) add("images");
  return files;
}

}  // namespace carillon::solvers::mesh::readers
