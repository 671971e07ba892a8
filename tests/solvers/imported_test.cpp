// Scenes and CAD files as solvers/mesh/imported reads them; their formats one by one are
// tests/end_to_end/mesh_formats.py.
#include <fmt/format.h>
#include <gmsh.h>
#include <gtest/gtest.h>
#include <turbojpeg.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>
#include <numbers>
#include <string_view>

#include "core/base64.hpp"
#include "core/error.hpp"
#include "core/image.hpp"
#include "core/temporary_folder.hpp"
#include "solvers/mesh/imported/import_file.hpp"
#include "solvers/mesh/readers/read_mesh.hpp"
#include "solvers/mesh/repair/repair.hpp"
#include "solvers/mesher/file_contents.hpp"

namespace carillon::solvers::mesh::imported {
namespace {

constexpr double pi = std::numbers::pi;

class CadTest : public ::testing::Test {
 protected:
  /// Writes a plate 80 x 40 x 10 mm with a bore of 12 mm, and beside it a ball of 15 mm.
  std::string written(const std::string& name) const {
    const std::string path = (folder_ / name).string();
    gmsh::initialize(0, nullptr, false);
    gmsh::option::setNumber("General.Terminal", 0);
    gmsh::model::add("parts");
    const int plate = gmsh::model::occ::addBox(0, 0, 0, 80, 40, 10);
    const int bore = gmsh::model::occ::addCylinder(40, 20, -1, 0, 0, 12, 6);
    std::vector<std::pair<int, int>> made;
    std::vector<std::vector<std::pair<int, int>>> map;
    gmsh::model::occ::cut({{3, plate}}, {{3, bore}}, made, map);
    gmsh::model::occ::addSphere(150, 0, 0, 15);
    gmsh::model::occ::synchronize();
    gmsh::write(path);
    gmsh::finalize();
    return path;
  }

  core::TemporaryFolder folder_;
};

TEST_F(CadTest, SolidsAreNodesInMillimetres) {
  const double plate = 80 * 40 * 10 - pi * 36 * 10, ball = 4.0 / 3 * pi * std::pow(15, 3);
  std::filesystem::copy_file(written("parts.step"), folder_ / "copy.STP");
  for (const char* name : {"parts.step", "parts.brep", "copy.STP"}) {
    if (std::string_view(name) == "parts.brep") written(name);
    const ImportedFile file = import_file((folder_ / name).string());
    ASSERT_EQ(file.nodes.size(), 2u) << name;
    EXPECT_EQ(file.unit, 1e-3);
    std::vector<double> volumes;
    for (const ImportedNode& node : file.nodes) {
      const Diagnosis diagnosis = repair::diagnose(node.surface);
      EXPECT_TRUE(diagnosis.clean) << name << " " << node.name;
      volumes.push_back(signed_volume(node.surface));
    }
    std::sort(volumes.begin(), volumes.end());
    // 40 edges to a turn leave 0.4 % of a disc and twice that of a ball.
    EXPECT_NEAR(volumes[0] / ball, 1, 0.01) << name;
    EXPECT_NEAR(volumes[1] / plate, 1, 0.002) << name;
    EXPECT_NE(file.nodes[0].name, file.nodes[1].name);
  }
}

/// A line of an IGES file: 72 columns, a section's letter and the line's number in it.
std::string iges_line(const std::string& text, char section, int number) {
  return fmt::format("{:<72}{}{:>7}\n", text, section, number);
}

/// Six flat B-spline patches that bound a block, in inches.
std::string iges_block(const std::array<double, 3>& sides) {
  std::string directory, parameters;
  int entry = 1, line = 1;
  for (int axis = 0; axis < 3; ++axis) {
    for (const double at : {0.0, sides[static_cast<std::size_t>(axis)]}) {
      std::vector<std::string> words = {"128", "1",  "1",  "1",  "1",  "0",  "0",  "1",
                                        "0",   "0",  "0.", "0.", "1.", "1.", "0.", "0.",
                                        "1.",  "1.", "1.", "1.", "1.", "1."};
      for (const auto& [u, v] : {std::pair(0, 0), {1, 0}, {0, 1}, {1, 1}}) {
        std::array<double, 3> point{};
        const auto one = static_cast<std::size_t>((axis + 1) % 3);
        const auto other = static_cast<std::size_t>((axis + 2) % 3);
        point[static_cast<std::size_t>(axis)] = at;
        point[one] = u * sides[one];
        point[other] = v * sides[other];
        for (const double c : point) words.push_back(fmt::format("{:.6f}", c));
      }
      for (const char* end : {"0.", "1.", "0.", "1."}) words.push_back(end);
      std::vector<std::string> lines(1);
      for (std::size_t i = 0; i < words.size(); ++i) {
        const std::string word = words[i] + (i + 1 < words.size() ? "," : ";");
        if (lines.back().size() + word.size() > 64) lines.emplace_back();
        lines.back() += word;
      }
      directory += iges_line(fmt::format("{:>8}{:>8}{:>8}{:>8}{:>8}{:>8}{:>8}{:>8}{:>8}", 128, line,
                                         0, 0, 0, 0, 0, 0, "00000000"),
                             'D', entry);
      directory += iges_line(fmt::format("{:>8}{:>8}{:>8}{:>8}{:>8}", 128, 0, 0, lines.size(), 0),
                             'D', entry + 1);
      for (const std::string& text : lines)
        parameters += iges_line(fmt::format("{:<64}{:>8}", text, entry), 'P', line++);
      entry += 2;
    }
  }
  return iges_line("", 'S', 1) +
         iges_line("1H,,1H;,4Hpart,4Hpart,4Htest,1H1,32,38,6,308,15,4Hpart,1.,1,2HIN,1,0.1,", 'G',
                   1) +
         iges_line("15H20260101.000000,1.E-6,10.,4Htest,4Htest,11,0;", 'G', 2) + directory +
         parameters +
         iges_line(fmt::format("S{:>7}G{:>7}D{:>7}P{:>7}", 1, 2, entry - 1, line - 1), 'T', 1);
}

TEST_F(CadTest, FacesOfIgesAreSewnToASolidInTheFilesUnit) {
  const std::string path = (folder_ / "block.igs").string();
  std::ofstream(path) << iges_block({3, 2, 1});
  const ImportedFile file = import_file(path);
  const SurfaceMesh whole = node_surface(file, path, "");
  EXPECT_TRUE(repair::diagnose(whole).closed);
  const double volume = 6 * std::pow(0.0254, 3);
  EXPECT_NEAR(std::abs(signed_volume(whole)) * std::pow(file.unit, 3) / volume, 1, 1e-6);
}

TEST_F(CadTest, CornersStayCorners) {
  const ImportedFile file = import_file(written("parts.step"));
  const SurfaceMesh whole = node_surface(file, "parts.step", "");
  for (const Vec3& corner : {Vec3(0, 0, 0), Vec3(80, 40, 10), Vec3(80, 0, 10)}) {
    const bool is_there = std::any_of(whole.vertices.begin(), whole.vertices.end(),
                                      [&](const Vec3& v) { return (v - corner).norm() < 1e-6; });
    EXPECT_TRUE(is_there) << corner.transpose();
  }
}

TEST_F(CadTest, NoSolidIsAnInputError) {
  const std::string path = (folder_ / "empty.step").string();
  std::ofstream(path) << "ISO-10303-21;\nHEADER;\nENDSEC;\nDATA;\nENDSEC;\nEND-ISO-10303-21;\n";
  EXPECT_THROW(import_file(path), core::InputError);
}

/// A square in x and y, of side 2, with a base colour texture (u along x, v along -y as glTF has
/// it: from the upper edge down), corners' colours if wanted.
std::string textured_square(const core::TemporaryFolder& folder, const std::string& picture,
                            const char* kind) {
  const std::array<float, 12> points = {0, 0, 0, 2, 0, 0, 2, 2, 0, 0, 2, 0};
  const std::array<float, 8> places = {0, 1, 1, 1, 1, 0, 0, 0};
  const std::array<std::uint16_t, 6> corners = {0, 1, 2, 0, 2, 3};
  std::string data;
  const auto add = [&data](const auto& values) {
    data.append(reinterpret_cast<const char*>(values.data()), sizeof values);
  };
  add(points);
  add(places);
  add(corners);
  const std::string path = (folder / "square.gltf").string();
  std::ofstream(path) << fmt::format(
      R"({{"asset": {{"version": "2.0"}}, "scene": 0, "scenes": [{{"nodes": [0]}}],
"nodes": [{{"mesh": 0, "name": "Square"}}],
"meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0, "TEXCOORD_0": 1}}, "indices": 2, "material": 0}}]}}],
"materials": [{{"pbrMetallicRoughness": {{"baseColorTexture": {{"index": 0}}, "baseColorFactor": [1, 0.5, 1, 1]}}}}],
"textures": [{{"source": 0}}], "images": [{{"uri": "data:image/{2};base64,{1}"}}],
"buffers": [{{"byteLength": 92, "uri": "data:application/octet-stream;base64,{0}"}}],
"bufferViews": [{{"buffer": 0, "byteLength": 48}}, {{"buffer": 0, "byteOffset": 48, "byteLength": 32}},
{{"buffer": 0, "byteOffset": 80, "byteLength": 12}}],
"accessors": [{{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0, 0, 0], "max": [2, 2, 0]}},
{{"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2"}},
{{"bufferView": 2, "componentType": 5123, "count": 6, "type": "SCALAR"}}]}})",
      core::base64(data), core::base64(picture), kind);
  return path;
}

/// Red, green above blue, white: the upper row first.
const core::Image four_colours{2, 2, 3, {255, 0, 0, 0, 255, 0, 0, 0, 255, 255, 255, 255}};

/// Colours at the middles of the picture's quarters, in the same order.
std::vector<Vec3> quarters(const std::string& path) {
  const ImportedFile file = import_file(path, true);
  const SurfaceMesh surface = node_surface(file, path, "Square");
  const Paint paint = node_paint(file, "Square");
  EXPECT_TRUE(paint.shows());
  // y of the file is z here.
  const std::vector<Vec3> middles = {{0.5, 0, 1.5}, {1.5, 0, 1.5}, {0.5, 0, 0.5}, {1.5, 0, 0.5}};
  return colours_at(surface, paint, middles);
}

TEST(Paint, TextureLiesTheRightWayUpAndIsMultipliedByTheFactor) {
  const core::TemporaryFolder folder;
  const auto colours =
      quarters(textured_square(folder, core::png_bytes("square", four_colours), "png"));
  const std::vector<Vec3> expected = {{1, 0, 0}, {0, 0.5, 0}, {0, 0, 1}, {1, 0.5, 1}};
  for (std::size_t i = 0; i < 4; ++i)
    EXPECT_LT((colours[i] - expected[i]).norm(), 1e-6) << i << ": " << colours[i].transpose();
}

TEST(Paint, JpegIsReadToo) {
  // Eight pixels of each colour: smaller ones blur in the format.
  core::Image large{16, 16, 3, {}};
  for (int row = 0; row < 16; ++row)
    for (int column = 0; column < 16; ++column)
      for (int c = 0; c < 3; ++c)
        large.pixels.push_back(
            four_colours.pixels[static_cast<std::size_t>(3 * (2 * (row / 8) + column / 8) + c)]);
  const std::unique_ptr<void, int (*)(tjhandle)> writer(tjInitCompress(), tjDestroy);
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  ASSERT_EQ(tjCompress2(writer.get(), large.pixels.data(), 16, 0, 16, TJPF_RGB, &bytes, &size,
                        TJSAMP_444, 95, 0),
            0);
  const std::string picture(reinterpret_cast<const char*>(bytes), size);
  tjFree(bytes);
  const core::TemporaryFolder folder;
  const auto colours = quarters(textured_square(folder, picture, "jpeg"));
  const std::vector<Vec3> expected = {{1, 0, 0}, {0, 0.5, 0}, {0, 0, 1}, {1, 0.5, 1}};
  for (std::size_t i = 0; i < 4; ++i)
    EXPECT_LT((colours[i] - expected[i]).norm(), 0.05) << i << ": " << colours[i].transpose();
}

TEST(Paint, MeansBetweenPixelsAreOfLinearLight) {
  const core::TemporaryFolder folder;
  const core::Image grey{2, 1, 3, {0, 0, 0, 255, 255, 255}};
  const std::string path = textured_square(folder, core::png_bytes("square", grey), "png");
  const ImportedFile file = import_file(path, true);
  const auto colours =
      colours_at(node_surface(file, path, ""), node_paint(file, ""), std::vector<Vec3>{{1, 0, 1}});
  EXPECT_NEAR(colours[0].x(), 0.5, 1e-6);
}

TEST(FileContents, AFileThatCannotBeReadHasItsReasonAndSparesTheOthers) {
  const core::TemporaryFolder folder;
  const std::string good = textured_square(folder, core::png_bytes("s", four_colours), "png");
  const std::string bad = (folder / "bad.glb").string();
  std::ofstream(bad) << "glTF";
  const auto contents = mesher::read_contents({bad, good, (folder / "none.glb").string()}, {});
  ASSERT_EQ(contents.size(), 3u);
  EXPECT_NE(contents[0].error.find("bad.glb"), std::string::npos);
  EXPECT_EQ(contents[1].error, "");
  ASSERT_EQ(contents[1].nodes.size(), 1u);
  EXPECT_EQ(contents[1].nodes[0].name, "Square");
  EXPECT_NEAR(contents[1].whole.area, 4, 1e-9);
  EXPECT_NE(contents[2].error, "");
}

}  // namespace
}  // namespace carillon::solvers::mesh::imported
