#include <gtest/gtest.h>

#include <fstream>

#include "core/error.hpp"
#include "core/temporary_folder.hpp"
#include "solve.hpp"
#include "solvers/eigen/cached_modes.hpp"
#include "solvers/modes/modes_file.hpp"
#include "test_meshes.hpp"
#include "tests/solvers/written_files.hpp"

namespace carillon {
namespace {

using namespace solvers;
using test::box_mesh;

void expect_equal(const solvers::modes::Modes& a, const solvers::modes::Modes& b) {
  EXPECT_EQ(a.eigenvalues, b.eigenvalues);
  EXPECT_EQ(a.residuals, b.residuals);
  ASSERT_EQ(a.shapes.modes(), b.shapes.modes());
  ASSERT_EQ(a.shapes.nodes(), b.shapes.nodes());
  EXPECT_EQ(a.shapes.values(), b.shapes.values());
  ASSERT_EQ(a.kinetic_fraction.cols(), b.kinetic_fraction.cols());
  EXPECT_TRUE((a.kinetic_fraction.array() == b.kinetic_fraction.array()).all());
  EXPECT_TRUE((a.strain_fraction.array() == b.strain_fraction.array()).all());
  EXPECT_EQ(a.surface.order, b.surface.order);
  EXPECT_EQ(a.surface.nodes, b.surface.nodes);
  EXPECT_EQ(a.surface.faces, b.surface.faces);
  EXPECT_EQ(a.mass, b.mass);
  EXPECT_EQ(a.certificate.min_frequency, b.certificate.min_frequency);
  EXPECT_EQ(a.certificate.max_frequency, b.certificate.max_frequency);
  EXPECT_EQ(a.certificate.modes_in_band, b.certificate.modes_in_band);
  EXPECT_EQ(a.certificate.modes_found, b.certificate.modes_found);
  EXPECT_EQ(a.certificate.complete, b.certificate.complete);
  EXPECT_EQ(a.certificate.complete_to_hz, b.certificate.complete_to_hz);
  EXPECT_EQ(a.certificate.rigid_modes, b.certificate.rigid_modes);
  EXPECT_EQ(a.certificate.components, b.certificate.components);
  EXPECT_EQ(a.certificate.max_residual, b.certificate.max_residual);
  EXPECT_EQ(a.certificate.orthonormality, b.certificate.orthonormality);
  EXPECT_EQ(a.certificate.unknowns, b.certificate.unknowns);
  EXPECT_EQ(a.certificate.count_verified, b.certificate.count_verified);
  EXPECT_EQ(a.certificate.eigen_solver, b.certificate.eigen_solver);
  EXPECT_EQ(a.certificate.linear_solver, b.certificate.linear_solver);
  EXPECT_EQ(a.certificate.snapshots, b.certificate.snapshots);
  EXPECT_EQ(a.certificate.basis_error, b.certificate.basis_error);
}

class ModesFile : public testing::Test {
 protected:
  ModesFile() { options.band = {20, 90000, 300}; }

  test::TetMesh mesh =
      box_mesh({0.02, 0.03, 0.05}, {1, 2, 3}, 2, [](const Vec3& x) { return x[2] < 0.02 ? 0 : 1; });
  std::vector<solvers::elements::Elastic> regions = {test::steel, test::aluminium};
  solvers::eigen::SolveOptions options;
  core::TemporaryFolder folder;

  solvers::modes::Modes solve(core::Trace& trace) {
    return solvers::eigen::cached_modes(mesh, regions, options, MPI_COMM_SELF, folder.path(),
                                        trace);
  }
};

TEST_F(ModesFile, ComesBackEqualFromDisk) {
  const auto modes = test::lowest_modes(mesh, regions, 9);
  const auto path = folder.path() / "modes.h5";
  solvers::modes::write_modes(core::Hdf5Group::create_file(path).create_group("cup"), modes);
  expect_equal(solvers::modes::read_modes(core::Hdf5Group::open_file(path).open_group("cup")),
               modes);
  const auto group = core::Hdf5Group::open_file(path).open_group("cup");
  EXPECT_EQ(group.text_attribute("unit", "eigenvalues"), "rad^2/s^2");
  EXPECT_EQ(group.text_attribute("unit", "shapes"), "kg^-1/2");
  EXPECT_EQ(group.extent("shapes"), (core::Extent{9, modes.surface.nodes.size(), 3}));
}

TEST_F(ModesFile, EverySolverComesBackByItsName) {
  auto modes = test::lowest_modes(mesh, regions, 3);
  EXPECT_EQ(modes.certificate.eigen_solver,
            solvers::modes::EigenSolver::dense);  // a few hundred unknowns
  const auto path = folder.path() / "named.h5";
  for (const auto eigen :
       {solvers::modes::EigenSolver::block_lanczos, solvers::modes::EigenSolver::krylov_schur,
        solvers::modes::EigenSolver::lobpcg, solvers::modes::EigenSolver::dense}) {
    for (const auto linear :
         {solvers::modes::LinearSolver::direct, solvers::modes::LinearSolver::iterative}) {
      modes.certificate.eigen_solver = eigen;
      modes.certificate.linear_solver = linear;
      solvers::modes::write_modes(core::Hdf5Group::create_file(path), modes);
      expect_equal(solvers::modes::read_modes(core::Hdf5Group::open_file(path)), modes);
    }
  }
}

TEST_F(ModesFile, AnEmptySetComesBackToo) {
  options.band = {20, 200, 300};
  core::Trace trace;
  const auto modes = solve(trace);
  ASSERT_EQ(modes.size(), 0u);
  const auto path = folder.path() / "empty.h5";
  solvers::modes::write_modes(core::Hdf5Group::create_file(path), modes);
  expect_equal(solvers::modes::read_modes(core::Hdf5Group::open_file(path)), modes);
}

TEST_F(ModesFile, IsFoundByTheSameQuestionOnly) {
  core::Trace trace;
  const auto first = solve(trace);
  EXPECT_GT(first.size(), 0u);
  EXPECT_EQ(trace.stages.count("modes from cache"), 0u);
  const auto second = solve(trace);
  EXPECT_EQ(trace.stages.at("modes from cache").calls, 1);
  EXPECT_EQ(trace.stages.at("solve").calls, 1);
  expect_equal(first, second);
  regions[1].poisson_ratio = 0.331;
  const auto third = solve(trace);
  EXPECT_EQ(trace.stages.at("solve").calls, 2);
  EXPECT_NE(third.eigenvalues, first.eigenvalues);
}

TEST_F(ModesFile, EveryPartOfTheQuestionIsInTheKey) {
  const auto key = [&] { return solvers::eigen::modes_key(mesh, regions, options, 1); };
  const auto first = key();
  EXPECT_EQ(first.size(), 64u);
  EXPECT_EQ(first, key());
  EXPECT_NE(first, solvers::eigen::modes_key(mesh, regions, options, 2));
  options.band.max_modes = 299;
  EXPECT_NE(first, key());
  options.band.max_modes = 300;
  options.band.min_frequency = 21;
  EXPECT_NE(first, key());
  options.band.min_frequency = 20;
  mesh.nodes[3][1] += 1e-9;
  EXPECT_NE(first, key());
  mesh.nodes[3][1] -= 1e-9;
  mesh.regions[0] = 1;
  EXPECT_NE(first, key());
}

TEST_F(ModesFile, ThatIsDamagedIsSolvedAgainAndReplaced) {
  core::Trace trace;
  const auto first = solve(trace);
  const auto path = folder.path() / (solvers::eigen::modes_key(mesh, regions, options, 1) + ".h5");
  std::ofstream(path, std::ios::trunc) << "not HDF5";
  expect_equal(solve(trace), first);
  EXPECT_EQ(trace.stages.at("solve").calls, 2);
  solve(trace);
  EXPECT_EQ(trace.stages.at("modes from cache").calls, 1);
}

TEST_F(ModesFile, ThatCannotBeWrittenCostsNothingButTime) {
  core::Trace trace;
  const auto file = test::written(folder, "not-a-folder", "");
  const auto modes =
      solvers::eigen::cached_modes(mesh, regions, options, MPI_COMM_SELF, file, trace);
  EXPECT_GT(modes.size(), 0u);
}

}  // namespace
}  // namespace carillon
