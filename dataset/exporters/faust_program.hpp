#pragma once

#include <span>
#include <string>
#include <vector>

#include "solvers/modes/modes.hpp"
#include "synth/material/material.hpp"

namespace carillon::dataset::exporters {

/// A number of each mode, as a table of the program.
struct FaustColumn {
  std::string name;
  std::vector<double> values;
};

/// How decay rates follow from a program's sliders.
struct FaustDamping {
  std::string definitions;           ///< sliders, and `rate`: of the columns, then of lambda
  std::vector<FaustColumn> columns;  ///< what `rate` takes of each mode beside lambda
};

/// Rayleigh damping gets a slider for each of its parameters: their values, or, of objects of
/// several regions, factors of them. The other formulas of one region are written out; of what
/// else there is (expressions, other models in several regions) the rates are stored, and do not
/// follow size and pitch.
/// @param rates  of the modes [1/s], as they are without any slider
FaustDamping faust_damping(const solvers::modes::Modes& modes,
                           std::span<const synth::material::Material> materials,
                           std::span<const double> rates);

/// One mode of a program.
struct FaustMode {
  double eigenvalue = 0;        ///< lambda [rad^2/s^2]
  std::vector<double> damping;  ///< its values of FaustDamping::columns
  /// Velocity of the struck point along its normal per impulse on it, one value for each point
  /// [m/s per N s].
  std::vector<double> gains;
  std::string remark;
};

/// Contacts that a program's strikes may last [s].
constexpr double shortest_contact = 1e-6, longest_contact = 1;

/// What a Faust program of one object is made from.
struct FaustProgram {
  std::string name;
  std::vector<std::string> remarks;          ///< lines of the header
  std::vector<Vec3> points;                  ///< that can be struck, the vertices [m]
  double impulse = 0;                        ///< of a strike, at first [N s]
  double contact_time = 0;                   ///< likewise [s]
  double gain = 1;                           ///< likewise, full scale per m/s
  double own_pitch = 0;                      ///< frequency that `freq` replaces [Hz]
  std::string damping;                       ///< FaustDamping::definitions
  std::vector<std::string> damping_columns;  ///< names of FaustDamping::columns
  std::vector<FaustMode> modes;
};

/// The program's text: `process` with the parameters of a note (`freq`, `gain`, `gate`) and an
/// input for forces [N], and `object(vertex, force)` for other programs. docs/exports.md says what
/// it computes. Its output is as many samples late as there are modes.
std::string faust_text(const FaustProgram& program);

/// A number as Faust reads it, all digits kept; never an integer, which would overflow.
std::string faust_number(double value);

/// A slider at a value; its range is widened to hold that.
/// @param low, high  positive where `scale` is logarithmic
std::string faust_slider(const std::string& label, double value, double low, double high);

}  // namespace carillon::dataset::exporters
