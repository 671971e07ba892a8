#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>

#include "dataset/samples/modes_task.hpp"

namespace carillon::dataset {
namespace {

using synth::material::Material;

std::vector<std::vector<Material>> one_region(const std::vector<std::string>& names) {
  std::vector<std::vector<Material>> materials;
  for (const std::string& name : names)
    materials.push_back({synth::material::parse_material(name)});
  return materials;
}

TEST(ModeSets, EqualPoissonRatiosShareASolve) {
  // Steel has nu = 0.29; so has the second material, at another stiffness and density.
  const auto materials =
      one_region({"steel", "youngs_modulus=1e9,poisson_ratio=0.29,density=900", "glass"});
  const std::vector<plan::Variant> variants = {{"a", 1}, {"b", 2}, {"c", 1}};
  const samples::ModeSets sets = samples::group_variants(materials, variants, {20, 20000, 300});
  ASSERT_EQ(sets.requests.size(), 2u);
  EXPECT_EQ(sets.variants[0].set, sets.variants[1].set);
  EXPECT_NE(sets.variants[0].set, sets.variants[2].set);
}

TEST(ModeSets, EveryVariantsBandIsCovered) {
  EXPECT_TRUE(rc::check([] {
    const auto size = *rc::gen::container<std::vector<double>>(
        3, rc::gen::map(rc::gen::inRange(10, 1000), [](int i) { return i / 100.0; }));
    const auto materials = one_region({"steel", "youngs_modulus=1e9,poisson_ratio=0.29,density=900",
                                       "youngs_modulus=4e11,poisson_ratio=0.29,density=3000"});
    const std::vector<plan::Variant> variants = {{"a", size[0]}, {"b", size[1]}, {"c", size[2]}};
    const solvers::modes::Band band{20, 20000, 300};
    const samples::ModeSets sets = samples::group_variants(materials, variants, band);
    RC_ASSERT(sets.requests.size() == 1u);
    for (const samples::VariantModes& v : sets.variants) {
      // Frequencies of the variant are those of the solved object times this factor.
      const double factor = std::sqrt(v.modulus / v.density) / v.length;
      RC_ASSERT(sets.requests[0].band.min_frequency * factor <= band.min_frequency * (1 + 1e-9));
      RC_ASSERT(sets.requests[0].band.max_frequency * factor >= band.max_frequency * (1 - 1e-9));
    }
  }));
}

TEST(ModeSets, MaterialsOfOnePitchKeepTheirSetWhateverSizesRoundTo) {
  // What is solved at estimated sizes is read at final ones: rounding must not change whose set it
  // is.
  const auto materials = one_region({"steel", "youngs_modulus=1e9,poisson_ratio=0.29,density=900"});
  const auto speed = [&](std::size_t v) {
    const auto& elastic = materials[v][0].elastic;
    return std::sqrt(elastic.youngs_modulus / elastic.density);
  };
  for (const double off : {-3e-16, 0.0, 3e-16, 1e-14}) {
    const std::vector<plan::Variant> variants = {{"a", speed(0) / 440},
                                                 {"b", speed(1) / 440 * (1 + off)}};
    const samples::ModeSets sets = samples::group_variants(materials, variants, {20, 20000, 300});
    ASSERT_EQ(sets.requests.size(), 1u);
    EXPECT_EQ(sets.requests[0].regions[0].density, materials[0][0].elastic.density) << off;
  }
}

TEST(ModeSets, ContrastBetweenRegionsKeepsSolvesApart) {
  const auto a =
      synth::material::parse_material("youngs_modulus=1e9,poisson_ratio=0.3,density=900");
  const auto b =
      synth::material::parse_material("youngs_modulus=2e9,poisson_ratio=0.3,density=900");
  const auto c =
      synth::material::parse_material("youngs_modulus=4e9,poisson_ratio=0.3,density=900");
  const samples::ModeSets sets = samples::group_variants(
      {{a, b}, {b, c}, {a, c}}, {{"1", 1}, {"2", 1}, {"3", 1}}, {20, 20000, 300});
  EXPECT_EQ(sets.variants[0].set, sets.variants[1].set);  // both have a contrast of 2
  EXPECT_NE(sets.variants[0].set, sets.variants[2].set);
}

}  // namespace
}  // namespace carillon::dataset
