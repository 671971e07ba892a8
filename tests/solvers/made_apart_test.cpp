// What crashes, hangs or runs out of memory in a process of its own costs nothing but itself.
#include "solvers/mesh/tetrahedra/detail/made_apart.hpp"

#include <gtest/gtest.h>
#include <signal.h>
#include <unistd.h>

#include <functional>
#include <new>
#include <stdexcept>
#include <string>

#include "core/error.hpp"
#include "mesh_checks.hpp"
#include "test_meshes.hpp"
#include "written_files.hpp"

namespace carillon::test {
namespace {

using solvers::mesh::TetMesh;
using solvers::mesh::tetrahedra::made_apart;

TEST(MadeApart, MeshesComeAsTheyAre) {
  const TetMesh box = box_mesh(Vec3(1, 2, 3), {2, 3, 4}, 2);
  const TetMesh same = made_apart([&box] { return box; }, 10);
  EXPECT_TRUE(same_bytes(same, box));
}

std::string complaint_of(const std::function<TetMesh()>& make, unsigned seconds = 10) {
  return message_of<core::SolverError>([&] { made_apart(make, seconds); });
}

TEST(MadeApart, DeathsAreReasons) {
  EXPECT_EQ(complaint_of([]() -> TetMesh { throw core::SolverError("PLC Error"); }), "PLC Error");
  EXPECT_EQ(complaint_of([]() -> TetMesh { throw std::out_of_range("map::at"); }), "map::at");
  EXPECT_EQ(complaint_of([]() -> TetMesh {
              raise(SIGSEGV);
              return {};
            }),
            "it crashed (SIGSEGV)");
  // As a system without memory ends it: no lack of time.
  EXPECT_EQ(complaint_of([]() -> TetMesh {
              raise(SIGKILL);
              return {};
            }),
            "it crashed (SIGKILL)");
  EXPECT_EQ(complaint_of([]() -> TetMesh { _exit(3); }), "it ended without an answer");
}

TEST(MadeApart, HangsEnd) {
  EXPECT_EQ(complaint_of(
                []() -> TetMesh {
                  for (volatile bool hangs = true; hangs;) {
                  }
                  return {};
                },
                1),
            "it was stopped after 1 s");
}

TEST(MadeApart, MemoryIsTheCallers) {
  EXPECT_THROW(made_apart([]() -> TetMesh { throw std::bad_alloc(); }, 10), std::bad_alloc);
}

}  // namespace
}  // namespace carillon::test
