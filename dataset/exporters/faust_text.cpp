#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "core/numbers.hpp"
#include "core/revision.hpp"
#include "dataset/exporters/detail/faust_parts.hpp"
#include "dataset/exporters/faust_program.hpp"

namespace carillon::dataset::exporters {

std::string faust_number(double value) {
  std::string text = fmt::format("{}", value);
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

std::string faust_slider(const std::string& label, double value, double low, double high) {
  // Twelve digits are more than a slider's own, and hide the rounding of a unit's factor.
  return fmt::format("hslider(\"{}\", {:.12g}, {:.12g}, {:.12g}, {:.1g})", label, value,
                     std::min(low, value), std::max(high, value), (high - low) * 1e-6);
}

namespace {

/// A text without what would end a comment or a string of Faust's.
std::string plain(std::string text) {
  for (char& letter : text) {
    if (letter == '"' || letter == '\\') letter = '\'';
    if (static_cast<unsigned char>(letter) < ' ') letter = ' ';
  }
  return text;
}

std::string header(const FaustProgram& program) {
  std::string text = fmt::format("// {}\n//\n", plain(program.name));
  for (const std::string& remark : program.remarks) {
    text += remark.empty() ? "//\n" : fmt::format("// {}\n", plain(remark));
  }
  text += R"(//
// process: an instrument with the parameters of a note, `freq`, `gain` and `gate`, and an input for
// any other force on the vertex [N]; the output is the velocity of the struck vertex along its
// outward normal [m/s], times the level. A force points inward. `object(vertex, force)`, in other
// programs: component("FILE.dsp").object.
//
// This instrument is its maker's own: the licence of Carillon does not extend to it, and what Carillon
// puts into this text is free for any use (CC0 1.0). The shape may have an author of its own.

)";
  text += fmt::format("declare name \"{}\";\n", plain(program.name));
  text += fmt::format(
      "declare description \"Modes of a struck object\";\n"
      "declare version \"{0}\";\n"
      "declare author \"Carillon {0}\";\n",
      core::version());
  text +=
      "declare license \"its maker's own; what Carillon puts into it is CC0-1.0\";\n"
      "declare options \"[midi:on][nvoices:8]\";\n\n"
      "import(\"stdfaust.lib\");\n";
  return text;
}

std::string sliders(const FaustProgram& program) {
  const double milliseconds = 1000 * program.contact_time;
  const double last = static_cast<double>(program.points.size() - 1);
  std::string text = "\n// ---- What can be set\n\n";
  text += fmt::format("freq = {};\n", faust_slider("v:note/[1]freq[unit:Hz][scale:log]",
                                                   program.own_pitch, 20, 20000));
  text += "gain = hslider(\"v:note/[2]gain\", 1, 0, 1, 0.001);\n";
  text += "gate = button(\"v:note/[3]gate\");\n";
  text += fmt::format("impulse = gain*{};\n",
                      faust_slider("v:strike/[1]impulse[unit:N s][scale:log]", program.impulse,
                                   program.impulse / 100, program.impulse * 100));
  text += fmt::format(
      "impactTime = {}/1000;\n",
      faust_slider("v:strike/[2]contact time[unit:ms][scale:log]", milliseconds, 0.02, 20));
  text += fmt::format("hardness = max(1e-6, {});\n",
                      faust_slider("v:strike/[3]hardness[scale:log]", 1, 0.01, 100));
  text += fmt::format("contactTime = max({}, min({}, impactTime*pow(hardness, 0 - 0.4)));\n",
                      shortest_contact, longest_contact);
  text += fmt::format("vertex = nentry(\"v:object/[1]vertex\", 0, 0, {}, 1);\n", last);
  text += fmt::format("size = max(1e-3, min(1000, {}));\n",
                      faust_slider("v:object/[2]size[scale:log]", 1, 0.25, 4));
  text += fmt::format("pitch = max(1e-3, min(1000, freq/{:.12g}/size));\n", program.own_pitch);
  text += program.damping;
  text += fmt::format("t60_factor = max(1e-3, {});\n",
                      faust_slider("v:object/[5]t60_factor[scale:log]", 1, 0.01, 100));
  text +=
      fmt::format("level = ba.db2linear(min(200, {}));\n",
                  faust_slider("level[unit:dB]", core::amplitude_decibels(program.gain), -60, 60));
  return text;
}

/// A table of one number of each mode, told one a line by `remark`.
std::string table(const std::string& name, std::span<const FaustMode> modes,
                  const std::function<double(const FaustMode&)>& number,
                  const std::function<std::string(const FaustMode&)>& remark) {
  std::string text = name + " = waveform{\n";
  for (const FaustMode& mode : modes) {
    const bool last = &mode == &modes.back();
    text += fmt::format("  {}{}{}\n", faust_number(number(mode)), last ? "" : ",", remark(mode));
  }
  return text + "};\n";
}

/// Eigenvalues, what the damping needs, and the gains, one vertex after the other.
std::string tables(const FaustProgram& program) {
  const auto silent = [](const FaustMode&) { return std::string(); };
  std::string text = "\n// ---- The modes: eigenvalues [rad^2/s^2]\n\n";
  text += fmt::format("modes = {};\n", program.modes.size());
  text += table(
      "eigenvalues", program.modes, [](const FaustMode& mode) { return mode.eigenvalue; },
      [](const FaustMode& mode) { return "  // " + mode.remark; });
  for (std::size_t column = 0; column < program.damping_columns.size(); ++column) {
    text += table(
        program.damping_columns[column], program.modes,
        [&](const FaustMode& mode) { return mode.damping[column]; }, silent);
  }
  text += "\n// Gains of the modes at each vertex [m/s per N s].\ngains = waveform{\n";
  for (std::size_t point = 0; point < program.points.size(); ++point) {
    text += fmt::format("  // vertex {}\n", point);
    for (const FaustMode& mode : program.modes) {
      const bool last = point + 1 == program.points.size() && &mode == &program.modes.back();
      text += fmt::format("  {}{}\n", faust_number(mode.gains[point]), last ? "" : ",");
    }
  }
  return text + "};\n";
}

/// How the parts read the tables.
std::string readings(const FaustProgram& program) {
  std::string rate;
  for (const std::string& column : program.damping_columns) rate += fmt::format("of({}), ", column);
  return fmt::format(
      "\nnext = (+(1) : %(modes)) ~ _;  // the mode that is computed in this sample\n"
      "of(values) = values, next : rdtable;\n"
      "eigenvalue = of(eigenvalues);\n"
      "gainAt(vertex) = gains, int(max(0, min({}, vertex)))*modes + next : rdtable;\n"
      "rateAt(lambda) = rate({}lambda);\n",
      program.points.size() - 1, rate);
}

}  // namespace

std::string faust_text(const FaustProgram& program) {
  return header(program) + sliders(program) + tables(program) + readings(program) + faust_parts;
}

}  // namespace carillon::dataset::exporters
