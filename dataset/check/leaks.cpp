#include "dataset/check/leaks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "core/disjoint_sets.hpp"
#include "core/error.hpp"
#include "core/hdf5.hpp"
#include "dataset/samples/cast.hpp"
#include "dataset/samples/modes_task.hpp"
#include "solvers/mesh/shape_signature.hpp"
#include "solvers/modes/modes_file.hpp"

namespace carillon::dataset::check {

namespace {

constexpr const char* edited =
    "the build would not do this: were files edited or joined by hand? Build again into a new "
    "folder";

solvers::mesh::ShapeSignature signature_of_modes(const DatasetFolder& folder,
                                                 const plan::Shape& shape) {
  const auto path = samples::BuildFolders{folder.dataset.folder, ""}.modes_file(shape);
  if (!std::filesystem::is_regular_file(path)) return {};
  try {
    const core::Hdf5Group file = core::Hdf5Group::open_file(path);
    return solvers::mesh::shape_signature(
        solvers::modes::flatten(solvers::modes::read_mode_surface(file.open_group("set-000"))));
  } catch (const core::Error&) {
    return {};  // the checksums tell
  }
}

/// Shapes of the plan in sets of equal surfaces.
core::DisjointSets find_same_shapes(const DatasetFolder& folder) {
  const auto& shapes = folder.dataset.build.plan.shapes;
  core::DisjointSets same(shapes.size());
  solvers::mesh::SignatureIndex of_files, of_modes;
  for (std::size_t s = 0; s < shapes.size(); ++s) {
    same.join(s, of_files.add(shapes[s].signature));
    same.join(s, of_modes.add(signature_of_modes(folder, shapes[s])));
  }
  return same;
}

bool is_part(const std::string& part) {
  return part == "train" || part == "validation" || part == "test";
}

/// Shapes of a scene that moves which play in the simulations of their own part only.
std::set<std::string> held_out_shapes(const DatasetFolder& folder) {
  std::set<std::string> held;
  const configuration::BuildConfig& config = folder.dataset.build.config;
  const plan::BuildPlan& plan = folder.dataset.build.plan;
  if (!config.motion) return held;
  std::vector<bool> of_object;
  for (const configuration::ObjectSource& source : config.objects) {
    of_object.push_back(samples::held_out(config, plan, source.object.name));
  }
  for (const plan::Shape& shape : plan.shapes) {
    if (of_object[shape.source]) held.insert(shape.id);
  }
  return held;
}

}  // namespace

Finding check_split_shape(const DatasetFolder& folder, const std::vector<Row>& rows) {
  const auto& shapes = folder.dataset.build.plan.shapes;
  const std::set<std::string> held = held_out_shapes(folder);
  std::map<std::string, std::string> parts;
  std::vector<std::string> items;
  for (const Row& row : rows) {
    if (!is_part(row.split_shape)) {
      items.push_back(fmt::format("{}: \"{}\" is no part", row.key, row.split_shape));
    }
    // A simulation's own objects count where the configuration has enough of them to hold some out.
    const std::vector<std::string> own = row.simulation ? row.played : std::vector{row.shape};
    for (const std::string& shape : own) {
      if (row.simulation && !held.contains(shape)) continue;
      const auto [first, is_new] = parts.emplace(shape, row.split_shape);
      if (!is_new && first->second != row.split_shape) {
        items.push_back(fmt::format("{} is in {} and, at {}, in {}", shape, first->second, row.key,
                                    row.split_shape));
      }
    }
  }
  core::DisjointSets same = find_same_shapes(folder);
  std::size_t distinct = 0;
  for (std::size_t s = 0; s < shapes.size(); ++s) {
    const std::size_t first = same.find(s);
    distinct += first == s && parts.contains(shapes[s].id) ? 1 : 0;
    const auto here = parts.find(shapes[s].id), there = parts.find(shapes[first].id);
    if (here == parts.end() || there == parts.end() || here->second == there->second) continue;
    // Copies between given parts are theirs who gave them.
    const std::string &one = shapes[s].given_part, &other = shapes[first].given_part;
    if (!one.empty() && !other.empty() && one != other) continue;
    items.push_back(fmt::format("{} ({}) and {} ({}) are the same shape", shapes[first].id,
                                there->second, shapes[s].id, here->second));
  }
  for (const plan::Shape& shape : shapes) {
    const auto here = parts.find(shape.id);
    if (here != parts.end() && here->second != shape.split_shape) {
      items.push_back(fmt::format("{} is in {}, the configuration puts it in {}", shape.id,
                                  here->second, shape.split_shape));
    }
  }
  const std::string held_text =
      fmt::format("{} shapes, {} of them distinct, none in two parts", parts.size(), distinct);
  return judged("split_shape", std::move(items),
                folder.dataset.build.config.motion
                    ? fmt::format("{} simulations of {} shapes; held out: {}", rows.size(),
                                  shapes.size(), held_text)
                    : held_text,
                "a shape is in two parts, or not where it should be",
                "name the same shape once in objects, or remove the copies; then build into a new "
                "folder");
}

Finding check_split_strike(const DatasetFolder& folder, const std::vector<Row>& rows) {
  struct Strike {
    std::string part;
    Vec3 point;
    std::int64_t number;
  };
  std::map<std::pair<std::string, std::int64_t>, Strike> strikes;
  std::vector<std::string> items;
  for (const Row& row : rows) {
    if (!is_part(row.split_strike)) {
      items.push_back(fmt::format("{}: \"{}\" is no part", row.key, row.split_strike));
    }
    const auto [first, is_new] = strikes.emplace(std::pair(row.shape, row.strike),
                                                 Strike{row.split_strike, row.point, row.strike});
    if (!is_new && first->second.part != row.split_strike) {
      items.push_back(fmt::format("strike {} of {} is in {} and, at {}, in {}", row.strike,
                                  row.shape, first->second.part, row.key, row.split_strike));
    }
  }
  for (const plan::Shape& shape : folder.dataset.build.plan.shapes) {
    std::vector<Strike> on_shape;
    double extent = 0;
    for (auto at = strikes.lower_bound({shape.id, 0});
         at != strikes.end() && at->first.first == shape.id; ++at) {
      on_shape.push_back(at->second);
      extent = std::max(extent, at->second.point.cwiseAbs().maxCoeff());
      const std::string planned = plan::split_strike(folder.dataset.build.config, shape,
                                                     static_cast<int>(at->first.second));
      if (planned != at->second.part) {
        items.push_back(fmt::format("strike {} of {} is in {}, the configuration puts it in {}",
                                    at->first.second, shape.id, at->second.part, planned));
      }
    }
    // Sorted by x, so that only neighbours within the tolerance are compared.
    std::sort(on_shape.begin(), on_shape.end(),
              [](const Strike& a, const Strike& b) { return a.point.x() < b.point.x(); });
    const double near = 1e-6 * extent;
    for (std::size_t i = 0; i < on_shape.size(); ++i) {
      for (std::size_t j = i + 1;
           j < on_shape.size() && on_shape[j].point.x() - on_shape[i].point.x() <= near; ++j) {
        const Strike &a = on_shape[i], &b = on_shape[j];
        if ((a.point - b.point).norm() <= near && a.part != b.part) {
          items.push_back(fmt::format("strikes {} ({}) and {} ({}) of {} hit the same point",
                                      a.number, a.part, b.number, b.part, shape.id));
        }
      }
    }
  }
  const bool simulations = folder.dataset.build.config.motion.has_value();
  return judged("split_strike", std::move(items),
                fmt::format("{} {}, none in two parts", strikes.size(),
                            simulations ? "simulations" : "strikes"),
                "a strike is in two parts, or not where it should be",
                "give each point once in strikes.csv; then build into a new folder");
}

namespace {

/// Which part of each split a thing was met in first.
struct Met {
  std::string split_shape, split_strike, key;
};

/// Says where a thing is in two parts of a split; "" where it is not.
std::string in_two_parts(const Met& first, const Row& row) {
  if (first.split_shape != row.split_shape) {
    return fmt::format("split_shape {} ({}) and {} ({})", first.split_shape, first.key,
                       row.split_shape, row.key);
  }
  if (first.split_strike != row.split_strike) {
    return fmt::format("split_strike {} ({}) and {} ({})", first.split_strike, first.key,
                       row.split_strike, row.key);
  }
  return "";
}

Finding check_responses(const std::vector<Row>& rows) {
  std::map<std::string, Met> by_name;
  std::vector<std::string> items;
  for (const Row& row : rows) {
    const Met met{row.split_shape, row.split_strike, row.key};
    const std::string leak = in_two_parts(by_name.emplace(row.response, met).first->second, row);
    if (!leak.empty()) items.push_back(fmt::format("{} is in {}", row.response, leak));
  }
  if (!items.empty() && by_name.size() == 1) {
    return {"rooms", Verdict::note, "one measured response for all parts", "", {}};
  }
  return judged("rooms", std::move(items),
                fmt::format("{} measured responses, none in two parts of a split", by_name.size()),
                "a measured response is in two parts of a split", edited);
}

}  // namespace

Finding check_rooms(const std::vector<Row>& rows) {
  if (!rows.empty() && !rows.front().response.empty()) return check_responses(rows);
  std::map<std::int64_t, Met> by_number;
  std::map<std::string, Met> by_text;
  std::vector<std::string> items, same;
  for (const Row& row : rows) {
    if (!row.room) continue;
    const Met met{row.split_shape, row.split_strike, row.key};
    std::string leak = in_two_parts(by_number.emplace(*row.room, met).first->second, row);
    if (!leak.empty()) items.push_back(fmt::format("room {} is in {}", *row.room, leak));
    leak = in_two_parts(by_text.emplace(row.room_text, met).first->second, row);
    if (!leak.empty()) same.push_back(fmt::format("a room of {} is in {}", row.room_text, leak));
  }
  if (by_number.empty()) return {"rooms", Verdict::pass, "no rooms", "", {}};
  if (items.empty() && !same.empty()) {
    if (by_text.size() == 1) {
      return {
          "rooms", Verdict::note, "one room for all parts, as the configuration gives it", "", {}};
    }
    items = same;
  }
  return judged("rooms", std::move(items),
                fmt::format("{} rooms, none in two parts of a split", by_number.size()),
                "a room is in two parts of a split", edited);
}

namespace {

/// A stretch of a recording in a sample.
struct Stretch {
  double begin = 0, end = 0;  ///< [s]
  const Row* row = nullptr;
};

/// `name start+duration; ...`, as the noise effect writes it; names may hold any of these signs.
void read_stretches(const Row& row, std::map<std::string, std::vector<Stretch>>& by_name) {
  std::size_t at = 0;
  while (at < row.noise.size()) {
    // The next "; " that follows two numbers ends a stretch.
    std::size_t end = at;
    for (;;) {
      end = row.noise.find("; ", end);
      if (end == std::string::npos) end = row.noise.size();
      const std::string one = row.noise.substr(at, end - at);
      const std::size_t plus = one.rfind('+'), space = one.rfind(' ', plus);
      char* stop = nullptr;
      if (plus != std::string::npos && space != std::string::npos && space < plus) {
        const double begin = std::strtod(one.c_str() + space + 1, &stop);
        if (stop == one.c_str() + plus) {
          const double duration = std::strtod(one.c_str() + plus + 1, &stop);
          if (stop == one.c_str() + one.size()) {
            by_name[one.substr(0, space)].push_back({begin, begin + duration, &row});
            break;
          }
        }
      }
      if (end == row.noise.size()) break;  // a kind of noise that is generated
      end += 2;
    }
    at = end + 2;
  }
}

}  // namespace

Finding check_noise(const std::vector<Row>& rows) {
  // Times are written to a microsecond; a stretch may begin where that of another part ends.
  constexpr double touching = 1e-4;
  std::map<std::string, std::vector<Stretch>> by_name;
  bool any = false;
  for (const Row& row : rows) {
    any = any || !row.noise.empty();
    read_stretches(row, by_name);
  }
  std::vector<std::string> items;
  for (auto& [name, stretches] : by_name) {
    std::sort(stretches.begin(), stretches.end(),
              [](const Stretch& a, const Stretch& b) { return a.begin < b.begin; });
    // Of each part of either split, the stretch that reaches furthest so far.
    std::map<std::string, Stretch> furthest;
    for (const Stretch& now : stretches) {
      const std::string parts[] = {"split_shape " + now.row->split_shape,
                                   "split_strike " + now.row->split_strike};
      for (const std::string& part : parts) {
        const std::string split = part.substr(0, part.find(' '));
        for (const auto& [other, before] : furthest) {
          if (other == part || !other.starts_with(split + " ")) continue;
          if (before.end - now.begin <= touching) continue;
          items.push_back(fmt::format("{} at {:.3f} s is in {} ({}) and {} ({})", name, now.begin,
                                      other, before.row->key, part.substr(split.size() + 1),
                                      now.row->key));
        }
        Stretch& reach = furthest[part];
        if (reach.row == nullptr || now.end > reach.end) reach = now;
      }
    }
  }
  const std::string passed =
      by_name.empty()
          ? std::string(any ? "noise is generated, for each sample by itself" : "no noise")
          : fmt::format("{} recordings, no moment of them in two parts of a split", by_name.size());
  return judged("noise", std::move(items), passed, "a recording is in two parts of a split",
                edited);
}

}  // namespace carillon::dataset::check
