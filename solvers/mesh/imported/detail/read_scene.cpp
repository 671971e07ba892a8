#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/core.h>

#include <assimp/DefaultIOSystem.h>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <assimp/Importer.hpp>
#include <filesystem>
#include <map>

#include "core/error.hpp"
#include "core/files.hpp"
#include "solvers/mesh/imported/detail/formats.hpp"
#include "solvers/mesh/imported/detail/read_picture.hpp"
#include "solvers/mesh/readers/file_kind.hpp"
#include "solvers/mesh/weld.hpp"

namespace carillon::solvers::mesh::imported {

namespace {

using Transform = Eigen::Matrix4d;

Transform transform_of(const aiMatrix4x4& m) {
  Transform transform;
  transform << m.a1, m.a2, m.a3, m.a4, m.b1, m.b2, m.b3, m.b4, m.c1, m.c2, m.c3, m.c4, m.d1, m.d2,
      m.d3, m.d4;
  return transform;
}

/// The unit and the upright of what Assimp hands out.
struct Convention {
  double unit = 1;       ///< of the file [m]
  double handed_in = 1;  ///< unit of the coordinates as they are handed out [m]
  Up up = Up::y;
};

Convention convention_of(const std::string& path, const aiScene& scene) {
  const std::string extension = readers::mesh_extension(path);
  if (extension == ".fbx") {
    // Lengths are left as they are, and so are the axes.
    double centimetres = 1;
    int axis = 1;
    if (scene.mMetaData != nullptr) {
      scene.mMetaData->Get("UpAxis", axis);
      float single = 1;
      if (!scene.mMetaData->Get("UnitScaleFactor", centimetres) &&
          scene.mMetaData->Get("UnitScaleFactor", single)) {
        centimetres = single;
      }
    }
    const double unit = centimetres > 0 ? centimetres / 100 : 0.01;
    return {unit, unit, axis == 0 ? Up::x : axis == 2 ? Up::z : Up::y};
  }
  if (extension == ".dae") return {unit_in_xml(path, extension), 1, Up::y};  // turned and scaled
  if (extension == ".x3d" || extension == ".3mf") {
    const double unit = unit_in_xml(path, extension);
    return {unit, unit, extension == ".3mf" ? Up::z : Up::y};
  }
  return {};  // glTF: metres, y
}

Transform upright(const Convention& convention) {
  Transform turn = Transform::Identity();
  if (convention.up == Up::y) turn.topRows<3>() << 1, 0, 0, 0, 0, 0, -1, 0, 0, 1, 0, 0;
  if (convention.up == Up::x) turn.topRows<3>() << 0, 0, -1, 0, 0, 1, 0, 0, 1, 0, 0, 0;
  turn.topRows<3>() *= convention.handed_in / convention.unit;
  return turn;
}

/// Base colours of a scene's materials.
class Coats {
 public:
  Coats(const std::string& path, const aiScene& scene) : path_(path), scene_(scene) {}

  Paint::Coat of(unsigned number) {
    const aiMaterial& material = *scene_.mMaterials[number];
    Paint::Coat coat;
    aiColor4D colour;
    if (material.Get(AI_MATKEY_BASE_COLOR, colour) == AI_SUCCESS ||
        material.Get(AI_MATKEY_COLOR_DIFFUSE, colour) == AI_SUCCESS) {
      coat.colour = {colour.r, colour.g, colour.b};
    }
    if (const Texture texture = texture_of(number); !texture.name.empty())
      coat.picture = picture(texture.name);
    return coat;
  }

  /// Set of texture coordinates that the picture is laid on by.
  unsigned places_of(unsigned number) const { return texture_of(number).places; }

 private:
  /// What a material has its base colour in; no name where there is no picture.
  struct Texture {
    std::string name;
    unsigned places = 0;
  };
  Texture texture_of(unsigned number) const {
    const aiMaterial& material = *scene_.mMaterials[number];
    for (const aiTextureType type : {aiTextureType_BASE_COLOR, aiTextureType_DIFFUSE}) {
      if (material.GetTextureCount(type) == 0) continue;
      aiString name;
      unsigned places = 0;
      material.GetTexture(type, 0, &name, nullptr, &places);
      return {name.C_Str(), places};
    }
    return {};
  }

  std::shared_ptr<const core::Image> picture(const std::string& name) {
    if (const auto found = pictures_.find(name); found != pictures_.end()) return found->second;
    std::string bytes;
    const aiTexture* texture = scene_.GetEmbeddedTexture(name.c_str());
    if (texture != nullptr && texture->mHeight != 0) {
      throw core::InputError(fmt::format("{}: the picture {} is not compressed", path_, name));
    }
    if (texture != nullptr) {
      bytes.assign(reinterpret_cast<const char*>(texture->pcData), texture->mWidth);
    } else {
      const std::filesystem::path folder = std::filesystem::path(path_).parent_path();
      std::error_code missing;
      const bool as_named = std::filesystem::exists(folder / name, missing);
      bytes = core::read_file(folder / (as_named ? name : readers::decoded_uri(name)));
    }
    const auto image = std::make_shared<const core::Image>(
        read_picture(fmt::format("{}, picture {}", path_, name), bytes));
    return pictures_.emplace(name, image).first->second;
  }

  const std::string& path_;
  const aiScene& scene_;
  std::map<std::string, std::shared_ptr<const core::Image>> pictures_;
};

void add_mesh(const aiMesh& mesh, const Transform& transform, ImportedNode& node) {
  const auto first = static_cast<std::int32_t>(node.surface.vertices.size());
  for (unsigned v = 0; v < mesh.mNumVertices; ++v) {
    const aiVector3D& p = mesh.mVertices[v];
    const Vec3 placed =
        (transform * Eigen::Vector4d(double{p.x}, double{p.y}, double{p.z}, 1)).head<3>();
    node.surface.vertices.push_back(placed);
  }
  // A mirror turns the faces over.
  const bool mirrored = transform.topLeftCorner<3, 3>().determinant() < 0;
  for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
    const aiFace& face = mesh.mFaces[f];
    if (face.mNumIndices != 3) continue;  // a point or a line
    Triangle triangle;
    for (unsigned i = 0; i < 3; ++i)
      triangle[i] = first + static_cast<std::int32_t>(face.mIndices[mirrored ? 2 - i : i]);
    node.surface.triangles.push_back(triangle);
  }
}

void add_paint(const aiMesh& mesh, unsigned places, Paint::Coat coat, bool mirrored, Paint& paint) {
  paint.coats.push_back(std::move(coat));
  for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
    const aiFace& face = mesh.mFaces[f];
    if (face.mNumIndices != 3) continue;
    Paint::Face painted;
    painted.coat = paint.coats.size() - 1;
    for (unsigned i = 0; i < 3; ++i) {
      const unsigned vertex = face.mIndices[mirrored ? 2 - i : i];
      painted.colours[i] = Vec3::Ones();
      if (mesh.HasVertexColors(0)) {
        const aiColor4D& colour = mesh.mColors[0][vertex];
        painted.colours[i] = {colour.r, colour.g, colour.b};
      }
      if (places < AI_MAX_NUMBER_OF_TEXTURECOORDS && mesh.HasTextureCoords(places)) {
        // Assimp counts from the lower left corner.
        const aiVector3D& place = mesh.mTextureCoords[places][vertex];
        painted.places[i] = {place.x, 1 - double{place.y}};
      }
    }
    paint.faces.push_back(painted);
  }
}

/// Files beside a scene, by names that may be percent-encoded.
class FilesByUri : public Assimp::DefaultIOSystem {
 public:
  bool Exists(const char* name) const override {
    return Assimp::DefaultIOSystem::Exists(name) ||
           Assimp::DefaultIOSystem::Exists(readers::decoded_uri(name).c_str());
  }
  Assimp::IOStream* Open(const char* name, const char* mode) override {
    Assimp::IOStream* file = Assimp::DefaultIOSystem::Open(name, mode);
    return file != nullptr
               ? file
               : Assimp::DefaultIOSystem::Open(readers::decoded_uri(name).c_str(), mode);
  }
};

class SceneReader {
 public:
  SceneReader(const aiScene& scene, Coats* coats, ImportedFile& file)
      : scene_(scene), coats_(coats), file_(file) {}

  void read(const aiNode& node, const Transform& above) {
    const Transform transform = above * transform_of(node.mTransformation);
    ImportedNode imported;
    const bool mirrored = transform.topLeftCorner<3, 3>().determinant() < 0;
    for (unsigned m = 0; m < node.mNumMeshes; ++m) {
      const aiMesh& mesh = *scene_.mMeshes[node.mMeshes[m]];
      add_mesh(mesh, transform, imported);
      if (coats_ != nullptr)
        add_paint(mesh, coats_->places_of(mesh.mMaterialIndex), coats_->of(mesh.mMaterialIndex),
                  mirrored, imported.paint);
    }
    if (!imported.surface.triangles.empty()) {
      imported.name = node.mName.C_Str();
      if (imported.name.empty()) imported.name = scene_.mMeshes[node.mMeshes[0]]->mName.C_Str();
      weld(imported.surface);
      drop_unreferenced(imported.surface);
      file_.nodes.push_back(std::move(imported));
    }
    for (unsigned c = 0; c < node.mNumChildren; ++c) read(*node.mChildren[c], transform);
  }

 private:
  const aiScene& scene_;
  Coats* coats_;
  ImportedFile& file_;
};

}  // namespace

ImportedFile read_scene(const std::string& path, bool paint) {
  core::read_file(path);  // says why, where it cannot be read
  Assimp::Importer importer;
  importer.SetIOHandler(new FilesByUri);  // the importer's own from here on
  importer.SetPropertyBool(AI_CONFIG_IMPORT_FBX_PRESERVE_PIVOTS, false);
  unsigned steps = aiProcess_Triangulate;
  if (paint) steps |= aiProcess_TransformUVCoords;
  const aiScene* scene = importer.ReadFile(path, steps);
  if (scene == nullptr || scene->mRootNode == nullptr) {
    throw core::InputError(
        fmt::format("{}: cannot be read: {}", path, importer.GetErrorString()),
        "open it in a modeller such as Blender and export it as glTF (.glb) or STL");
  }
  const Convention convention = convention_of(path, *scene);
  ImportedFile file;
  file.unit = convention.unit;
  Coats coats(path, *scene);
  SceneReader(*scene, paint ? &coats : nullptr, file).read(*scene->mRootNode, upright(convention));
  return file;
}

}  // namespace carillon::solvers::mesh::imported
