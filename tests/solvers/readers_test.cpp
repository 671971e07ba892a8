// Surface readers: small files by hand, then the same body through every format.
#include <fmt/core.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <random>

#include "core/error.hpp"
#include "core/temporary_folder.hpp"
#include "solvers/mesh/readers/detail/polygon_mesh.hpp"
#include "solvers/mesh/readers/detail/read_formats.hpp"
#include "solvers/mesh/readers/read_mesh.hpp"
#include "tests/solvers/written_files.hpp"

namespace carillon::solvers {
namespace {

using core::InputError;
using test::message_of;

std::string error_of(mesh::readers::PolygonMesh (*read)(const std::string&, std::string_view),
                     std::string_view bytes) {
  return message_of<InputError>([&] { read("mesh", bytes); });
}

/// Corners of the unit cube and its six faces, counter-clockwise from outside.
constexpr double cube_vertices[8][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0},
                                        {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}};
constexpr int cube_faces[6][4] = {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4},
                                  {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}};

template <class T>
void append(std::string& bytes, T value, bool swap = false) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  if (swap) std::reverse(raw, raw + sizeof(T));
  bytes.append(raw, sizeof(T));
}

std::string cube_obj() {
  std::string text = "# cube\no cube\n";
  for (const auto& v : cube_vertices) text += fmt::format("v {} {} {}\n", v[0], v[1], v[2]);
  for (const auto& f : cube_faces) {
    text += fmt::format("f {} {} {} {}\n", f[0] + 1, f[1] + 1, f[2] + 1, f[3] + 1);
  }
  return text;
}

std::string cube_off() {
  std::string text = "OFF\n8 6 12\n";
  for (const auto& v : cube_vertices) text += fmt::format("{} {} {}\n", v[0], v[1], v[2]);
  for (const auto& f : cube_faces) text += fmt::format("4 {} {} {} {}\n", f[0], f[1], f[2], f[3]);
  return text;
}

std::string cube_ply(const std::string& encoding) {
  std::string bytes = "ply\nformat " + encoding + " 1.0\ncomment a cube\n";
  bytes += "element vertex 8\nproperty uchar red\nproperty double x\nproperty float y\n";
  bytes += "property double z\nproperty list uchar short extra\n";
  bytes += "element face 6\nproperty float quality\nproperty list uint8 int32 vertex_index\n";
  bytes += "element edge 1\nproperty int vertex1\nend_header\n";
  const bool swap = encoding == "binary_big_endian";
  for (const auto& v : cube_vertices) {
    if (encoding == "ascii") {
      bytes += fmt::format("7 {} {} {} 2 5 6\n", v[0], v[1], v[2]);
      continue;
    }
    append(bytes, std::uint8_t{7}, swap);
    append(bytes, v[0], swap);
    append(bytes, static_cast<float>(v[1]), swap);
    append(bytes, v[2], swap);
    append(bytes, std::uint8_t{2}, swap);
    append(bytes, std::int16_t{5}, swap);
    append(bytes, std::int16_t{6}, swap);
  }
  for (const auto& f : cube_faces) {
    if (encoding == "ascii") {
      bytes += fmt::format("nan 4 {} {} {} {}\n", f[0], f[1], f[2], f[3]);
      continue;
    }
    append(bytes, std::nanf(""), swap);
    append(bytes, std::uint8_t{4}, swap);
    for (const int i : f) append(bytes, std::int32_t{i}, swap);
  }
  if (encoding == "ascii") {
    bytes += "0\n";
  } else {
    append(bytes, std::int32_t{0}, swap);
  }
  return bytes;
}

std::string cube_stl(bool binary, const std::string& header = "solid cube") {
  std::string bytes = binary ? header + std::string(80 - header.size(), '\0') : header + "\n";
  if (binary) append(bytes, std::uint32_t{12});
  for (const auto& f : cube_faces) {
    for (const auto& t : {std::array{f[0], f[1], f[2]}, std::array{f[0], f[2], f[3]}}) {
      if (!binary) bytes += "facet normal 0 0 0\n outer loop\n";
      for (int k = 0; binary && k < 3; ++k) append(bytes, 0.0f);
      for (const int i : t) {
        const auto& v = cube_vertices[i];
        if (!binary) bytes += fmt::format("  vertex {} {} {}\n", v[0], v[1], v[2]);
        for (int k = 0; binary && k < 3; ++k) append(bytes, static_cast<float>(v[k]));
      }
      if (!binary) bytes += " endloop\nendfacet\n";
      if (binary) append(bytes, std::uint16_t{0});
    }
  }
  return binary ? bytes : bytes + "endsolid\n";
}

void expect_cube(const mesh::SurfaceMesh& mesh) {
  EXPECT_EQ(mesh.vertices.size(), 8u);
  EXPECT_EQ(mesh.triangles.size(), 12u);
  EXPECT_NEAR(mesh::signed_volume(mesh), 1, 1e-15);
  EXPECT_NEAR(mesh::area(mesh), 6, 1e-15);
}

TEST(ReadSurface, GivesTheSameCubeFromEveryFormat) {
  const core::TemporaryFolder folder;
  expect_cube(mesh::readers::read_surface(test::written(folder, "cube.obj", cube_obj())));
  expect_cube(mesh::readers::read_surface(test::written(folder, "cube.OFF", cube_off())));
  for (const char* encoding : {"ascii", "binary_little_endian", "binary_big_endian"}) {
    SCOPED_TRACE(encoding);
    expect_cube(mesh::readers::read_surface(test::written(folder, "cube.ply", cube_ply(encoding))));
  }
  expect_cube(mesh::readers::read_surface(test::written(folder, "ascii.stl", cube_stl(false))));
  expect_cube(mesh::readers::read_surface(
      test::written(folder, "binary.stl", cube_stl(true, "made by hand"))));
}

TEST(ReadSurface, RefusesUnknownEndingsAndMissingFiles) {
  const core::TemporaryFolder folder;
  const auto refusal = [&](const char* name) {
    const std::string path = test::written(folder, name, "x");
    return message_of<InputError>([&] { mesh::readers::read_surface(path); });
  };
  EXPECT_NE(refusal("cube.unknown").find(".obj"), std::string::npos);
  EXPECT_NE(refusal("cube.3ds").find("export as glTF"), std::string::npos);
  EXPECT_NE(refusal("cube.glb").find("no triangles of its own"), std::string::npos);
  EXPECT_THROW(mesh::readers::read_surface((folder.path() / "none.obj").string()), core::FileError);
  const std::string points = test::written(folder, "points.obj", "v 0 0 0\n");
  EXPECT_NE(message_of<InputError>([&] { mesh::readers::read_surface(points); }).find("no faces"),
            std::string::npos);
}

TEST(ReadObj, UnderstandsEverySpellingOfAFace) {
  const char* text =
      "\xEF\xBB\xBF# comment\r\nv 0 0 0 0.5 0.5 0.5\r\nv 1 0 \\\r\n 0\r\nv +1.0 1e0 0 # here\r\n"
      "v 0 1 0\r\nvt 0 0\r\nvn 0 0 1\r\nusemtl glass\r\ng a b\r\ns 1\r\nl 1 2\r\n"
      "f 1/1/1 2//1 3/1\r\nf -4 -2 -1\r\n";
  const mesh::SurfaceMesh mesh = mesh::readers::triangulate(mesh::readers::read_obj("mesh", text));
  ASSERT_EQ(mesh.triangles.size(), 2u);
  EXPECT_EQ(mesh.triangles[0], (mesh::Triangle{0, 1, 2}));
  EXPECT_EQ(mesh.triangles[1], (mesh::Triangle{0, 2, 3}));
  EXPECT_EQ(mesh.vertices[1], Vec3(1, 0, 0));
}

TEST(ReadObj, NamesFileAndLineOfWhatIsWrong) {
  const std::string vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  EXPECT_NE(error_of(mesh::readers::read_obj, vertices + "\nf 1 2 4\n").find("mesh:5: "),
            std::string::npos);
  EXPECT_NE(error_of(mesh::readers::read_obj, vertices + "f 1 2 0\n").find("counts from 1"),
            std::string::npos);
  EXPECT_NE(error_of(mesh::readers::read_obj, vertices + "f -1 -2 -4\n").find("mesh:4: "),
            std::string::npos);
  EXPECT_NE(error_of(mesh::readers::read_obj, vertices + "f 1 2\n").find("three"),
            std::string::npos);
  EXPECT_NE(error_of(mesh::readers::read_obj, "v 0 0\n").find("mesh:1: "), std::string::npos);
  EXPECT_NE(error_of(mesh::readers::read_obj, "v 0 0 zero\n").find("\"zero\""), std::string::npos);
  for (const char* bad : {"nan", "1e999", "-inf"}) {
    // A vertex that a face uses; others do not count.
    const auto read = [&](const std::string& face) {
      return mesh::readers::triangulate(
          mesh::readers::read_obj("mesh", fmt::format("{}v 0 0 {}\n{}", vertices, bad, face)));
    };
    EXPECT_NE(message_of<InputError>([&] { read("f 1 2 4\n"); }).find("mesh:4: vertex 4"),
              std::string::npos);
    EXPECT_EQ(read("f 1 2 3\n").vertices.size(), 3u);
  }
  EXPECT_EQ(mesh::readers::read_obj("mesh", "v 0 0 1e-400\n").vertices[0].z(), 0);
}

TEST(ReadOff, UnderstandsBrokenAndExtendedHeaders) {
  const std::string body = " # edges\n0 0 0\n1 0 0\n\n# c\n0 1 0\n3 0 1 2\n";
  for (const std::string header : {"OFF\n3 1 0", "OFF 3 1 0", "OFF3 1 0", "OFF # x\n\n3 1",
                                   "COFF\n3 1 0", "NOFF\n3 1 0", "STOFF\n3 1 0"}) {
    SCOPED_TRACE(header);
    EXPECT_EQ(mesh::readers::read_off("mesh", header + body).corners,
              (std::vector<std::int32_t>{0, 1, 2}));
  }
  const mesh::readers::PolygonMesh coloured = mesh::readers::read_off(
      "mesh", "COFF\n3 1 0\n0 0 0 255 0 0 1\n1 0 0 1 1 1 1\n0 1 0 0 0 0 0\n3 2 1 0 0.5 0.5 0.5\n");
  EXPECT_EQ(coloured.corners, (std::vector<std::int32_t>{2, 1, 0}));
}

TEST(ReadOff, RefusesWhatDoesNotFitItsCounts) {
  EXPECT_NE(error_of(mesh::readers::read_off, "").find("OFF"), std::string::npos);
  EXPECT_NE(error_of(mesh::readers::read_off, "PLY\n").find("\"OFF\""), std::string::npos);
  EXPECT_NE(error_of(mesh::readers::read_off, "4OFF\n1 1 1\n").find("four"), std::string::npos);
  EXPECT_NE(error_of(mesh::readers::read_off, "OFF BINARY\n1 1 1\n").find("binary"),
            std::string::npos);
  EXPECT_NE(error_of(mesh::readers::read_off, "OFF\n-1 1 1\n").find("negative"), std::string::npos);
  const std::string three = "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n";
  EXPECT_NE(error_of(mesh::readers::read_off, three).find("after 0 of 1 faces"), std::string::npos);
  EXPECT_NE(error_of(mesh::readers::read_off, three + "3 0 1 3\n").find("mesh:6: "),
            std::string::npos);
  EXPECT_NE(error_of(mesh::readers::read_off, three + "4 0 1 2\n").find("4 corners"),
            std::string::npos);
  // A header that lies about a thousand million vertices costs nothing.
  EXPECT_NE(error_of(mesh::readers::read_off, "OFF\n2000000000 1 0\n0 0 0\n").find("after 1 of"),
            std::string::npos);
}

TEST(ReadOff, LetsLinesEndAnywhere) {
  const std::string numbers =
      "8 12 0 0 0 0 1 0 0 0 1 0 1 1 0 0 0 1 1 0 1 0 1 1 1 1 1 3 0 2 3 3 0 3 1 3 4 5 7 3 4 7 6 3 0 "
      "1 5 "
      "3 0 5 4 3 2 6 7 3 2 7 3 3 0 4 6 3 0 6 2 3 1 3 7 3 1 7 5";
  for (std::size_t width = 1; width < 12; ++width) {
    std::string text = "OFF";
    std::istringstream words(numbers);
    std::size_t n = 0;
    for (std::string word; words >> word;) text += (n++ % width == 0 ? "\n" : " ") + word;
    const mesh::SurfaceMesh cube =
        mesh::readers::triangulate(mesh::readers::read_off("mesh", text));
    EXPECT_NEAR(mesh::signed_volume(cube), 1, 1e-15) << width;
  }
  // What follows the last face belongs nowhere.
  EXPECT_NE(error_of(mesh::readers::read_off, "OFF\n3 1 0\n0 0 0 1 0 0\n0 1 0\n3 0 1 2 0 9\n"), "");
}

TEST(ReadSurface, KnowsTextByItsByteOrderMark) {
  const core::TemporaryFolder folder;
  const auto wide = [](const std::string& text, bool low_first) {
    std::string bytes = low_first ? "\xFF\xFE" : "\xFE\xFF";
    for (const char c : text) {
      bytes += low_first ? c : '\0';
      bytes += low_first ? '\0' : c;
    }
    return bytes;
  };
  for (const auto& [name, text] : {std::pair<std::string, std::string>("cube.obj", cube_obj()),
                                   {"cube.off", cube_off()},
                                   {"cube.ply", cube_ply("ascii")},
                                   {"cube.stl", cube_stl(false)}}) {
    SCOPED_TRACE(name);
    for (const std::string& bytes : {"\xEF\xBB\xBF" + text, wide(text, true), wide(text, false)})
      expect_cube(mesh::readers::read_surface(test::written(folder, name, bytes)));
  }
}

TEST(ReadPly, ReadsStripsOfTriangles) {
  const mesh::readers::PolygonMesh strips = mesh::readers::read_ply(
      "mesh",
      "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\n"
      "property float z\nelement tristrips 1\nproperty list int int vertex_indices\nend_header\n"
      "0 0 0\n0 1 0\n1 0 0\n1 1 0\n2 0 0\n8 0 2 1 3 -1 2 4 3\n");
  EXPECT_EQ(strips.corners, (std::vector<std::int32_t>{0, 2, 1, 1, 2, 3, 2, 4, 3}));
  EXPECT_EQ(strips.ends.size(), 3u);
}

TEST(ReadPly, RefusesWhatItCannotRead) {
  const std::string head = "ply\nformat ascii 1.0\n";
  const std::string xyz =
      "element vertex 1\nproperty float x\nproperty float y\nproperty float z\n";
  const std::string face = "element face 1\nproperty list uchar int vertex_indices\n";
  EXPECT_NE(error_of(mesh::readers::read_ply, "plx").find("\"ply\""), std::string::npos);
  EXPECT_NE(error_of(mesh::readers::read_ply, head + xyz + face).find("end_header"),
            std::string::npos);
  EXPECT_NE(error_of(mesh::readers::read_ply, head + xyz + "end_header\n").find("cloud"),
            std::string::npos);
  EXPECT_NE(error_of(mesh::readers::read_ply, head + face + "end_header\n").find("\"vertex\""),
            std::string::npos);
  const std::string whole = head + xyz + face + "end_header\n";
  EXPECT_NE(
      message_of<InputError>([&] {
        mesh::readers::triangulate(mesh::readers::read_ply("mesh", whole + "0 0 nan\n3 0 0 0\n"));
      }).find("not finite"),
      std::string::npos);
  EXPECT_NE(error_of(mesh::readers::read_ply, whole + "0 0 0\n3 0 0 1\n").find("vertex 1"),
            std::string::npos);
  EXPECT_NE(error_of(mesh::readers::read_ply, whole + "0 0 0\n3 0 0\n").find("mesh:12: "),
            std::string::npos);
  EXPECT_NE(error_of(mesh::readers::read_ply, whole + "0 0 0\n3 0 0 -1\n").find("-1"),
            std::string::npos);
  // Counts that the file cannot hold.
  EXPECT_NE(error_of(mesh::readers::read_ply,
                     "ply\nformat binary_little_endian 1.0\nelement vertex 99999999999\n"
                     "property float x\nproperty float y\nproperty float z\n" +
                         face + "end_header\nabc")
                .find("ends"),
            std::string::npos);
}

TEST(ReadStl, TellsBinaryFromTextBySizeNotByTheWordSolid) {
  const core::TemporaryFolder folder;
  const mesh::SurfaceMesh mesh = mesh::readers::read_surface(
      test::written(folder, "cube.stl", cube_stl(true, "solid binary")));
  EXPECT_EQ(mesh.triangles.size(), 12u);
  EXPECT_EQ(mesh.vertices.size(), 8u);
  // Bytes behind the last triangle are let pass, as other readers do.
  EXPECT_EQ(mesh::readers::read_stl("mesh", cube_stl(true, "x") + "trailing").ends.size(), 12u);
}

TEST(ReadStl, ReadsWhatTheHeaderMiscounts) {
  std::string bytes = cube_stl(true, "x");
  const auto promise = [&bytes](std::uint32_t count) {
    std::memcpy(bytes.data() + 80, &count, sizeof(count));
    return bytes;
  };
  for (const std::uint32_t fewer : {0u, 1u, 11u})
    EXPECT_EQ(mesh::readers::read_stl("mesh", promise(fewer)).ends.size(), 12u);
  // Also where bytes of something else follow the last facet.
  for (const std::uint32_t fewer : {0u, 1u, 10u, 12u}) {
    EXPECT_EQ(mesh::readers::read_stl("mesh", promise(fewer) + "x").ends.size(), 12u) << fewer;
  }
  EXPECT_EQ(mesh::readers::read_stl("mesh", promise(12) + std::string(170, 't')).ends.size(), 12u);
  for (const std::uint32_t more : {13u, 4000000000u})
    EXPECT_NE(error_of(mesh::readers::read_stl, promise(more)).find("the header promises"),
              std::string::npos);
  // Attributes that are as long as the facet says.
  std::string payloads = promise(12).substr(0, 84);
  for (std::size_t i = 0; i < 12; ++i) {
    payloads += bytes.substr(84 + 50 * i, 48);
    payloads += static_cast<char>(i);
    payloads += '\0' + std::string(i, '\x7f');
  }
  const mesh::SurfaceMesh cube =
      mesh::readers::triangulate(mesh::readers::read_stl("mesh", payloads));
  EXPECT_NEAR(mesh::signed_volume(cube), 1, 1e-15);
}

TEST(ReadStl, UnderstandsTheDialectsOfText) {
  const std::string plain = cube_stl(false);
  const auto replaced = [&plain](const std::string& from, const std::string& to) {
    std::string text = plain;
    for (auto at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size()))
      text.replace(at, from.size(), to);
    return text;
  };
  for (const std::string& text :
       {"# made by hand\n; and so on\n" + plain, "exported 2020\n" + plain,
        replaced("facet normal", "! a comment\nfacet normal"),
        replaced("outer", "// a comment\n outer"), replaced("endfacet", "end facet"),
        replaced("endloop", "end loop"), replaced(" 1", " 1.0D+00"), replaced("\n", "\r"),
        plain.substr(plain.find("facet"))}) {
    EXPECT_EQ(mesh::readers::read_stl("mesh", text).ends.size(), 12u) << text.substr(0, 100);
  }
}

TEST(ReadStl, MergesZerosOfBothSigns) {
  const core::TemporaryFolder folder;
  const mesh::SurfaceMesh mesh = mesh::readers::read_surface(
      test::written(folder, "zeros.stl",
                    "solid vertex loop\nfacet normal 0 0 1 outer loop vertex 0 0 0 "
                    "vertex 1 0 0 vertex 0 1 0 endloop endfacet\nFACET NORMAL 0 0 1\n"
                    "OUTER LOOP\nVERTEX -0 0 -0.0\nVERTEX 0 1 0\nVERTEX -1 0 0\n"
                    "ENDLOOP\nENDFACET\nendsolid vertex loop\n"));
  EXPECT_EQ(mesh.vertices.size(), 4u);
  EXPECT_EQ(mesh.triangles, (std::vector<mesh::Triangle>{{0, 1, 2}, {0, 2, 3}}));
}

TEST(ReadStl, RefusesEmptyAndCutOffFiles) {
  const core::TemporaryFolder folder;
  const std::string empty = test::written(folder, "empty.stl", "solid nothing\nendsolid\n");
  EXPECT_NE(message_of<InputError>([&] { mesh::readers::read_surface(empty); }).find("no faces"),
            std::string::npos);
  EXPECT_NE(error_of(mesh::readers::read_stl, "").find("not an STL"), std::string::npos);
  EXPECT_NE(
      error_of(mesh::readers::read_stl, cube_stl(true, "x").substr(0, 600)).find("12 triangles"),
      std::string::npos);
  const std::string text = cube_stl(false);
  EXPECT_NE(
      error_of(mesh::readers::read_stl, text.substr(0, text.find("  vertex"))).find("ends inside"),
      std::string::npos);
  EXPECT_NE(error_of(mesh::readers::read_stl,
                     "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nendloop\n")
                .find("mesh:5: "),
            std::string::npos);
}

TEST(ScaleToMetres, SuggestsTheUnit) {
  mesh::Box box;
  box.high = Vec3(355.6, 3.175, 355.6);
  mesh::MeshFile file;
  file.path = "tray.stl";
  const std::string message =
      message_of<InputError>([&] { mesh::readers::scale_to_metres(box, file); });
  EXPECT_NE(message.find("355.6 m"), std::string::npos) << message;
  EXPECT_NE(message.find("millimetres say unit: mm or length: 0.3556 m"), std::string::npos)
      << message;
  file.any_size = true;
  EXPECT_EQ(mesh::readers::scale_to_metres(box, file), 1);
  file.any_size = false;
  file.length = 0.3556;
  EXPECT_NEAR(mesh::readers::scale_to_metres(box, file), 1e-3, 1e-18);
  file.unit = 1e-3;  // the length wins
  EXPECT_NEAR(mesh::readers::scale_to_metres(box, file), 1e-3, 1e-18);
  file.length = 0;
  EXPECT_EQ(mesh::readers::scale_to_metres(box, file), 1e-3);
  file.unit = 1;
  file.length = 20;
  EXPECT_THROW(mesh::readers::scale_to_metres(box, file), InputError);
  file.length = 0;
  box.high = Vec3(0.12, 0.1, 0.1);
  EXPECT_EQ(mesh::readers::scale_to_metres(box, file), 1);
  box.high = Vec3::Zero();
  EXPECT_THROW(mesh::readers::scale_to_metres(box, file), InputError);
}

TEST(Readers, AnswerDamagedFilesWithAMessage) {
  const std::pair<mesh::readers::PolygonMesh (*)(const std::string&, std::string_view), std::string>
      seeds[] = {{mesh::readers::read_obj, cube_obj()},
                 {mesh::readers::read_off, cube_off()},
                 {mesh::readers::read_ply, cube_ply("ascii")},
                 {mesh::readers::read_ply, cube_ply("binary_little_endian")},
                 {mesh::readers::read_ply, cube_ply("binary_big_endian")},
                 {mesh::readers::read_stl, cube_stl(true)},
                 {mesh::readers::read_stl, cube_stl(false)}};
  for (const auto& [read, bytes] : seeds) {
    std::mt19937_64 random(5);
    for (int i = 0; i < 4000; ++i) {
      try {
        const mesh::SurfaceMesh mesh =
            mesh::readers::triangulate(read("mesh", test::damaged(bytes, random)));
        for (const mesh::Triangle& t : mesh.triangles) {
          for (const std::int32_t v : t) {
            ASSERT_TRUE(v >= 0 && static_cast<std::size_t>(v) < mesh.vertices.size());
          }
        }
        for (const Vec3& v : mesh.vertices) ASSERT_TRUE(v.allFinite());
      } catch (const InputError& error) {
        ASSERT_FALSE(error.message().empty());
      }
    }
  }
}

}  // namespace
}  // namespace carillon::solvers
