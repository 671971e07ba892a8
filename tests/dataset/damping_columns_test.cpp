#include "dataset/samples/damping_columns.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>

#include "core/hdf5.hpp"
#include "core/temporary_folder.hpp"
#include "dataset/configuration/configuration.hpp"
#include "dataset/plan/plan.hpp"
#include "scene/columns.hpp"

namespace carillon::dataset {
namespace {

configuration::BuildConfig config_of(const std::string& materials) {
  return configuration::read_build_config(
      "objects:\n  - {shape: bar, materials: " + materials + "}\n", "t.yaml", {});
}

TEST(DampingColumns, AreAsManyAsTheModelsNeed) {
  const auto units = [](const std::string& materials) {
    return samples::damping_column_units(configuration::named_materials(config_of(materials)));
  };
  using Units = std::vector<std::string>;
  EXPECT_EQ(units("[steel, glass]"), (Units{"1/s", "s"}));
  EXPECT_EQ(units("[gpd_wood_caughey]"), (Units{"1/s", "s", "s^3"}));
  EXPECT_EQ(units("[steel, gpd_wood_caughey]"), (Units{"1/s", "s", "s^3"}));
  EXPECT_EQ(units("[steel, sterling_wood_hybrid]"), (Units{"1/s", "SI", "1"}));
  EXPECT_EQ(units("['youngs_modulus=1e9,poisson_ratio=0.3,density=1000,damping=6']"),
            (Units{"1/s", "s"}));
}

TEST(DampingColumns, HoldNaNWhereAModelHasNoSuchParameter) {
  const auto materials =
      configuration::named_materials(config_of("[gpd_wood_caughey, steel, gpd_wood_power]"));
  const auto units = samples::damping_column_units(materials);
  core::Columns columns(scene::columns());
  for (const synth::material::Material& m : materials)
    samples::add_damping_columns(m.damping, units, columns);
  const core::TemporaryFolder folder;
  const core::Hdf5Group file = core::Hdf5Group::create_file(folder / "columns.h5");
  columns.write(file);
  EXPECT_EQ(file.read<std::string>("damping_model"),
            (std::vector<std::string>{"caughey", "power", "rayleigh"}));
  EXPECT_EQ(file.read<double>("alpha1"), (std::vector<double>{277, 6.7, 5}));
  EXPECT_EQ(file.read<double>("alpha2"), (std::vector<double>{-2.0e-6, 0.18, 3e-8}));
  const auto third = file.read<double>("alpha3");
  EXPECT_EQ(third.at(0), 4.8e-15);
  EXPECT_TRUE(std::isnan(third.at(1)) && std::isnan(third.at(2)));
  EXPECT_FALSE(file.has("alpha4"));
}

// Whoever changes a material's damping between two runs must be told.
TEST(DampingColumns, FingerprintsKnowTheDamping) {
  const core::TemporaryFolder folder;
  const auto path = folder / "materials.yaml";
  const auto fingerprint_with = [&](const std::string& damping) {
    std::ofstream(path) << "own: {youngs_modulus: 1e9, poisson_ratio: 0.3, density: 1000, "
                        << damping << "}\n";
    const configuration::BuildConfig config = configuration::read_build_config(
        "materials_file: " + path.string() + "\nobjects:\n  - {shape: bar, materials: [own]}\n",
        "t.yaml", {});
    return plan::fingerprint(config, plan::make_plan(config));
  };
  const std::vector<std::string> dampings = {"alpha1: 1",
                                             "alpha1: 2",
                                             "damping: {model: caughey, alpha1: 1, alpha2: 0}",
                                             "damping: {model: power, alpha1: 1, alpha2: 0}",
                                             "damping: {model: power, alpha1: 1, alpha2: 1e-300}",
                                             "damping: 1 + lambda",
                                             "damping: 1 + 2*lambda"};
  std::set<std::string> prints;
  for (const std::string& damping : dampings) prints.insert(fingerprint_with(damping));
  EXPECT_EQ(prints.size(), dampings.size());
  EXPECT_EQ(fingerprint_with(dampings[3]), fingerprint_with(dampings[3]));
}

}  // namespace
}  // namespace carillon::dataset
