#include "synth/material.hpp"

namespace carillon::synth {

namespace {

constexpr const char* kHiner = "Hiner 2024, Table 1 (after Wang and James 2019, Table 4)";

Material hiner(std::string name, double density, double youngs_modulus, double poisson_ratio,
               double alpha1, double alpha2) {
  return {std::move(name), {youngs_modulus, poisson_ratio, density}, {alpha1, alpha2}, kHiner};
}

/// Sterling's table gives the Rayleigh row only; the elastic constants are handbook values for the
/// kind of material the object was made of.
Material sterling(std::string name, double youngs_modulus, double poisson_ratio, double density,
                  double alpha1, double alpha2, const std::string& handbook) {
  return {std::move(name),
          {youngs_modulus, poisson_ratio, density},
          {alpha1, alpha2},
          "damping: Sterling 2019, Table 4.1, Rayleigh row; "
          "elastic constants are handbook values, not the object's: " +
              handbook};
}

}  // namespace

const std::vector<Material>& preset_materials() {
  static const std::vector<Material> presets = {
      hiner("ceramic", 2700, 7.2e10, 0.19, 6, 1e-7),
      hiner("glass", 2600, 6.2e10, 0.20, 1, 1e-7),
      hiner("wood", 750, 1.1e10, 0.25, 60, 2e-6),
      hiner("plastic", 1070, 1.4e9, 0.35, 30, 1e-6),
      hiner("iron", 8000, 2.1e11, 0.28, 5, 1e-7),
      hiner("polycarbonate", 1190, 2.4e9, 0.37, 0.5, 4e-7),
      hiner("steel", 7850, 2.0e11, 0.29, 5, 3e-8),
      sterling("sterling_porcelain", 7.0e10, 0.17, 2400, 3.9, 1e-8,
               "dense siliceous porcelain, IEC 60672-3 type C 110 (at least 60 GPa and 2200 "
               "kg/m^3), whitewares 67 to 150 GPa, nu 0.17, 2300 to 3000 kg/m^3"),
      sterling("sterling_travertine", 4.0e10, 0.25, 2400, 1.3, 2.5e-8,
               "travertine at least 2305 kg/m^3 (ASTM C1527), intact limestone 15 to 55 GPa and "
               "nu 0.2 to 0.3"),
      sterling("sterling_wood", 1.25e10, 0.35, 700, 39.0, 1.3e-7,
               "northern red oak along the grain at 12 % moisture, taken as isotropic (Forest "
               "Products Laboratory, Wood Handbook, tables of mechanical properties)"),
      sterling("sterling_steel", 2.0e11, 0.29, 7850, 2.3, 6.9e-8,
               "low-carbon steel, 200 to 215 GPa, 7800 to 7900 kg/m^3 (Ashby, Materials Selection "
               "in Mechanical Design, appendix)"),
      sterling("sterling_plastic", 3.0e9, 0.37, 1190, 39.8, 1.3e-7,
               "acrylic (PMMA) as a rigid clear plastic, 2.2 to 3.8 GPa, 1160 to 1220 kg/m^3 "
               "(Ashby, Materials Selection in Mechanical Design, appendix)"),
      sterling("sterling_glass", 7.0e10, 0.20, 2500, 2.0, 7.8e-8,
               "soda-lime silicate glass, EN 572-1"),
  };
  return presets;
}

}  // namespace carillon::synth
