#include "synth/material/material.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>

#include "core/error.hpp"
#include "core/temporary_folder.hpp"
#include "synth/modal/ring_down.hpp"

namespace carillon::synth {
namespace {

std::string message_of(const std::string& text, const std::vector<material::Material>& own = {}) {
  try {
    material::parse_material(text, own);
  } catch (const core::InputError& error) {
    return error.what();
  }
  return "no error";
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

/// A file that lives as long as the test.
class MaterialFile {
 public:
  explicit MaterialFile(const std::string& text) { std::ofstream(path()) << text; }
  std::string path() const { return folder_ / "materials.yaml"; }

 private:
  core::TemporaryFolder folder_;
};

std::string file_error(const std::string& text) {
  const MaterialFile file(text);
  try {
    material::read_materials(file.path());
  } catch (const core::ConfigError& error) {
    return error.what();
  }
  return "no error";
}

TEST(PresetMaterials, AreThePublishedRows) {
  const material::Material steel = material::parse_material("steel");
  EXPECT_EQ(steel.elastic.youngs_modulus, 2.0e11);
  EXPECT_EQ(steel.elastic.poisson_ratio, 0.29);
  EXPECT_EQ(steel.elastic.density, 7850);
  EXPECT_EQ(steel.damping.parameters[0], 5);
  EXPECT_EQ(steel.damping.parameters[1], 3e-8);
  const material::Material polycarbonate = material::parse_material("polycarbonate");
  EXPECT_EQ(polycarbonate.damping.parameters[0], 0.5);
  EXPECT_EQ(polycarbonate.damping.parameters[1], 4e-7);
  EXPECT_EQ(material::parse_material("sterling_travertine").damping.parameters[1], 2.5e-8);
}

TEST(PresetMaterials, WoodsAreOrthotropic) {
  const solvers::elements::Elastic spruce = material::parse_material("spruce").elastic;
  ASSERT_TRUE(spruce.anisotropy);
  const auto compliance =
      solvers::elements::Voigt((spruce.youngs_modulus * *spruce.anisotropy).inverse());
  EXPECT_NEAR(1 / compliance(0, 0), 1.1 * 10.8e9, 1e3);
  EXPECT_NEAR(1 / compliance(2, 2), 0.043 * 1.1 * 10.8e9, 1e3);
  EXPECT_NEAR(1 / compliance(3, 3), 0.003 * 1.1 * 10.8e9, 1e3);
  EXPECT_NEAR(-compliance(1, 0) / compliance(0, 0), 0.372, 1e-9);
  EXPECT_EQ(spruce.density, 448);
  // A polycrystal of it lies between its softest and its stiffest direction.
  EXPECT_GT(spruce.youngs_modulus, 1 / compliance(2, 2));
  EXPECT_LT(spruce.youngs_modulus, 1 / compliance(0, 0));
}

TEST(ParseMaterial, AnisotropicSolids) {
  const auto stiffness = [](const std::string& text) {
    const solvers::elements::Elastic e = material::parse_material(text + ",density=400").elastic;
    return solvers::elements::Voigt(e.youngs_modulus * *e.anisotropy);
  };
  const auto cubic = stiffness("C11=168GPa,C12=121GPa,C44=75GPa");
  EXPECT_NEAR(cubic(0, 0), 168e9, 1);
  EXPECT_NEAR(cubic(1, 2), 121e9, 1);
  EXPECT_NEAR(cubic(5, 5), 75e9, 1);
  const auto hexagonal = stiffness("C11=162GPa,C12=92GPa,C13=69GPa,C33=181GPa,C44=47GPa");
  EXPECT_NEAR(hexagonal(2, 2), 181e9, 1);
  EXPECT_NEAR(hexagonal(5, 5), 35e9, 1);
  const std::string triangle =
      "168e9 121e9 121e9 0 0 0 168e9 121e9 0 0 0 168e9 0 0 0 75e9 0 0 75e9 0 75e9";
  EXPECT_LT((stiffness("stiffness=" + triangle) - cubic).norm(), 1);
  EXPECT_TRUE(contains(message_of("stiffness=1 2 3,density=1"), "symmetric matrix"));
  EXPECT_TRUE(contains(message_of("E1=1,E2=1,density=1"), "\"E3\" [Pa], \"nu23\" [1]"));
  EXPECT_TRUE(contains(message_of("C11=3,C12=1,density=1"), "\"C44\" is missing"));
  EXPECT_TRUE(contains(message_of("C11=1,youngs_modulus=1,density=1"), "no law together"));
  EXPECT_TRUE(contains(message_of("C11=1,C12=2,C44=1,density=1"), "positive definite"));
}

TEST(PresetMaterials, AreSoundAndNamedOnce) {
  std::set<std::string> names;
  for (const material::Material& material : material::preset_materials()) {
    EXPECT_NO_THROW(material::check_material(material)) << material.name;
    EXPECT_TRUE(names.insert(material.name).second) << material.name;
    EXPECT_FALSE(material.source.empty()) << material.name;
    if (material.name.starts_with("sterling_")) {
      EXPECT_TRUE(contains(material.source, "handbook")) << material.name;
    }
  }
}

// The seeds' check: a 10 kHz mode of the porcelain plate under its Rayleigh row has c = alpha1 +
// alpha2 omega^2 = 43.4 1/s.
TEST(PresetMaterials, PorcelainDampsATenKilohertzModeAsPublished) {
  const material::Material porcelain = material::parse_material("sterling_porcelain");
  const double omega = 2 * M_PI * 1e4;
  EXPECT_NEAR(porcelain.damping.parameters[0] + porcelain.damping.parameters[1] * omega * omega,
              43.378, 1e-3);
}

TEST(ParseMaterial, ModuliArePositive) {
  EXPECT_TRUE(contains(message_of("C11=0,C12=1,C44=1,density=1"), "C11 must be positive, not 0"));
  EXPECT_TRUE(contains(message_of("C11=3,C12=1,C44=-1,density=1"), "C44 must be positive, not -1"));
}

TEST(ParseMaterial, TakesKeysInAnyOrderWithUnits) {
  const material::Material material = material::parse_material(
      " density=2.7 g/cm^3, youngs_modulus=72 GPa ,poisson_ratio=0.19,alpha2=1e-7");
  EXPECT_NEAR(material.elastic.youngs_modulus, 7.2e10, 1);
  EXPECT_NEAR(material.elastic.density, 2700, 1e-9);
  EXPECT_EQ(material.damping.parameters[0], 0);
  EXPECT_EQ(material.damping.parameters[1], 1e-7);
}

TEST(ParseMaterial, NamesWhatIsWrong) {
  EXPECT_TRUE(contains(message_of("stell"), "did you mean \"steel\"?"));
  EXPECT_TRUE(contains(message_of("travertine"), "did you mean \"sterling_travertine\" or"));
  EXPECT_TRUE(contains(message_of("bronze"), "\"aluminium_bronze\" or \"bell_bronze\"?"));
  EXPECT_TRUE(contains(message_of(""), "no name"));
  EXPECT_TRUE(contains(message_of("youngs_modulos=1e9,poisson_ratio=0.3,density=1"),
                       "did you mean \"youngs_modulus\"?"));
  EXPECT_TRUE(contains(message_of("youngs_modulus=1e9,density=1"), "\"poisson_ratio\" is missing"));
  EXPECT_TRUE(contains(message_of("youngs_modulus=1e9,youngs_modulus=1e9"), "given twice"));
  EXPECT_TRUE(
      contains(message_of("youngs_modulus=1e9,0.3,density=1"), "\"0.3\" is not of the form"));
  EXPECT_TRUE(
      contains(message_of("youngs_modulus=12 kg,poisson_ratio=0.3,density=1"), "youngs_modulus"));
  EXPECT_TRUE(
      contains(message_of("youngs_modulus=1e9,poisson_ratio=0.3,density=1,"), "not of the form"));
}

TEST(ParseMaterial, RefusesTheUnphysical) {
  const auto with = [](const std::string& nu, const std::string& more = "") {
    return message_of("youngs_modulus=1e9,density=1000,poisson_ratio=" + nu + more);
  };
  EXPECT_EQ(with("0.49"), "no error");
  EXPECT_EQ(with("-0.9"), "no error");
  EXPECT_TRUE(contains(with("0.5"), "Poisson"));
  EXPECT_TRUE(contains(with("-1"), "Poisson"));
  EXPECT_TRUE(contains(with("0.3", ",alpha1=-1"), "alpha1"));
  EXPECT_TRUE(contains(message_of("youngs_modulus=0,poisson_ratio=0.3,density=1"), "modulus"));
  EXPECT_TRUE(contains(message_of("youngs_modulus=1,poisson_ratio=0.3,density=-1"), "density"));
  material::Material broken = material::parse_material("steel");
  broken.elastic.density = std::nan("");
  EXPECT_THROW(material::check_material(broken), core::InputError);
}

TEST(ParseMaterial, OwnMaterialsComeFirst) {
  material::Material own = material::parse_material("steel");
  own.elastic.density = 7900;
  EXPECT_EQ(material::parse_material("steel", {own}).elastic.density, 7900);
  own.name = "tool_steel";
  EXPECT_TRUE(contains(message_of("tool_stel", {own}), "did you mean \"tool_steel\"?"));
}

TEST(ReadMaterials, ReadsNamesAndFieldsInOrder) {
  const MaterialFile file(
      "bell_bronze:\n"
      "  youngs_modulus: 100 GPa\n"
      "  poisson_ratio: 0.34\n"
      "  density: 8600 kg/m^3\n"
      "  alpha1: 2\n"
      "  alpha2: 1e-8 s\n"
      "  group: metal\n"
      "  citation: foundry's data sheet\n"
      "aerogel: {youngs_modulus: 1e6, poisson_ratio: 0.2, density: 100}\n");
  const std::vector<material::Material> materials = material::read_materials(file.path());
  ASSERT_EQ(materials.size(), 2u);
  EXPECT_EQ(materials[0].name, "bell_bronze");
  EXPECT_NEAR(materials[0].elastic.youngs_modulus, 1e11, 1);
  EXPECT_EQ(materials[0].damping.parameters[0], 2);
  EXPECT_EQ(materials[0].source, "foundry's data sheet");
  EXPECT_EQ(materials[0].group, "metal");
  EXPECT_EQ(materials[1].damping.parameters[1], 0);
  EXPECT_EQ(material::parse_material("aerogel", materials).elastic.density, 100);
}

TEST(PresetMaterials, EachLooksLikeWhatItIs) {
  const Vec3 unknown = render::looks::Appearance{}.color;
  for (const material::Material& preset : material::preset_materials()) {
    const render::looks::Appearance look = material::appearance_of(preset);
    EXPECT_NE(look.color, unknown) << preset.name;
    EXPECT_EQ(look.metallic, preset.group == "metal" ? 1 : 0) << preset.name;
    const bool wooden = preset.group == "wood" && preset.name != "chipboard";
    EXPECT_EQ(look.grain == render::looks::Grain::wood, wooden) << preset.name;
    if (preset.group == "glass") EXPECT_GT(look.transmission, 0.2) << preset.name;
    if (preset.group == "rubber") EXPECT_GT(look.roughness, 0.6) << preset.name;
  }
}

TEST(ReadMaterials, HaveTheLooksThatTheyStateElseThoseOfTheirName) {
  const core::TemporaryFolder folder;
  const std::string path = folder / "own.yaml";
  std::ofstream(path)
      << "brushed_steel: {youngs_modulus: 2e11, poisson_ratio: 0.3, density: 7800,\n"
         "                appearance: {roughness: 0.6}}\n"
         "lid: {youngs_modulus: 2e9, poisson_ratio: 0.3, density: 1000, group: plastic}\n";
  const auto own = material::read_materials(path);
  ASSERT_TRUE(own[0].appearance);
  const render::looks::Appearance brushed = material::appearance_of(own[0]);
  EXPECT_EQ(brushed.roughness, 0.6);
  EXPECT_EQ(brushed.color, render::looks::appearance_of("steel").color);
  EXPECT_FALSE(own[1].appearance);
  EXPECT_EQ(material::appearance_of(own[1]).color,
            render::looks::appearance_of("", "plastic").color);
  std::ofstream(path) << "lid: {youngs_modulus: 2e9, poisson_ratio: 0.3, density: 1000,\n"
                         "      appearance: {colour: [1, 0, 0]}}\n";
  try {
    material::read_materials(path);
    FAIL() << "accepted";
  } catch (const core::ConfigError& error) {
    EXPECT_TRUE(contains(error.what(), "own.yaml:2:")) << error.what();
    EXPECT_TRUE(contains(error.what(), "base_colour")) << error.what();
  }
}

TEST(ReadMaterials, PointsAtTheLine) {
  const std::string unknown = file_error(
      "m:\n  youngs_modulus: 1 GPa\n  poisson_ratio: 0.3\n  density: 1000\n  alpa1: 3\n");
  EXPECT_TRUE(contains(unknown, ".yaml:5:3")) << unknown;
  EXPECT_TRUE(contains(unknown, "alpha1")) << unknown;
  const std::string unphysical =
      file_error("m:\n  youngs_modulus: 1 GPa\n  poisson_ratio: 0.6\n  density: 1000\n");
  EXPECT_TRUE(contains(unphysical, ".yaml:3:")) << unphysical;
  const std::string group =
      file_error("m: {youngs_modulus: 1e9, poisson_ratio: 0, density: 1,\n  group: metall}\n");
  EXPECT_TRUE(contains(group, ".yaml:2:")) << group;
  EXPECT_TRUE(contains(group, "did you mean \"metal\"?")) << group;
  EXPECT_TRUE(contains(unphysical, "Poisson")) << unphysical;
  EXPECT_TRUE(
      contains(file_error("m:\n  youngs_modulus: 1 GPa\n  density: 1000\n"), "poisson_ratio"));
  EXPECT_TRUE(contains(
      file_error("a=b: {youngs_modulus: 1e9, poisson_ratio: 0.3, density: 1000}\n"), "name"));
}

TEST(ReadMaterials, RefusesNamesThatLeaveAFolder) {
  const auto error_of = [](const std::string& name) {
    return file_error(name + ": {youngs_modulus: 1e9, poisson_ratio: 0.3, density: 1000}\n");
  };
  for (const char* name : {"..", ".", "../clay", "clay/red"}) {
    EXPECT_TRUE(contains(error_of(name), "must not contain \"/\"")) << name;
  }
  EXPECT_EQ(error_of("Messing-ä"), "no error");
  EXPECT_EQ(error_of("clay..red"), "no error");
}

TEST(ParseMaterial, TakesAnyDampingModel) {
  const std::string elastic = "youngs_modulus=70 GPa,poisson_ratio=0.2,density=2500,";
  const auto damping = [&](const std::string& text) {
    return material::parse_material(elastic + text).damping;
  };
  EXPECT_EQ(damping("alpha3=1.027,damping=hybrid,alpha1=3.9,alpha2=5.2e-9"),
            material::parse_material("sterling_porcelain_hybrid").damping);
  EXPECT_EQ(damping("damping=caughey,alpha1=420,alpha2=-2.4e-6,alpha3=3.8e-15"),
            material::parse_material("gpd_porcelain_caughey").damping);
  EXPECT_EQ(damping("alpha2=2 s"), damping::rayleigh_damping(0, 2));
  EXPECT_EQ(damping("damping=6 + 1e-7*lambda").expression, "6 + 1e-7*lambda");
  // Commas within parentheses and comparisons belong to the formula.
  EXPECT_EQ(damping("damping=max(6, alpha1*f),alpha1=0.1").expression, "max(6, alpha1*f)");
  EXPECT_EQ(damping("damping=f >= 100 ? 3 : 4").expression, "f >= 100 ? 3 : 4");
}

TEST(ParseMaterial, NamesWhatIsWrongWithTheDamping) {
  const auto message = [](const std::string& text) {
    return message_of("youngs_modulus=70 GPa,poisson_ratio=0.2,density=2500," + text);
  };
  EXPECT_TRUE(contains(message("damping=hybird"), "did you mean \"hybrid\"?"));
  EXPECT_TRUE(contains(message("damping="), "no formula"));
  EXPECT_TRUE(contains(message("damping=power,alpha1=1"), "power damping lacks alpha2"));
  EXPECT_TRUE(contains(message("alpha1=1,alpha2=0,alpha3=0"), "no alpha3"));
  EXPECT_TRUE(contains(message("damping=hybrid,alpha1=1,alpha2=1,alpha3=x"), "alpha3"));
  EXPECT_TRUE(contains(message("alpha1=1,alpha1=2"), "given twice"));
  EXPECT_TRUE(contains(message("dampin=6"), "did you mean \"damping\"?"));
  EXPECT_TRUE(contains(message("damping=hybrid,alpha1=1,alpha2=1 s,alpha3=1"), "alpha2"));
}

TEST(ReadMaterials, TakesAnyDampingModel) {
  const std::string elastic = "  youngs_modulus: 1 GPa\n  poisson_ratio: 0.3\n  density: 1000\n";
  const MaterialFile file("nested:\n" + elastic +
                          "  damping: {model: hybrid, alpha1: 1, alpha2: 2e-7, alpha3: 0.9}\n"
                          "flat:\n" +
                          elastic + "  damping: power\n  alpha1: 0.2\n  alpha2: 0.37\n" +
                          "formula:\n" + elastic + "  damping: 6 + 1e-7*lambda\n" + "number:\n" +
                          elastic + "  damping: 6\n" + "long:\n" + elastic +
                          "  damping: {model: caughey, alpha1: 1, alpha2: 1 us, alpha3: 0, "
                          "alpha4: 1e-30}\n" +
                          "own:\n" + elastic +
                          "  damping: {model: \"alpha1*sqrt(f)\", alpha1: 3}\n");
  const std::vector<material::Material> materials = material::read_materials(file.path());
  ASSERT_EQ(materials.size(), 6u);
  EXPECT_EQ(materials[0].damping,
            (damping::DampingModel{damping::DampingKind::hybrid, {1, 2e-7, 0.9}, ""}));
  EXPECT_EQ(materials[1].damping,
            (damping::DampingModel{damping::DampingKind::power, {0.2, 0.37}, ""}));
  EXPECT_EQ(materials[2].damping,
            (damping::DampingModel{damping::DampingKind::expression, {}, "6 + 1e-7*lambda"}));
  EXPECT_EQ(materials[3].damping,
            (damping::DampingModel{damping::DampingKind::expression, {}, "6"}));
  EXPECT_EQ(materials[4].damping,
            (damping::DampingModel{damping::DampingKind::caughey, {1, 1e-6, 0, 1e-30}, ""}));
  EXPECT_EQ(materials[5].damping,
            (damping::DampingModel{damping::DampingKind::expression, {3}, "alpha1*sqrt(f)"}));
}

TEST(ReadMaterials, PointsAtTheDampingThatIsWrong) {
  const auto error = [](const std::string& damping) {
    return file_error("m:\n  youngs_modulus: 1 GPa\n  poisson_ratio: 0.3\n  density: 1000\n" +
                      damping);
  };
  const std::string formula = error("  damping: 6 + 1e-7*lamda\n");
  EXPECT_TRUE(contains(formula, ".yaml:5:")) << formula;
  EXPECT_TRUE(contains(formula, "at character 10; did you mean \"lambda\"?")) << formula;
  const std::string nested = error("  damping:\n    model: hybrid\n    alpha1: 1\n");
  EXPECT_TRUE(contains(nested, ".yaml:6:")) << nested;
  EXPECT_TRUE(contains(nested, "hybrid damping lacks alpha2")) << nested;
  const std::string negative = error("  damping: {model: rayleigh, alpha1: 1,\n    alpha2: -1}\n");
  EXPECT_TRUE(contains(negative, ".yaml:6:")) << negative;
  EXPECT_TRUE(contains(negative, "alpha2 must not be negative")) << negative;
  const std::string beside = error("  damping: {model: rayleigh}\n  alpha1: 3\n");
  EXPECT_TRUE(contains(beside, ".yaml:6:")) << beside;
  EXPECT_TRUE(contains(error("  damping: {modl: rayleigh}\n"), "model"));
  EXPECT_TRUE(contains(error("  alpha3: 3\n"), "no alpha3"));
}

TEST(T60, FollowsFromDamping) {
  const double omega = 2 * M_PI * 3000;
  const double d = (6 + 1e-7 * omega * omega) / 2;
  EXPECT_NEAR(modal::t60(d) * d, std::log(1000.0), 1e-12);
}

}  // namespace
}  // namespace carillon::synth
