// The mesher's process as its caller sees it: results, reasons, limits, crashes, the cache.
#include <fmt/core.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <map>

#include "core/child_process.hpp"
#include "core/error.hpp"
#include "core/files.hpp"
#include "core/sanitizers.hpp"
#include "core/storage_error.hpp"
#include "core/temporary_folder.hpp"
#include "core/trace.hpp"
#include "solvers/mesh/raise_order.hpp"
#include "solvers/mesh/readers/read_mesh.hpp"
#include "solvers/mesher/mesh_child.hpp"
#include "tests/solvers/test_surfaces.hpp"
#include "tests/solvers/written_files.hpp"

namespace carillon::solvers {
namespace {

using core::FileError;
using core::InputError;
using core::SolverError;
using core::StorageError;
using test::message_of;

/// An OBJ file of a surface.
std::string obj(const mesh::SurfaceMesh& mesh) {
  std::string text;
  for (const Vec3& v : mesh.vertices) {
    text += fmt::format("v {:.17g} {:.17g} {:.17g}\n", v.x(), v.y(), v.z());
  }
  for (const mesh::Triangle& t : mesh.triangles) {
    text += fmt::format("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
  }
  return text;
}

/// Sets CARILLON_MESH for one scope.
class MesherIs {
 public:
  explicit MesherIs(const std::string& path) { setenv("CARILLON_MESH", path.c_str(), 1); }
  ~MesherIs() { unsetenv("CARILLON_MESH"); }
  MesherIs(const MesherIs&) = delete;
  MesherIs& operator=(const MesherIs&) = delete;
};

class MeshChild : public ::testing::Test {
 protected:
  MeshChild() {
    request_.file.path =
        test::written(folder_, "box.obj", obj(test::box_surface(Vec3(0.02, 0.03, 0.05), 1)));
    request_.options.order = 2;
  }

  /// A shell script in the mesher's place.
  std::string script(const std::string& body) const {
    const std::string path = test::written(folder_, "mesher", "#!/bin/sh\n" + body + "\n");
    chmod(path.c_str(), 0755);
    return path;
  }

  std::string death_of(const std::string& body, const mesher::ChildLimits& limits = {}) const {
    const MesherIs mesher(script(body));
    return message_of<SolverError>([&] { mesher::mesh_in_child(request_, limits, {}); });
  }

  core::TemporaryFolder folder_;
  mesh::MeshRequest request_;
};

TEST_F(MeshChild, MeshesABox) {
  const mesh::MeshResult result = mesher::mesh_in_child(request_, {}, {});
  EXPECT_EQ(result.mesh.order, 2);
  EXPECT_EQ(result.mesh.region_names, std::vector<std::string>{"body"});
  EXPECT_NEAR(result.quality.volume, 3e-5, 1e-14);
  EXPECT_EQ(result.quality.elements, static_cast<std::int64_t>(result.mesh.element_count()));
  EXPECT_TRUE(result.repair.used_as_is);
  EXPECT_TRUE(result.diagnosis.clean);
  EXPECT_GT(result.quality.min_radius_ratio, 0.05);
}

TEST_F(MeshChild, MeshesADamagedCurvedBodyAndAGeneratedOne) {
  std::mt19937_64 random(2);
  const mesh::SurfaceMesh sphere = test::sphere_surface(0.05, 16);
  request_.file.path = test::written(
      folder_, "ball.obj", obj(test::damaged(sphere, test::Damage::dropped, 0.01, random)));
  const mesh::MeshResult result = mesher::mesh_in_child(request_, {}, {});
  EXPECT_FALSE(result.repair.used_as_is);
  EXPECT_NEAR(result.quality.volume / mesh::signed_volume(sphere), 1, 0.01);
  const mesh::TetMesh next = mesh::next_order(result.mesh);
  EXPECT_EQ(next.nodes, result.mesh.finer_nodes);
  EXPECT_NEAR(mesh::measure_quality(next).volume / mesh::signed_volume(sphere), 1, 0.01);

  mesh::MeshRequest generated;
  generated.shape.family = "block";
  const std::string unknown = message_of<InputError>([&] {
    generated.shape.family = "blok";
    mesher::mesh_in_child(generated, {}, {});
  });
  EXPECT_NE(unknown.find("block"), std::string::npos) << unknown;
}

TEST_F(MeshChild, MeshesTrianglesInMemoryAsThoseOfAFile) {
  const mesh::MeshResult from_file = mesher::mesh_in_child(request_, {}, {});
  request_.file.surface = mesh::readers::read_surface(request_.file.path);
  request_.file.path = "/nowhere/tetrahedra.msh";  // only a name
  const mesh::MeshResult from_memory = mesher::mesh_in_child(request_, {}, {});
  EXPECT_EQ(from_memory.mesh.nodes, from_file.mesh.nodes);
  EXPECT_EQ(from_memory.mesh.elements, from_file.mesh.elements);
}

TEST_F(MeshChild, RefusesTrianglesInMemoryThatAreNone) {
  request_.file = {.path = "", .surface = test::box_surface(Vec3(0.02, 0.03, 0.05), 1)};
  const mesh::SurfaceMesh good = request_.file.surface;
  request_.file.surface.vertices[3].y() = std::nan("");
  EXPECT_EQ(message_of<InputError>([&] { mesher::mesh_in_child(request_, {}, {}); }),
            "triangles: vertex 3 is not finite");
  request_.file.surface = good;
  request_.file.surface.triangles[2][1] = 99;
  EXPECT_THROW(mesher::mesh_in_child(request_, {}, {}), core::Error);
}

TEST_F(MeshChild, KeepsTrianglesInMemoryByTheirValues) {
  request_.file.surface = test::box_surface(Vec3(0.02, 0.03, 0.05), 1);
  const std::string key = mesher::mesh_key(request_);
  request_.file.path = "another name";
  EXPECT_EQ(mesher::mesh_key(request_), key);
  request_.file.surface.vertices.front().x() += 1e-6;
  EXPECT_NE(mesher::mesh_key(request_), key);
}

TEST_F(MeshChild, PassesReasonsOn) {
  request_.file.length = 100;
  EXPECT_NE(
      message_of<InputError>([&] { mesher::mesh_in_child(request_, {}, {}); }).find("1 mm to 10 m"),
      std::string::npos);
  request_.file.length = 0;
  request_.options.order = 7;
  EXPECT_THROW(mesher::mesh_in_child(request_, {}, {}), InputError);
  request_.options = {};
  request_.options.max_elements = 5;
  EXPECT_THROW(mesher::mesh_in_child(request_, {}, {}), SolverError);
  request_.file.path = "/nowhere/none.obj";
  EXPECT_THROW(mesher::mesh_in_child(request_, {}, {}), FileError);
}

TEST_F(MeshChild, Diagnoses) {
  request_.file.length = 0.5;
  const mesh::Diagnosis d = mesher::diagnose_in_child(request_.file, {});
  EXPECT_TRUE(d.clean);
  EXPECT_NEAR(d.extent[2], 0.5, 1e-12);
  request_.file.length = 500;  // any size, so that it can be looked at
  EXPECT_NEAR(mesher::diagnose_in_child(request_.file, {}).extent[2], 500, 1e-9);
}

TEST_F(MeshChild, UsesTetrahedraOfMshFilesAsTheyAre) {
  request_.file.path = test::written(
      folder_, "two.msh",
      "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n3 4 \"oak\"\n$EndPhysicalNames\n"
      "$Nodes\n5\n1 0 0 0\n2 0.1 0 0\n3 0 0.1 0\n4 0 0 0.1\n5 0.1 0.1 0.1\n$EndNodes\n"
      "$Elements\n2\n1 4 2 4 1 1 2 3 4\n2 4 2 9 1 5 2 3 4\n$EndElements\n");
  request_.options.order = 3;
  const mesh::MeshResult result = mesher::mesh_in_child(request_, {}, {});
  EXPECT_EQ(result.mesh.order, 3);
  EXPECT_EQ(result.mesh.element_count(), 2u);
  EXPECT_EQ(result.mesh.region_names, (std::vector<std::string>{"oak", "group_9"}));
  EXPECT_EQ(result.mesh.nodes.size(), 30u);  // two lattices of 20 that share a face of 10
  EXPECT_EQ(result.mesh.face_count(), 6u);
  EXPECT_TRUE(result.mesh.finer_nodes.empty());  // nothing is truer than the elements themselves
  EXPECT_NEAR(result.quality.volume, 1e-3 / 6 + 1e-3 / 3, 1e-15);
  EXPECT_TRUE(result.diagnosis.closed);
  request_.options.max_elements = 1;
  EXPECT_THROW(mesher::mesh_in_child(request_, {}, {}), SolverError);
}

TEST_F(MeshChild, KeepsMeshesByKey) {
  const auto cache = folder_.path() / "cache";
  const mesh::MeshResult first = mesher::mesh_in_child(request_, {}, cache);
  {
    const MesherIs broken(script("exit 9"));
    const mesh::MeshResult second = mesher::mesh_in_child(request_, {}, cache);
    EXPECT_EQ(first.mesh.nodes, second.mesh.nodes);
    EXPECT_EQ(first.mesh.elements, second.mesh.elements);
    EXPECT_EQ(first.mesh.faces, second.mesh.faces);
    EXPECT_EQ(first.quality.median_radius_ratio, second.quality.median_radius_ratio);
  }
  // A damaged entry is made again.
  for (const auto& entry : std::filesystem::directory_iterator(cache)) {
    std::filesystem::resize_file(entry.path(), 100);
  }
  EXPECT_EQ(mesher::mesh_in_child(request_, {}, cache).mesh.nodes, first.mesh.nodes);
}

TEST_F(MeshChild, RepairsABodyOnceForAllSizes) {
  std::mt19937_64 random(2);
  const mesh::SurfaceMesh sphere = test::sphere_surface(0.05, 16);
  request_.file.path = test::written(
      folder_, "ball.obj", obj(test::damaged(sphere, test::Damage::dropped, 0.01, random)));
  const auto cache = folder_.path() / "cache";
  const auto bodies = [&cache] {
    std::map<std::filesystem::path, std::filesystem::file_time_type> written;
    for (const auto& entry : std::filesystem::directory_iterator(cache))
      if (entry.path().string().ends_with(".body.cbor"))
        written[entry.path()] = entry.last_write_time();
    return written;
  };
  request_.options.element_size = 0.04;
  const mesh::MeshResult coarse = mesher::mesh_in_child(request_, {}, cache);
  const auto first = bodies();
  ASSERT_EQ(first.size(), 1u);
  request_.options.element_size = 0.02;
  const mesh::MeshResult fine = mesher::mesh_in_child(request_, {}, cache);
  EXPECT_GT(fine.quality.elements, coarse.quality.elements);
  EXPECT_EQ(fine.repair.actions, coarse.repair.actions);
  EXPECT_EQ(bodies(), first);
  EXPECT_EQ(mesher::mesh_in_child(request_, {}, {}).mesh.nodes, fine.mesh.nodes)
      << "the kept body is the repaired one, bit by bit";
  // Another length is another body.
  request_.file.length = 0.2;
  mesher::mesh_in_child(request_, {}, cache);
  EXPECT_EQ(bodies().size(), 2u);
}

TEST_F(MeshChild, KeysTellRequestsApart) {
  const std::string key = mesher::mesh_key(request_);
  mesh::MeshRequest other = request_;
  other.file.path = test::written(folder_, "copy.obj", core::read_file(request_.file.path));
  EXPECT_EQ(mesher::mesh_key(other), key) << "the same bytes under another name are the same mesh";
  other.file.any_size = true;
  EXPECT_NE(mesher::mesh_key(other), key) << "or a cached mesh would pass the check of its size";
  other.file.any_size = request_.file.any_size;
  other.options.order = 3;
  EXPECT_NE(mesher::mesh_key(other), key);
  other = request_;
  other.file.length = 0.2;
  EXPECT_NE(mesher::mesh_key(other), key);
  other = request_;
  other.file.path =
      test::written(folder_, "other.obj", core::read_file(request_.file.path) + "# changed\n");
  EXPECT_NE(mesher::mesh_key(other), key);
  mesh::MeshRequest shape;
  shape.shape.family = "block";
  shape.shape.parameters["length"] = 0.1;
  const std::string block = mesher::mesh_key(shape);
  shape.shape.parameters["length"] = std::nextafter(0.1, 1);
  EXPECT_NE(mesher::mesh_key(shape), block);
  other.file.path = "/nowhere/none.obj";
  EXPECT_THROW(mesher::mesh_key(other), FileError);
}

TEST_F(MeshChild, NamesCrashesAndQuotesLastWords) {
  const std::string crash = death_of("echo something odd happened >&2; kill -SEGV $$");
  EXPECT_NE(crash.find("SIGSEGV"), std::string::npos) << crash;
  EXPECT_NE(crash.find("something odd happened"), std::string::npos) << crash;
  EXPECT_NE(crash.find("box.obj"), std::string::npos) << crash;
  EXPECT_NE(death_of("exit 3").find("code 3"), std::string::npos);
  EXPECT_NE(death_of("exit 0").find("no answer"), std::string::npos);
  EXPECT_NE(death_of("echo nonsense > $2").find("no answer"), std::string::npos);
  // More output than a pipe holds does not block it.
  EXPECT_NE(death_of("yes | head -c 1000000; echo the end; exit 4").find("the end"),
            std::string::npos);
}

TEST_F(MeshChild, IsStoppedAtTheTimeLimit) {
  mesher::ChildLimits limits;
  limits.seconds = 0.3;
  const double start = core::monotonic_seconds();
  EXPECT_NE(death_of("exec sleep 30", limits).find("time limit"), std::string::npos);
  // A child that has closed its streams is watched as well.
  EXPECT_NE(death_of("exec sleep 30 >&- 2>&-", limits).find("time limit"), std::string::npos);
  const MesherIs slow(script("exec sleep 30"));
  EXPECT_THROW(mesher::mesh_in_child(request_, limits, {}), core::TimeError);
  EXPECT_LT(core::monotonic_seconds() - start, 15);
}

TEST_F(MeshChild, IsStoppedAtTheMemoryLimit) {
  if (core::address_sanitizer) GTEST_SKIP() << "AddressSanitizer knows no limits of memory";
  request_.file.path = test::written(folder_, "ball.obj", obj(test::sphere_surface(0.05, 150)));
  mesher::ChildLimits limits;
  limits.memory = 1;  // already exceeded: the first allocation that needs new pages fails
  const std::string message =
      message_of<core::MemoryError>([&] { mesher::mesh_in_child(request_, limits, {}); });
  EXPECT_NE(message.find("limit of 1 B"), std::string::npos) << message;
}

TEST_F(MeshChild, DoesNotOutliveAnotherParent) {
  // Started by someone else than the request says: the parent has died meanwhile.
  const auto bytes = nlohmann::json::to_cbor(
      {{"task", "mesh"}, {"request", mesh::to_json(request_)}, {"memory", 0}, {"parent", 1}});
  const std::string question = test::written(
      folder_, "request.cbor", {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  const auto program =
      std::filesystem::read_symlink("/proc/self/exe").parent_path().parent_path() / "carillon-mesh";
  const core::ChildExit exit = core::run_child(program, {question, question + ".reply"}, 60);
  EXPECT_EQ(exit.code, 1);
  EXPECT_FALSE(std::filesystem::exists(question + ".reply"));
}

// Slurm's `scancel --signal` reaches every process of a job step, the mesher's among them.
TEST(ChildProcess, LivesOnWhenABatchSystemAsksTheWholeJobToStop) {
  const core::ChildExit exit = core::run_child(
      "/bin/sh", {"-c", "kill -TERM $$; kill -USR1 $$; kill -INT $$; echo lives on"}, 10);
  EXPECT_EQ(exit.signal, 0);
  EXPECT_EQ(exit.output, "lives on\n");
}

TEST_F(MeshChild, SaysWhenTheMesherIsMissing) {
  const MesherIs missing("/nowhere/carillon-mesh");
  EXPECT_NE(message_of<StorageError>([&] {
              mesher::mesh_in_child(request_, {}, {});
            }).find("CARILLON_MESH"),
            std::string::npos);
}

/// The body has no part in it, however its task ends.
TEST_F(MeshChild, TellsTheMachinesFaultsFromTheBodys) {
  const auto fault = [&] {
    return message_of<StorageError>([&] { mesher::mesh_in_child(request_, {}, {}); });
  };
  {
    const MesherIs no_program(test::written(folder_, "text", "no program"));
    EXPECT_NE(fault().find("cannot be started"), std::string::npos);
  }
  {
    const MesherIs cannot_write(script("echo the disk is full; exit 74"));
    EXPECT_NE(fault().find("the disk is full"), std::string::npos);
  }
  const char* before = std::getenv("TMPDIR");
  const std::string kept = before == nullptr ? "" : before;
  setenv("TMPDIR", (folder_.path() / "nowhere").c_str(), 1);
  EXPECT_NE(fault().find("nowhere is no folder"), std::string::npos);
  before == nullptr ? unsetenv("TMPDIR") : setenv("TMPDIR", kept.c_str(), 1);
}

TEST(MeshJson, GoesThereAndBack) {
  EXPECT_TRUE(rc::check("requests", [] {
    mesh::MeshRequest r;
    r.shape.family = *rc::gen::element<std::string>("", "bowl", "turned");
    r.shape.parameters["wall"] = *rc::gen::arbitrary<double>();
    r.shape.profile = {{*rc::gen::arbitrary<double>(), 2}};
    r.file.path = *rc::gen::string<std::string>();
    r.file.length = *rc::gen::arbitrary<double>();
    r.file.any_size = *rc::gen::arbitrary<bool>();
    r.options.order = *rc::gen::inRange(1, 5);
    r.options.max_elements = *rc::gen::arbitrary<std::int64_t>();
    const auto there = nlohmann::json::to_cbor(mesh::to_json(r));
    const mesh::MeshRequest back = mesh::mesh_request_from_json(nlohmann::json::from_cbor(there));
    RC_ASSERT(back.shape.family == r.shape.family);
    RC_ASSERT(back.shape.parameters == r.shape.parameters);
    RC_ASSERT(back.shape.profile == r.shape.profile);
    RC_ASSERT(back.file.path == r.file.path);
    RC_ASSERT(back.file.length == r.file.length);
    RC_ASSERT(back.file.any_size == r.file.any_size);
    RC_ASSERT(back.options.order == r.options.order);
    RC_ASSERT(back.options.max_elements == r.options.max_elements);
  }));
  mesh::MeshResult result;
  result.mesh.nodes = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1 / 3.0}};
  result.mesh.elements = {0, 1, 2, 3};
  result.mesh.regions = {0};
  result.mesh.region_names = {"body"};
  result.mesh.faces = {0, 2, 1};
  result.repair.volume_change = std::numeric_limits<double>::quiet_NaN();
  result.repair.actions = {"wrapped"};
  result.diagnosis.extent = {1, 2, 3};
  nlohmann::json json = mesh::to_json(result);
  const mesh::MeshResult back = mesh::mesh_result_from_json(json);
  EXPECT_EQ(back.mesh.nodes, result.mesh.nodes);
  EXPECT_EQ(back.mesh.faces, result.mesh.faces);
  EXPECT_TRUE(std::isnan(back.repair.volume_change));
  EXPECT_EQ(back.repair.actions, result.repair.actions);
  EXPECT_EQ(back.diagnosis.extent, result.diagnosis.extent);
  // Damage is noticed, not followed.
  for (const char* field : {"nodes", "elements", "faces", "regions", "order"}) {
    nlohmann::json damaged = json;
    damaged["mesh"].erase(field);
    EXPECT_THROW(mesh::mesh_result_from_json(damaged), FileError) << field;
  }
  result.mesh.elements = {0, 1, 2, 4};
  EXPECT_THROW(mesh::mesh_result_from_json(mesh::to_json(result)), FileError);
}

}  // namespace
}  // namespace carillon::solvers
