#include <fmt/format.h>

#include <map>
#include <nlohmann/json.hpp>
#include <type_traits>

#include "core/error.hpp"
#include "core/hdf5_rows.hpp"
#include "core/near_program.hpp"
#include "dataset/run/dataset.hpp"
#include "dataset/sweep/plan_sweep.hpp"
#include "python/runtime.hpp"

namespace carillon::python {

namespace {

using nlohmann::json;

using RowNumbers = py::array_t<std::uint64_t, py::array::c_style | py::array::forcecast>;

/// Calls `use` with a value of an array's type.
/// @throws FileError  texts, or a type that datasets have not
template <class Use>
auto with_type(const std::string& type, const Use& use) {
  if (type == "float32") return use(float{});
  if (type == "float64") return use(double{});
  if (type == "int8") return use(std::int8_t{});
  if (type == "int16") return use(std::int16_t{});
  if (type == "int32") return use(std::int32_t{});
  if (type == "int64") return use(std::int64_t{});
  if (type == "uint8") return use(std::uint8_t{});
  if (type == "uint16") return use(std::uint16_t{});
  if (type == "uint32") return use(std::uint32_t{});
  if (type == "uint64") return use(std::uint64_t{});
  throw core::FileError(fmt::format("arrays of {} cannot be read as numbers", type));
}

/// One column of an index, kept open. Not for two processes at once: who is forked opens its own.
class Column {
 public:
  Column(const core::Hdf5Group& index, const std::string& name)
      : type_(index.element_type(name)), rows_(index, name) {}

  py::array read(const RowNumbers& numbers) const {
    std::vector<py::ssize_t> shape(rows_.extent().begin(), rows_.extent().end());
    shape[0] = numbers.size();
    return with_type(type_, [&]<class T>(T) -> py::array {
      py::array_t<T> values(shape);
      const std::span<const std::uint64_t> rows(numbers.data(),
                                                static_cast<std::size_t>(numbers.size()));
      const std::span<T> to(values.mutable_data(), static_cast<std::size_t>(values.size()));
      const py::gil_scoped_release unlocked;
      rows_.read<T>(rows, to);
      return values;
    });
  }

  std::vector<std::string> texts() const {
    const py::gil_scoped_release unlocked;
    return rows_.read<std::string>(0, rows_.extent()[0]);
  }

  const std::string& type() const { return type_; }
  const core::Extent& extent() const { return rows_.extent(); }

 private:
  std::string type_;
  core::Hdf5Rows rows_;
};

/// An index.h5 that is open.
class Index {
 public:
  explicit Index(const std::string& path) : file_(core::Hdf5Group::open_file(path)) {}

  /// Arrays of the file, and of `shapes` in it.
  std::vector<std::string> names() const {
    std::vector<std::string> names;
    for (const std::string& name : file_.names()) {
      if (!file_.is_group(name)) {
        names.push_back(name);
        continue;
      }
      const core::Hdf5Group group = file_.open_group(name);
      for (const std::string& inner : group.names())
        names.push_back(fmt::format("{}/{}", name, inner));
    }
    return names;
  }

  std::map<std::string, std::string> attributes(const std::string& object) const {
    return file_.attributes(object);
  }

  Column column(const std::string& name) const { return {file_, name}; }

 private:
  core::Hdf5Group file_;
};

std::string plan(const std::string& text, const std::string& name,
                 const std::vector<std::string>& overrides, const std::vector<int>& ranks) {
  dataset::run::BuildOptions options;
  options.config = name;
  options.text = text;
  options.overrides = overrides;
  dataset::run::ScheduleOptions schedule;
  schedule.ranks.assign(ranks.begin(), ranks.end());
  start_solver();
  return interruptible([options, schedule](const Waiting&) {
    const dataset::sweep::PlanReport report =
        dataset::sweep::plan_configuration(options, schedule, MPI_COMM_SELF);
    return json{{"document", report.document}, {"text", report.text}}.dump();
  });
}

}  // namespace

void bind_datasets(py::module_& module) {
  py::class_<Column>(module, "Column")
      .def("read", &Column::read)
      .def("texts", &Column::texts)
      .def_property_readonly("type", &Column::type)
      .def_property_readonly("extent", &Column::extent);
  py::class_<Index>(module, "Index")
      .def(py::init<const std::string&>())
      .def("names", &Index::names)
      .def("attributes", &Index::attributes)
      .def("column", &Index::column);
  module.def("plan", &plan);
  module.def("program", [] { return core::find_carillon().string(); });
  module.def("versions", [] { return dataset::run::program_versions().dump(); });
}

}  // namespace carillon::python
