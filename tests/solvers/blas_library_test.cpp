#include "solvers/libraries/detail/blas_library.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <string>

namespace carillon {
namespace {

/// What this program prints of its BLAS in another environment.
std::string complaint_with(const std::string& environment) {
  const auto program = std::filesystem::read_symlink("/proc/self/exe").string();
  const auto command = environment + " '" + program + "' --complaint";
  std::string text;
  FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) return "no pipe";
  for (std::array<char, 256> part; std::fgets(part.data(), part.size(), pipe) != nullptr;) {
    text += part.data();
  }
  return pclose(pipe) == 0 ? text : "failed: " + text;
}

TEST(BlasLibrary, IsTunedAndAloneInTheSetUpOfTheProject) {
  EXPECT_EQ(solvers::libraries::blas_complaint(), "");
}

TEST(BlasLibrary, TheReferenceOneIsNamed) {
  const std::filesystem::path folder = "/usr/lib/x86_64-linux-gnu/blas";
  if (!exists(folder / "libblas.so.3")) GTEST_SKIP() << "the reference BLAS is not installed";
  const auto complaint = complaint_with("LD_LIBRARY_PATH=" + folder.string());
  EXPECT_NE(complaint.find("reference BLAS"), std::string::npos) << complaint;
  EXPECT_NE(complaint.find("libopenblas0-serial"), std::string::npos) << complaint;
}

}  // namespace
}  // namespace carillon

int main(int argc, char** argv) {
  if (argc > 1 && std::strcmp(argv[1], "--complaint") == 0) {
    std::fputs(carillon::solvers::libraries::blas_complaint().c_str(), stdout);
    return 0;
  }
  testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
