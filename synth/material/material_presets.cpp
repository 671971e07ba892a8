#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "solvers/elements/anisotropy.hpp"
#include "synth/material/material.hpp"

namespace carillon::synth::material {

namespace {

constexpr const char* hiner_table = "Hiner 2024, Table 1 (after Wang and James 2019, Table 4)";

Material hiner(std::string name, double density, double youngs_modulus, double poisson_ratio,
               double alpha1, double alpha2) {
  return {std::move(name),
          {youngs_modulus, poisson_ratio, density},
          damping::rayleigh_damping(alpha1, alpha2),
          hiner_table};
}

/// An object of Sterling's tables: what the tables give of it, and what handbooks complete.
struct Sample {
  std::string name;
  solvers::elements::Elastic elastic;
  std::string table;     ///< of the damping
  std::string again;     ///< where else it is printed
  std::string handbook;  ///< which elastic constants are whose
};

using Alphas = std::vector<double>;

Material row(const Sample& sample, const char* suffix, damping::DampingKind kind, Alphas alphas) {
  return {sample.name + suffix,
          sample.elastic,
          {kind, std::move(alphas), ""},
          fmt::format("damping: {}, {} row ({}); {}", sample.table, damping::form_of(kind).name,
                      sample.again, sample.handbook)};
}

/// Two rows of Sterling 2019, Table 4.1; the same as Table 1 of the article with Rewkowski, Klatzky
/// and Lin, where the hybrid's alphas are called gamma.
void add_sterling(std::vector<Material>& presets, const std::string& name,
                  const solvers::elements::Elastic& elastic, const std::string& handbook,
                  const Alphas& rayleigh, const Alphas& hybrid) {
  const Sample sample{"sterling_" + name, elastic, "Sterling 2019, Table 4.1",
                      "also Sterling, Rewkowski, Klatzky and Lin 2019, Table 1",
                      "elastic constants are handbook values, not the object's: " + handbook};
  presets.push_back(row(sample, "", damping::DampingKind::rayleigh, rayleigh));
  presets.push_back(row(sample, "_hybrid", damping::DampingKind::hybrid, hybrid));
}

/// Three rows of Sterling 2019, Table 3.1; the same as Table 1.1 of the chapter with Lin.
void add_gpd(std::vector<Material>& presets, const std::string& name,
             const solvers::elements::Elastic& elastic, const std::string& handbook,
             const Alphas& rayleigh, const Alphas& caughey, const Alphas& power) {
  const Sample sample{"gpd_" + name, elastic, "Sterling 2019, Table 3.1",
                      "also Sterling and Lin 2016, Table 1.1", handbook};
  presets.push_back(row(sample, "", damping::DampingKind::rayleigh, rayleigh));
  presets.push_back(row(sample, "_caughey", damping::DampingKind::caughey, caughey));
  presets.push_back(row(sample, "_power", damping::DampingKind::power, power));
}

constexpr const char* porcelain =
    "dense siliceous porcelain, IEC 60672-3 type C 110 (at least 60 GPa and 2200 "
    "kg/m^3), whitewares 67 to 150 GPa, nu 0.17, 2300 to 3000 kg/m^3";
constexpr const char* oak =
    "northern red oak along the grain at 12 % moisture, taken as isotropic (Forest "
    "Products Laboratory, Wood Handbook, tables of mechanical properties)";
constexpr const char* acrylic =
    "acrylic (PMMA) as a rigid clear plastic, 2.2 to 3.8 GPa, 1160 to 1220 kg/m^3 "
    "(Ashby, Materials Selection in Mechanical Design, appendix)";

/// Hiner's table, which lacks nothing.
std::vector<Material> hiner_rows() {
  return {
      hiner("ceramic", 2700, 7.2e10, 0.19, 6, 1e-7),
      hiner("glass", 2600, 6.2e10, 0.20, 1, 1e-7),
      hiner("wood", 750, 1.1e10, 0.25, 60, 2e-6),
      hiner("plastic", 1070, 1.4e9, 0.35, 30, 1e-6),
      hiner("iron", 8000, 2.1e11, 0.28, 5, 1e-7),
      hiner("polycarbonate", 1190, 2.4e9, 0.37, 0.5, 4e-7),
      hiner("steel", 7850, 2.0e11, 0.29, 5, 3e-8),
  };
}

void add_sterling_rows(std::vector<Material>& presets) {
  add_sterling(presets, "porcelain", {7.0e10, 0.17, 2400}, porcelain, {3.9, 1e-8},
               {3.9, 5.2e-9, 1.027});
  add_sterling(presets, "travertine", {4.0e10, 0.25, 2400},
               "travertine at least 2305 kg/m^3 (ASTM C1527), intact limestone 15 to 55 GPa and "
               "nu 0.2 to 0.3",
               {1.3, 2.5e-8}, {1.3, 2.5e-8, 1.001});
  add_sterling(presets, "wood", {1.25e10, 0.35, 700}, oak, {39.0, 1.3e-7}, {39.0, 2.1e-7, 0.978});
  add_sterling(presets, "steel", {2.0e11, 0.29, 7850},
               "low-carbon steel, 200 to 215 GPa, 7800 to 7900 kg/m^3 (Ashby, Materials Selection "
               "in Mechanical Design, appendix)",
               {2.3, 6.9e-8}, {2.4, 5.5e-8, 1.011});
  add_sterling(presets, "plastic", {3.0e9, 0.37, 1190}, acrylic, {39.8, 1.3e-7},
               {34.83, 4.1e-7, 0.95});
  add_sterling(presets, "glass", {7.0e10, 0.20, 2500}, "soda-lime silicate glass, EN 572-1",
               {2.0, 7.8e-8}, {1.9, 1.5e-7, 0.974});
}

void add_gpd_rows(std::vector<Material>& presets) {
  const std::string fitted =
      "Young's modulus is the table's, found together with the damping from one recording; nu and "
      "density are handbook values: ";
  add_gpd(presets, "plastic_1", {8.0e9, 0.37, 1190}, fitted + acrylic, {125, 8e-6},
          {280, -3.6e-7, 2.0e-15}, {1.13, 0.3});
  add_gpd(presets, "plastic_2", {2.4e9, 0.40, 1050},
          fitted +
              "ABS as a thin, tough plastic, 2.0 to 2.9 GPa, nu 0.394 to 0.422, 1020 to 1080 "
              "kg/m^3 (Granta Design, MaterialUniverse, ABS for extrusion)",
          {58, 1e-6}, {85, 6.6e-7, 5.6e-14}, {0.19, 0.37});
  add_gpd(presets, "porcelain", {2.0e10, 0.17, 2400}, fitted + porcelain, {189, 1.5e-8},
          {420, -2.4e-6, 3.8e-15}, {163, 0.01});
  add_gpd(presets, "wood", {9.9e9, 0.35, 700}, fitted + oak, {35, 4.6e-7}, {277, -2.0e-6, 4.8e-15},
          {6.7, 0.18});
  add_gpd(presets, "aluminum", {7.0e10, 0.33, 2700},
          "elastic constants are handbook values (the table's 0.88 GPa is no aluminium): aluminium "
          "alloys, 68 to 82 GPa, nu 0.33, 2500 to 2900 kg/m^3 (Ashby, Materials Selection in "
          "Mechanical Design, appendix)",
          {0.225, 1.45e-6}, {9.7, -3.4e-6, 5.8e-13}, {0.02, 0.445});
}

/// A species of the Wood Handbook: axes along the grain, across the growth rings, along them.
struct Species {
  const char* name;
  const char* english;
  double bending_modulus;         ///< at 12 % moisture, table 5-3 [Pa]
  double specific_gravity;        ///< the same
  std::array<double, 2> youngs;   ///< E_R and E_T over E_L, table 5-1
  std::array<double, 3> shear;    ///< G_RT, G_LT and G_LR over E_L, table 5-1
  std::array<double, 3> poisson;  ///< nu_RT, nu_LT, nu_LR, table 5-2
  const char* remark;
};

constexpr const char* no_rolling_shear =
    "; G_RT is not tabled, 0.02 E_L as of other hardwoods there";
constexpr std::array<Species, 3> species = {{
    {"spruce",
     "Sitka spruce",
     10.8e9,
     0.40,
     {0.078, 0.043},
     {0.003, 0.061, 0.064},
     {0.435, 0.467, 0.372},
     ""},
    {"maple",
     "sugar maple",
     12.6e9,
     0.63,
     {0.132, 0.065},
     {0.02, 0.063, 0.111},
     {0.774, 0.476, 0.424},
     no_rolling_shear},
    {"oak",
     "northern red oak",
     12.5e9,
     0.63,
     {0.154, 0.082},
     {0.02, 0.081, 0.089},
     {0.560, 0.448, 0.350},
     no_rolling_shear},
}};

/// Orthotropic woods with the damping of Hiner's.
void add_woods(std::vector<Material>& presets) {
  const damping::DampingModel damping =
      std::find_if(presets.begin(), presets.end(), [](const Material& m) {
        return m.name == "wood";
      })->damping;
  for (const Species& wood : species) {
    // Bending tests of the table include some shear: a tenth more along the grain.
    const double grain = 1.1 * wood.bending_modulus;
    const solvers::elements::EngineeringConstants constants = {
        {grain, wood.youngs[0] * grain, wood.youngs[1] * grain},
        wood.poisson,
        {wood.shear[0] * grain, wood.shear[1] * grain, wood.shear[2] * grain}};
    constexpr double moisture = 1.12, water = 1000;
    presets.push_back(
        {wood.name,
         solvers::elements::anisotropic(solvers::elements::orthotropic_stiffness(constants),
                                        moisture * water * wood.specific_gravity),
         damping,
         fmt::format(
             "{} at 12 % moisture: Forest Products Laboratory, Wood Handbook (2010), tables "
             "5-1 to 5-3, E_L a tenth above the bending modulus{}; damping: {}",
             wood.english, wood.remark, hiner_table)});
  }
}

}  // namespace

const std::vector<Material>& preset_materials() {
  static const std::vector<Material> presets = [] {
    std::vector<Material> rows = hiner_rows();
    add_sterling_rows(rows);
    add_gpd_rows(rows);
    add_woods(rows);
    return rows;
  }();
  return presets;
}

}  // namespace carillon::synth::material
