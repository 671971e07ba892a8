#include "solvers/mesh/readers/detail/msh_file.hpp"

#include <fmt/core.h>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <unordered_map>

#include "solvers/mesh/readers/detail/msh_elements.hpp"
#include "solvers/mesh/readers/detail/msh_source.hpp"

namespace carillon::solvers::mesh::readers {
namespace {

/// State while the sections of one file are read.
class Parser {
 public:
  Parser(const std::string& path, std::string_view bytes) : in_(path, bytes) {}

  MshFile parse() {
    read_format();
    for (std::string_view word = in_.word(); !word.empty(); word = in_.word()) {
      if (word.front() != '$') in_.fail("a section that begins with \"$\" expected");
      const std::string section(word.substr(1));
      if (section == "PhysicalNames") {
        read_physical_names();
      } else if (section == "Entities" && version_ >= 4) {
        read_entities();
      } else if (section == "Nodes") {
        version_ < 4 ? read_nodes_2(false) : read_nodes_4();
      } else if (section == "ParametricNodes" && version_ < 4) {
        read_nodes_2(true);
      } else if (section == "Elements") {
        version_ < 4 ? read_elements_2() : read_elements_4();
      } else {
        in_.skip_section(section);  // comments, periodicity, partitions, post-processing data
        continue;
      }
      in_.end_section(section);
    }
    return std::move(file_);
  }

 private:
  [[noreturn]] void refuse_version(const std::string& version) const {
    in_.fail(
        fmt::format("MSH version {} is not read; `gmsh -save -format msh41 old.msh -o "
                    "new.msh` writes it as version 4.1",
                    version));
  }

  void read_format() {
    std::string_view word = in_.word();
    if (word == "$NOD") refuse_version("1");
    for (; word != "$MeshFormat" && word.size() > 1 && word.front() == '$'; word = in_.word())
      in_.skip_section(word.substr(1));  // comments
    if (word != "$MeshFormat") in_.fail("\"$MeshFormat\" expected at the beginning");
    version_ = in_.text_number("version");
    const std::int64_t type = in_.text_integer("file type");
    const std::int64_t data_size = in_.text_integer("data size");
    if (!((version_ >= 2 && version_ < 3) || (version_ >= 4 && version_ < 5))) {
      refuse_version(fmt::format("{}", version_));
    }
    if (data_size != 8) in_.fail(fmt::format("data size {}; 8 expected", data_size));
    if (type == 1 && is_4_0()) refuse_version("4.0, binary,");
    if (type == 1) {
      in_.begin_binary();
      in_.binary = true;
      const std::int64_t one = in_.integer("1 for the byte order");
      if (one != 1) {
        in_.swap = true;
        if (one != 0x01000000) in_.fail("the mark of the byte order is damaged");
      }
    }
    in_.end_section("MeshFormat");
  }

  void read_physical_names() {
    const std::int64_t names =
        in_.count(in_.text_integer("number of physical names"), 4, "physical names");
    for (std::int64_t i = 0; i < names; ++i) {
      const std::int64_t dimension = in_.text_integer("dimension of a physical group");
      const std::int64_t tag = in_.text_integer("number of a physical group");
      std::string_view name = in_.line();
      if (name.size() < 2 || name.front() != '"' || name.back() != '"') {
        in_.fail("name of a physical group in quotes expected");
      }
      name = name.substr(1, name.size() - 2);
      if (dimension == 3) file_.volume_names[tag] = std::string(name);
    }
  }

  void read_entities() {
    if (in_.binary) in_.begin_binary();
    std::array<std::int64_t, 4> counts;
    for (auto& n : counts) n = in_.count(in_.size("number of entities"), 8, "entities");
    for (std::size_t dimension = 0; dimension < 4; ++dimension) {
      for (std::int64_t i = 0; i < counts[dimension]; ++i) {
        const std::int64_t tag = in_.integer("number of an entity");
        const int numbers = dimension == 0 && !is_4_0() ? 3 : 6;
        for (int k = 0; k < numbers; ++k) in_.number("bounding box");
        const std::int64_t groups =
            in_.count(in_.size("number of physical groups"), 2, "physical groups");
        for (std::int64_t k = 0; k < groups; ++k) {
          // A negative number says that the entity is reversed. The first group counts.
          const std::int64_t group = std::abs(in_.integer("physical group"));
          if (dimension == 3 && k == 0) volume_group_[tag] = group;
        }
        if (dimension == 0) continue;
        const std::int64_t bounds = in_.count(in_.size("number of boundaries"), 2, "boundaries");
        for (std::int64_t k = 0; k < bounds; ++k) in_.integer("boundary");
      }
    }
  }

  void add_node(std::int64_t tag, const Vec3& point) {
    if (file_.nodes.size() >= std::numeric_limits<std::int32_t>::max()) in_.fail("too many nodes");
    const auto index = static_cast<std::int32_t>(file_.nodes.size());
    if (!node_index_.emplace(tag, index).second) in_.fail(fmt::format("node {} twice", tag));
    file_.nodes.push_back(point);
  }

  Vec3 read_point() {
    const double x = in_.number("x coordinate");
    const double y = in_.number("y coordinate");
    return {x, y, in_.number("z coordinate")};
  }

  /// The first of version 4, which has each node's number beside its place, and an entity's before
  /// its dimension; read as text alone.
  bool is_4_0() const { return version_ >= 4 && version_ < 4.1; }

  /// @param parametric  each has its entity and the coordinates on it, if that is a curve or a
  ///                    surface
  void read_nodes_2(bool parametric) {
    const std::int64_t nodes = in_.count(in_.text_integer("number of nodes"), 8, "nodes");
    if (in_.binary) in_.begin_binary();
    for (std::int64_t i = 0; i < nodes; ++i) {
      const std::int64_t tag = in_.integer("node number");
      add_node(tag, read_point());
      if (!parametric) continue;
      const std::int64_t dimension = in_.integer("dimension of an entity");
      in_.integer("entity");
      const std::int64_t parameters = dimension == 1 || dimension == 2 ? dimension : 0;
      for (std::int64_t k = 0; k < parameters; ++k) in_.number("parametric coordinate");
    }
  }

  void read_nodes_4() {
    if (in_.binary) in_.begin_binary();
    const std::int64_t blocks = in_.count(in_.size("number of node blocks"), 8, "node blocks");
    for (int i = 0; i < (is_4_0() ? 1 : 3); ++i) in_.size("number of nodes and their range");
    std::vector<std::int64_t> tags;
    for (std::int64_t b = 0; b < blocks; ++b) {
      std::int64_t dimension = in_.integer("dimension");
      const std::int64_t entity = in_.integer("entity");
      if (is_4_0()) dimension = entity;  // the other way round there
      const std::int64_t parametric = in_.integer("parametric");
      const std::int64_t nodes = in_.count(in_.size("number of nodes"), 8, "nodes");
      if (dimension < 0 || dimension > 3) in_.fail("dimension 0 to 3 expected");
      tags.clear();
      if (!is_4_0())
        for (std::int64_t i = 0; i < nodes; ++i) tags.push_back(in_.size("node number"));
      for (std::int64_t i = 0; i < nodes; ++i) {
        const std::int64_t tag =
            is_4_0() ? in_.size("node number") : tags[static_cast<std::size_t>(i)];
        add_node(tag, read_point());
        const std::int64_t parameters = parametric != 0 ? dimension : 0;
        for (std::int64_t k = 0; k < parameters; ++k) in_.number("parametric coordinate");
      }
    }
  }

  const MshElementKind& read_kind() {
    const std::int64_t number = in_.integer("element type");
    const MshElementKind* kind = find_msh_element(number);
    if (kind == nullptr) in_.fail(fmt::format("unknown element type {}", number));
    if (kind->dimension == 3 && kind->order == 0) {
      in_.fail(
          fmt::format("the file holds a {}; only tetrahedra of order 1 to 4 are read", kind->name));
    }
    if (kind->order > 0 && file_.order > 0 && kind->order != file_.order) {
      in_.fail("the file holds tetrahedra of several orders");
    }
    if (kind->order > 0) file_.order = kind->order;
    return *kind;
  }

  /// Reads the nodes of one element; tetrahedra are kept.
  template <class ReadTag>
  void read_element(const MshElementKind& kind, std::int64_t group, ReadTag read_tag) {
    for (int i = 0; i < kind.nodes; ++i) {
      const std::int64_t tag = read_tag();
      if (kind.order == 0) continue;
      const auto found = node_index_.find(tag);
      if (found == node_index_.end()) {
        in_.fail(fmt::format("an element refers to node {}, which is missing", tag));
      }
      file_.tetrahedra.push_back(found->second);
    }
    kind.order > 0 ? file_.groups.push_back(group) : void(++file_.other_elements);
  }

  void read_elements_2() {
    const std::int64_t elements = in_.count(in_.text_integer("number of elements"), 4, "elements");
    if (in_.binary) in_.begin_binary();
    const auto read_tag = [this] { return in_.integer("node number"); };
    for (std::int64_t done = 0; done < elements;) {
      // Binary files gather elements of one kind in blocks; text has one element a line.
      if (!in_.binary) in_.integer("element number");
      const MshElementKind& kind = read_kind();
      const std::int64_t block = in_.binary ? in_.integer("elements in a block") : 1;
      const std::int64_t tags = in_.integer("number of tags");
      if (block < 1 || block > elements - done) in_.fail("a block of elements is too long");
      if (tags < 0 || tags > 1000) in_.fail(fmt::format("{} tags", tags));
      for (std::int64_t i = 0; i < block; ++i) {
        if (in_.binary) in_.integer("element number");
        std::int64_t group = 0;
        for (std::int64_t k = 0; k < tags; ++k) {
          const std::int64_t tag = in_.integer("tag");
          if (k == 0) group = std::abs(tag);
        }
        read_element(kind, group, read_tag);
      }
      done += block;
    }
  }

  void read_elements_4() {
    if (in_.binary) in_.begin_binary();
    const std::int64_t blocks = in_.count(in_.size("number of element blocks"), 8, "blocks");
    for (int i = 0; i < (is_4_0() ? 1 : 3); ++i) in_.size("number of elements and their range");
    const auto read_tag = [this] { return in_.size("node number"); };
    for (std::int64_t b = 0; b < blocks; ++b) {
      const std::int64_t first = in_.integer("dimension or entity");
      const std::int64_t second = in_.integer("entity or dimension");
      const std::int64_t entity = is_4_0() ? first : second;
      const MshElementKind& kind = read_kind();
      const std::int64_t elements = in_.count(in_.size("number of elements"), 4, "elements");
      const auto group = volume_group_.find(entity);
      for (std::int64_t i = 0; i < elements; ++i) {
        in_.size("element number");
        read_element(kind, group == volume_group_.end() ? 0 : group->second, read_tag);
      }
    }
  }

  MshSource in_;
  double version_ = 0;
  MshFile file_;
  std::unordered_map<std::int64_t, std::int32_t> node_index_;
  std::unordered_map<std::int64_t, std::int64_t> volume_group_;
};

}  // namespace

MshFile parse_msh(const std::string& path, std::string_view bytes) {
  return Parser(path, bytes).parse();
}

}  // namespace carillon::solvers::mesh::readers
