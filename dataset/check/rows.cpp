#include "dataset/check/rows.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <map>
#include <nlohmann/json.hpp>

#include "core/hdf5.hpp"
#include "core/random.hpp"

namespace carillon::dataset::check {

using core::Hdf5Group;

namespace {

std::vector<std::string> shapes_of_bodies(const std::string& bodies) {
  std::vector<std::string> shapes;
  for (const nlohmann::json& body : nlohmann::json::parse(bodies)) {
    if (body.contains("shape")) shapes.push_back(body.at("shape"));
  }
  return shapes;
}

}  // namespace

std::vector<Row> read_rows(const DatasetFolder& folder, const std::vector<std::size_t>& tasks) {
  std::vector<Row> rows;
  for (const std::size_t t : tasks) {
    const Hdf5Group shard = Hdf5Group::open_file(folder.dataset.folder / folder.path_of(t));
    const auto texts = [&](const char* name) { return shard.read<std::string>(name); };
    const auto keys = texts("key"), shapes = texts("shape"), materials = texts("material");
    const auto split_shapes = texts("split_shape"), split_strikes = texts("split_strike");
    const auto ids = shard.read<std::uint64_t>("id");
    const bool simulations = shard.has("simulation");
    const auto bodies = simulations ? texts("bodies") : std::vector<std::string>{};
    const auto numbers = shard.read<std::int64_t>(simulations ? "simulation" : "strike");
    std::vector<double> sizes(keys.size(), 1), points(3 * keys.size(), 0);
    if (!simulations) {
      sizes = shard.read<double>("size");
      points = shard.read<double>("position");
    }
    const bool has_room = shard.has("room"), has_noise = shard.has("noise_source");
    const auto rooms = has_room ? shard.read<std::int64_t>("room") : std::vector<std::int64_t>{};
    std::vector<double> room_sizes, room_sources, room_times;
    if (has_room) {
      room_sizes = shard.read<double>("room_size");
      room_sources = shard.read<double>("room_source");
      room_times = shard.read<double>("room_rt60");
    }
    const auto responses =
        shard.has("room_response") ? texts("room_response") : std::vector<std::string>{};
    const auto noises = has_noise ? texts("noise_source") : std::vector<std::string>{};
    for (std::size_t i = 0; i < keys.size(); ++i) {
      Row row;
      row.key = keys[i];
      row.shape = simulations ? keys[i] : shapes[i];  // a simulation is held out by itself
      row.material = materials[i];
      row.split_shape = split_shapes[i];
      row.split_strike = split_strikes[i];
      row.id = ids[i];
      row.size = sizes[i];
      row.strike = numbers[i];
      row.simulation = simulations;
      if (simulations) row.played = shapes_of_bodies(bodies[i]);
      row.point = Vec3(&points[3 * i]) / sizes[i];
      if (has_room) {
        row.room = rooms[i];
        const auto part = [&](const std::vector<double>& all) {
          const std::size_t width = all.size() / keys.size();
          return fmt::format("{:.9g}", fmt::join(std::span(all).subspan(i * width, width), " "));
        };
        row.room_text = part(room_sizes) + " / " + part(room_sources) + " / " + part(room_times);
      }
      if (!responses.empty()) row.response = responses[i];
      if (has_noise) row.noise = noises[i];
      rows.push_back(std::move(row));
    }
  }
  return rows;
}

namespace {

/// A sample's size as its key has it: a pitch is no column, the size that it led to is.
std::string size_of(const DatasetFolder& folder, const plan::Sample& sample, double size) {
  plan::Variant variant = folder.dataset.build.plan.shapes[sample.shape].variants[sample.variant];
  variant.size = size;
  return plan::size_name(variant);
}

}  // namespace

Finding check_ids(const DatasetFolder& folder, const std::vector<Row>& rows) {
  std::map<std::string, const plan::Sample*> planned;
  for (const plan::Sample& sample : folder.dataset.build.plan.samples)
    planned[sample.key] = &sample;
  std::map<std::uint64_t, std::string> seen;
  std::vector<std::string> items;
  for (const Row& row : rows) {
    const auto known = planned.find(row.key);
    const std::string size = known == planned.end() ? fmt::format("{}", row.size)
                                                    : size_of(folder, *known->second, row.size);
    const std::string key = row.simulation ? fmt::format("simulation-{:04}", row.strike)
                                           : fmt::format("{}/{}/{}/strike-{:04}", row.shape,
                                                         row.material, size, row.strike);
    if (row.key != key) items.push_back(fmt::format("{}: its labels make {}", row.key, key));
    if (row.id != core::stable_hash(row.key)) {
      items.push_back(fmt::format("{}: id {} is not of its key", row.key, row.id));
    }
    if (!planned.contains(row.key)) items.push_back(row.key + ": is not planned");
    const auto [other, is_new] = seen.emplace(row.id, row.key);
    if (!is_new) items.push_back(fmt::format("{} and {}: one id", other->second, row.key));
  }
  return judged("ids", std::move(items), fmt::format("{} keys and ids, each once", rows.size()),
                "keys or ids are not what they should be",
                "delete these shards and run the build again into this folder");
}

}  // namespace carillon::dataset::check
