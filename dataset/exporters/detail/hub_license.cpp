#include "dataset/exporters/detail/hub_license.hpp"

#include <cctype>
#include <regex>
#include <set>

namespace carillon::dataset::exporters {

namespace {

/// The Hub's identifiers of licences that data are given under
/// (https://huggingface.co/docs/hub/repositories-licenses).
const std::set<std::string> hub_licenses = {"afl-3.0",
                                            "agpl-3.0",
                                            "apache-2.0",
                                            "artistic-2.0",
                                            "bsd",
                                            "bsd-2-clause",
                                            "bsd-3-clause",
                                            "bsd-3-clause-clear",
                                            "bsl-1.0",
                                            "c-uda",
                                            "cc",
                                            "cc-by-2.0",
                                            "cc-by-2.5",
                                            "cc-by-3.0",
                                            "cc-by-4.0",
                                            "cc-by-nc-2.0",
                                            "cc-by-nc-3.0",
                                            "cc-by-nc-4.0",
                                            "cc-by-nc-nd-3.0",
                                            "cc-by-nc-nd-4.0",
                                            "cc-by-nc-sa-2.0",
                                            "cc-by-nc-sa-3.0",
                                            "cc-by-nc-sa-4.0",
                                            "cc-by-nd-4.0",
                                            "cc-by-sa-3.0",
                                            "cc-by-sa-4.0",
                                            "cc0-1.0",
                                            "cdla-permissive-1.0",
                                            "cdla-permissive-2.0",
                                            "cdla-sharing-1.0",
                                            "ecl-2.0",
                                            "epl-1.0",
                                            "epl-2.0",
                                            "etalab-2.0",
                                            "eupl-1.1",
                                            "eupl-1.2",
                                            "gfdl",
                                            "gpl",
                                            "gpl-2.0",
                                            "gpl-3.0",
                                            "isc",
                                            "lgpl",
                                            "lgpl-2.1",
                                            "lgpl-3.0",
                                            "mit",
                                            "mpl-2.0",
                                            "ms-pl",
                                            "ncsa",
                                            "odbl",
                                            "odc-by",
                                            "ofl-1.1",
                                            "osl-3.0",
                                            "other",
                                            "pddl",
                                            "postgresql",
                                            "unknown",
                                            "unlicense",
                                            "wtfpl",
                                            "zlib"};

/// What the Hub has for an SPDX identifier or an address of Creative Commons.
std::string hub_name(const std::string& license) {
  static const std::regex commons(
      R"(https?://creativecommons\.org/(licenses|publicdomain)/([a-z-]+)/([0-9.]+)(/.*)?)");
  static const std::regex variant("-(only|or-later)$"), version("^(odbl|odc-by|pddl)-1\\.0$");
  std::string name;
  for (const char letter : license) {
    name += static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
  }
  std::smatch match;
  if (std::regex_match(name, match, commons)) {
    const std::string kind = match[2];
    return (kind == "zero" ? "cc0" : "cc-" + kind) + "-" + match[3].str();
  }
  name = std::regex_replace(name, variant, "");
  return std::regex_replace(name, version, "$1");
}

}  // namespace

HubLicense hub_license(const std::string& license) {
  if (license.empty()) return {"unknown", "", ""};
  std::string name = hub_name(license);
  if (hub_licenses.contains(name)) return {name, "", ""};
  const bool address = license.starts_with("http://") || license.starts_with("https://");
  if (address) return {"other", "see-link", license};
  name = std::regex_replace(name, std::regex("[^a-z0-9.+-]+"), "-");
  return {"other", name, ""};
}

}  // namespace carillon::dataset::exporters
