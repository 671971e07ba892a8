#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "core/error.hpp"
#include "solvers/mesh/repair/repair.hpp"
#include "tests/solvers/test_surfaces.hpp"
#include "tests/solvers/written_files.hpp"

namespace carillon::test {

using solvers::mesh::Diagnosis;
using solvers::mesh::MeshFile;
using solvers::mesh::RepairReport;

struct Outcome {
  SurfaceMesh body;
  Diagnosis diagnosis;
  RepairReport report;
};

/// A repair whose result is checked to be clean.
inline Outcome repaired(const SurfaceMesh& mesh, double thickness = 0) {
  MeshFile file;
  file.path = "body.obj";
  file.thickness = thickness;
  Outcome outcome;
  outcome.body = solvers::mesh::repair::repair(mesh, file, outcome.diagnosis, outcome.report);
  EXPECT_TRUE(solvers::mesh::repair::diagnose(outcome.body).clean);
  return outcome;
}

/// What the repair says when it refuses.
inline std::string refusal(const SurfaceMesh& mesh) {
  return message_of<core::InputError>([&mesh] { repaired(mesh); });
}

/// Whether an action of the report holds a word.
inline bool says(const RepairReport& report, const std::string& word) {
  for (const std::string& action : report.actions) {
    if (action.find(word) != std::string::npos) return true;
  }
  return false;
}

struct Body {
  const char* name;
  SurfaceMesh mesh;
};

/// Clean bodies of several kinds: thick, thin, with a hole, with an edge.
inline std::vector<Body> bodies() {
  return {{"sphere", sphere_surface(0.05, 10)},
          {"box", box_surface(Vec3(0.02, 0.03, 0.05), 6)},
          {"torus", torus_surface(0.04, 0.015, 14)},
          {"tube", tube_surface(0.02, 0.003, 0.1, 10)},
          {"bowl", bowl_surface(0.07, 0.004, 10)}};
}

}  // namespace carillon::test
