#include "mpi/launcher.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <map>
#include <optional>
#include <string>

namespace carillon::mpi {
namespace {

/// An environment without a launcher; this process' own comes back afterwards.
class Launcher : public testing::Test {
 protected:
  Launcher() {
    for (const char* name : {"OMPI_COMM_WORLD_RANK", "PMIX_RANK", "PMI_RANK", "SLURM_PROCID",
                             "PMI_FD", "PMI_PORT", "PMI_SIZE", "PMI_JOBID", "PMIX_NAMESPACE",
                             "OMPI_MCA_pml", "OMPI_MCA_btl", "OMPI_MCA_ess_singleton_isolated"}) {
      const char* const value = std::getenv(name);
      former_[name] = value == nullptr ? std::nullopt : std::optional<std::string>(value);
      unsetenv(name);
    }
  }
  ~Launcher() override {
    for (const auto& [name, value] : former_) {
      value ? setenv(name.c_str(), value->c_str(), 1) : unsetenv(name.c_str());
    }
  }

 private:
  std::map<std::string, std::optional<std::string>> former_;
};

TEST_F(Launcher, AProgramStartedAloneHasNoRank) {
  EXPECT_EQ(launcher_rank(), std::nullopt);
}

TEST_F(Launcher, EveryLaunchersRankIsFound) {
  for (const char* name : {"OMPI_COMM_WORLD_RANK", "PMIX_RANK", "PMI_RANK"}) {
    setenv(name, "3", 1);
    EXPECT_EQ(launcher_rank(), 3) << name;
    unsetenv(name);
  }
}

TEST_F(Launcher, SlurmsNumberIsARankWhereThereIsAPmi) {
  setenv("SLURM_PROCID", "2", 1);
  EXPECT_EQ(launcher_rank(), std::nullopt);  // a batch script, srun --mpi=none
  setenv("PMI_SIZE", "4", 1);
  EXPECT_EQ(launcher_rank(), 2);
}

TEST_F(Launcher, SettingsForOneProcessGoWithTheirObject) {
  setenv("OMPI_MCA_pml", "ucx", 1);
  {
    const AloneSettings settings;
    EXPECT_STREQ(std::getenv("OMPI_MCA_btl"), "self");
    EXPECT_STREQ(std::getenv("OMPI_MCA_pml"), "ucx");
  }
  EXPECT_EQ(std::getenv("OMPI_MCA_btl"), nullptr);
  EXPECT_STREQ(std::getenv("OMPI_MCA_pml"), "ucx");
}

TEST_F(Launcher, RanksAreLeftTheirSettings) {
  setenv("OMPI_COMM_WORLD_RANK", "0", 1);
  const AloneSettings settings;
  EXPECT_EQ(std::getenv("OMPI_MCA_btl"), nullptr);
}

}  // namespace
}  // namespace carillon::mpi
