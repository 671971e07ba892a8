#include <fmt/format.h>

#include <algorithm>
#include <cmath>

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
// process: a strike by the button `strike`, and an input for any other force on the point [N]; the
// output is the velocity of the struck point along its outward normal [m/s], times the gain. A
// force points inward. `object(position, force)`, in other programs: component("FILE.dsp").object.
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
      "declare license \"its maker's own; what Carillon puts into it is CC0-1.0\";\n\n"
      "import(\"stdfaust.lib\");\n";
  return text;
}

std::string sliders(const FaustProgram& program) {
  const double milliseconds = 1000 * program.contact_time;
  const double last = static_cast<double>(program.points.size() - 1);
  std::string text = "\n// ---- What can be set\n\n";
  text += "strike = button(\"v:strike/[1]strike\");\n";
  text += fmt::format(
      "contactTime = max({}, min({}, {}/1000));\n", shortest_contact, longest_contact,
      faust_slider("v:strike/[2]contact time[unit:ms][scale:log]", milliseconds, 0.02, 20));
  text += fmt::format("impulse = {};\n",
                      faust_slider("v:strike/[3]impulse[unit:N s][scale:log]", program.impulse,
                                   program.impulse / 100, program.impulse * 100));
  text += fmt::format("position = nentry(\"v:object/[1]position\", 0, 0, {}, 1);\n", last);
  text += fmt::format("size = max(1e-3, min(1000, {}));\n",
                      faust_slider("v:object/[2]size[scale:log]", 1, 0.25, 4));
  text += program.damping;
  text +=
      fmt::format("gain = ba.db2linear(min(200, {}));\n",
                  faust_slider("gain[unit:dB]", core::amplitude_decibels(program.gain), -60, 60));
  return text;
}

std::string mode_line(const FaustMode& mode) {
  std::string gain = faust_number(mode.gains.front());
  if (mode.gains.size() > 1) {
    std::string values;
    for (const double value : mode.gains) {
      values += (values.empty() ? "" : ", ") + faust_number(value);
    }
    gain = fmt::format("at(position, waveform{{{}}})", values);
  }
  return fmt::format("  mode({}, {}, {})", faust_number(mode.eigenvalue), mode.rate, gain);
}

}  // namespace

std::string faust_text(const FaustProgram& program) {
  std::string text = header(program) + sliders(program) + faust_parts;
  text += fmt::format(
      "\n// ---- The object: eigenvalue [rad^2/s^2], decay rate, gain at each point [m/s per N "
      "s]\n\n"
      "at(position, values) = values, int(max(0, min({}, position))) : rdtable;\n\n"
      "bank(position) = _, _, _, _, _ <:\n",
      program.points.size() - 1);
  for (const FaustMode& mode : program.modes) {
    const bool last = &mode == &program.modes.back();
    text += fmt::format("{}{}  // {}\n", mode_line(mode), last ? "" : ",", mode.remark);
  }
  text += R"(  :> _;

object(position, force) = bank(position, 0, 0, 0, 0, force);
process(force) = bank(position, contact(strike > strike', impulse), force)*gain;
)";
  return text;
}

}  // namespace carillon::dataset::exporters
