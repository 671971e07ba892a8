#include "core/hdf5_compare.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>

#include "core/hdf5.hpp"

namespace carillon::core {

namespace {

/// Names that are in one map alone, or in both with other values.
template <class Map, class Tell>
void compare_maps(const Map& here, const Map& expected, const Tell& tell) {
  for (const auto& [name, value] : expected) {
    const auto found = here.find(name);
    if (found == here.end()) {
      tell(name, "is missing");
    } else if (found->second != value) {
      tell(name, fmt::format("is {}, not {}", found->second, value));
    }
  }
  for (const auto& [name, value] : here) {
    if (!expected.contains(name)) tell(name, "does not belong there");
  }
}

std::string text_of(const VirtualSource& source) {
  return fmt::format("{} rows of {}:{}", source.rows, source.file, source.dataset);
}

class Comparison {
 public:
  std::vector<std::string> lines;

  void groups(const Hdf5Group& here, const Hdf5Group& expected, const std::string& above) {
    attributes(here, expected, ".", above);
    std::map<std::string, std::string> own = kinds(here), wanted = kinds(expected);
    compare_maps(own, wanted, [&](const std::string& name, const std::string& what) {
      lines.push_back(fmt::format("{}{}: {}", above, name, what));
    });
    for (const auto& [name, kind] : wanted) {
      if (!own.contains(name) || own.at(name) != kind) continue;
      if (kind == "group") {
        groups(here.open_group(name), expected.open_group(name), above + name + "/");
      } else {
        attributes(here, expected, name, above);
        arrays(here, expected, name, kind, above);
      }
    }
  }

 private:
  /// What each member of a group is.
  static std::map<std::string, std::string> kinds(const Hdf5Group& group) {
    std::map<std::string, std::string> kinds;
    for (const std::string& name : group.names()) {
      kinds[name] = group.is_group(name) ? "group"
                                         : fmt::format("{}[{}]", group.element_type(name),
                                                       fmt::join(group.extent(name), ", "));
    }
    return kinds;
  }

  void attributes(const Hdf5Group& here, const Hdf5Group& expected, const std::string& object,
                  const std::string& above) {
    compare_maps(here.attributes(object), expected.attributes(object),
                 [&](const std::string& name, const std::string& what) {
                   lines.push_back(
                       fmt::format("{}{}@{}: {}", above, object == "." ? "" : object, name, what));
                 });
  }

  void arrays(const Hdf5Group& here, const Hdf5Group& expected, const std::string& name,
              const std::string& kind, const std::string& above) {
    const auto sources = here.virtual_sources(name), wanted = expected.virtual_sources(name);
    std::string what;
    if (sources.size() != wanted.size()) {
      what = fmt::format("joins {} files, not {}", sources.size(), wanted.size());
    } else if (!wanted.empty()) {
      const auto [own, other] = std::mismatch(sources.begin(), sources.end(), wanted.begin());
      if (own == sources.end()) return;
      what = fmt::format("block {} is {}, not {}", own - sources.begin(), text_of(*own),
                         text_of(*other));
    } else if (kind.starts_with("text")) {
      what = values<std::string>(here, expected, name);
    } else if (kind.starts_with("float")) {
      what = values<double>(here, expected, name);
    } else if (kind.starts_with("int")) {
      what = values<std::int64_t>(here, expected, name);
    } else if (kind.starts_with("uint")) {
      what = values<std::uint64_t>(here, expected, name);
    } else {
      what = "holds what cannot be compared";
    }
    if (!what.empty()) lines.push_back(fmt::format("{}{}: {}", above, name, what));
  }

  template <class T>
  static std::string values(const Hdf5Group& here, const Hdf5Group& expected,
                            const std::string& name) {
    const std::vector<T> own = here.read<T>(name), wanted = expected.read<T>(name);
    const auto same = [](const T& a, const T& b) { return a == b || (a != a && b != b); };
    const auto [value, other] = std::mismatch(own.begin(), own.end(), wanted.begin(), same);
    if (value == own.end()) return "";
    const Extent extent = here.extent(name);
    const std::size_t rows = extent.empty() ? 1 : extent.front();
    const auto row = static_cast<std::size_t>(value - own.begin()) / (own.size() / rows);
    return fmt::format("row {} is {}, not {}", row, *value, *other);
  }
};

}  // namespace

std::vector<std::string> compare_hdf5(const std::filesystem::path& file,
                                      const std::filesystem::path& expected) {
  Comparison comparison;
  comparison.groups(Hdf5Group::open_file(file), Hdf5Group::open_file(expected), "");
  return comparison.lines;
}

}  // namespace carillon::core
