#include "core/hdf5.hpp"

#include <fmt/format.h>
#include <pthread.h>

#include <limits>
#include <map>
#include <new>

#include "core/detail/hdf5_detail.hpp"
#include "core/error.hpp"

namespace carillon::core {

namespace hdf5 {

namespace {

std::recursive_mutex& library_mutex() {
  static std::recursive_mutex mutex;
  return mutex;
}

/// A process is forked between two calls of HDF5, not within one of another thread's.
void take_turn() {
  library_mutex().lock();
}
void give_turn() {
  library_mutex().unlock();
}
/// The thread that took it has another number in the child and could not free it.
void renew_turn() {
  new (&library_mutex()) std::recursive_mutex;
}

}  // namespace

std::recursive_mutex& turn() {
  static const int heeded = pthread_atfork(take_turn, give_turn, renew_turn);
  static_cast<void>(heeded);
  return library_mutex();
}

QuietErrors::QuietErrors() {
  H5Eget_auto2(H5E_DEFAULT, &function_, &data_);
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

QuietErrors::~QuietErrors() {
  H5Eset_auto2(H5E_DEFAULT, function_, data_);
}

namespace {

/// Called from the innermost failure outwards, through C frames: nothing may be thrown.
herr_t take_innermost(unsigned depth, const H5E_error2_t* error, void* reason) noexcept {
  if (depth == 0 && error->desc != nullptr) *static_cast<std::string*>(reason) = error->desc;
  return 0;
}

std::string located(const std::string& file, std::string_view object) {
  return object.empty() || object == "." ? file : fmt::format("{}: {}", file, object);
}

}  // namespace

void fail(const std::string& file, std::string_view object, std::string_view doing) {
  std::string reason;
  H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, take_innermost, &reason);
  if (reason.empty()) reason = "HDF5 gives no reason";
  throw FileError(fmt::format("{}: {}: {}", located(file, object), doing, reason));
}

void refuse(const std::string& file, std::string_view object, std::string_view message) {
  throw FileError(fmt::format("{}: {}", located(file, object), message));
}

Hdf5Object text_type() {
  Hdf5Object type(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(type.get(), H5T_VARIABLE);
  H5Tset_cset(type.get(), H5T_CSET_UTF8);
  return type;
}

Hdf5Object untimed_properties(hid_t kind) {
  Hdf5Object properties(H5Pcreate(kind), H5Pclose);
  H5Pset_obj_track_times(properties.get(), false);
  return properties;
}

void make_groups_above(hid_t group, const std::string& file, const std::string& path) {
  for (std::size_t slash = path.find('/', 1); slash != std::string::npos;
       slash = path.find('/', slash + 1)) {
    const std::string above = path.substr(0, slash);
    if (H5Lexists(group, above.c_str(), H5P_DEFAULT) > 0) continue;
    const Hdf5Object creation = untimed_properties(H5P_GROUP_CREATE);
    checked(H5Gcreate2(group, above.c_str(), link_properties().get(), creation.get(), H5P_DEFAULT),
            H5Gclose, file, above, "group cannot be made");
  }
}

Hdf5Object link_properties() {
  Hdf5Object properties(H5Pcreate(H5P_LINK_CREATE), H5Pclose);
  H5Pset_char_encoding(properties.get(), H5T_CSET_UTF8);
  return properties;
}

namespace {

Hdf5Object file_access() {
  Hdf5Object access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  // Newer object headers are smaller and hold no times of their own; every HDF5 since 1.8 reads
  // them, virtual datasets need 1.10.
  H5Pset_libver_bounds(access.get(), H5F_LIBVER_V18, H5F_LIBVER_LATEST);
  // File systems of clusters refuse locks in ways of their own, of which HDF5 forgives one. None
  // are needed: a file has one writer, and its name only when it is whole.
  H5Pset_file_locking(access.get(), false, true);
  return access;
}

/// Object with an attribute, opened by its owner's group.
Hdf5Object open_object(hid_t group, const std::string& file, const std::string& object) {
  return checked(H5Oopen(group, object.c_str(), H5P_DEFAULT), H5Oclose, file, object,
                 "cannot be opened");
}

void replace_attribute(hid_t group, const std::string& file, const std::string& object,
                       const std::string& name, hid_t stored, hid_t memory, const void* value) {
  const QuietErrors quiet;
  const Hdf5Object owner = open_object(group, file, object);
  if (H5Aexists(owner.get(), name.c_str()) > 0) {
    check(H5Adelete(owner.get(), name.c_str()), file, name, "attribute cannot be replaced");
  }
  Hdf5Object properties(H5Pcreate(H5P_ATTRIBUTE_CREATE), H5Pclose);
  H5Pset_char_encoding(properties.get(), H5T_CSET_UTF8);
  const Hdf5Object space(H5Screate(H5S_SCALAR), H5Sclose);
  const Hdf5Object attribute = checked(
      H5Acreate2(owner.get(), name.c_str(), stored, space.get(), properties.get(), H5P_DEFAULT),
      H5Aclose, file, name, "attribute cannot be made");
  check(H5Awrite(attribute.get(), memory, value), file, name, "attribute cannot be written");
}

}  // namespace
}  // namespace hdf5

using namespace hdf5;

namespace {

/// For objects that outlive the call that made them, which has the library's turn.
template <herr_t (*close)(hid_t)>
herr_t close_in_turn(hid_t id) {
  const QuietErrors quiet;
  return close(id);
}

}  // namespace

Hdf5Group Hdf5Group::create_file(const std::filesystem::path& path) {
  const QuietErrors quiet;
  const Hdf5Object access = file_access();
  const Hdf5Object creation = untimed_properties(H5P_FILE_CREATE);
  const std::string file = path.string();
  return {checked(H5Fcreate(file.c_str(), H5F_ACC_TRUNC, creation.get(), access.get()),
                  close_in_turn<H5Fclose>, file, "", "cannot be made"),
          file};
}

Hdf5Group Hdf5Group::open_file(const std::filesystem::path& path) {
  const QuietErrors quiet;
  const Hdf5Object access = file_access();
  const std::string file = path.string();
  return {checked(H5Fopen(file.c_str(), H5F_ACC_RDONLY, access.get()), close_in_turn<H5Fclose>,
                  file, "", "cannot be opened"),
          file};
}

void Hdf5Group::flush() const {
  const QuietErrors quiet;
  check(H5Fflush(id_.get(), H5F_SCOPE_LOCAL), file_, "", "cannot be written");
}

Hdf5Group Hdf5Group::create_group(const std::string& name) const {
  const QuietErrors quiet;
  make_groups_above(id_.get(), file_, name);
  const Hdf5Object links = link_properties();
  const Hdf5Object creation = untimed_properties(H5P_GROUP_CREATE);
  return {checked(H5Gcreate2(id_.get(), name.c_str(), links.get(), creation.get(), H5P_DEFAULT),
                  close_in_turn<H5Gclose>, file_, name, "group cannot be made"),
          file_};
}

Hdf5Group Hdf5Group::open_group(const std::string& name) const {
  const QuietErrors quiet;
  return {checked(H5Gopen2(id_.get(), name.c_str(), H5P_DEFAULT), close_in_turn<H5Gclose>, file_,
                  name, "group cannot be opened"),
          file_};
}

bool Hdf5Group::has(const std::string& name) const {
  const QuietErrors quiet;
  // A path exists when each of its steps does; asking for the whole fails where one is missing.
  for (std::size_t slash = name.find('/', 1); slash != std::string::npos;
       slash = name.find('/', slash + 1)) {
    if (H5Lexists(id_.get(), name.substr(0, slash).c_str(), H5P_DEFAULT) <= 0) return false;
  }
  return H5Lexists(id_.get(), name.c_str(), H5P_DEFAULT) > 0;
}

bool Hdf5Group::is_group(const std::string& name) const {
  const QuietErrors quiet;
  return H5Iget_type(open_object(id_.get(), file_, name).get()) == H5I_GROUP;
}

std::vector<std::string> Hdf5Group::names() const {
  const QuietErrors quiet;
  H5G_info_t info{};
  check(H5Gget_info(id_.get(), &info), file_, "", "group cannot be listed");
  std::vector<std::string> names;
  for (hsize_t i = 0; i < info.nlinks; ++i) {
    const auto name_of = [&](char* text, std::size_t size) {
      const ssize_t length = H5Lget_name_by_idx(id_.get(), ".", H5_INDEX_NAME, H5_ITER_INC, i, text,
                                                size, H5P_DEFAULT);
      if (length < 0) fail(file_, "", "group cannot be listed");
      return static_cast<std::size_t>(length);
    };
    std::string name(name_of(nullptr, 0), '\0');
    name_of(name.data(), name.size() + 1);
    names.push_back(std::move(name));
  }
  return names;
}

void Hdf5Group::write_attribute(const std::string& name, const std::string& value,
                                const std::string& object) const {
  const QuietErrors quiet;
  if (value.find('\0') != std::string::npos) refuse(file_, name, "a text with a zero byte");
  const Hdf5Object type = text_type();
  const char* text = value.c_str();
  replace_attribute(id_.get(), file_, object, name, type.get(), type.get(), &text);
}

void Hdf5Group::write_attribute(const std::string& name, double value,
                                const std::string& object) const {
  const QuietErrors quiet;
  replace_attribute(id_.get(), file_, object, name, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, &value);
}

void Hdf5Group::write_attribute(const std::string& name, std::int64_t value,
                                const std::string& object) const {
  const QuietErrors quiet;
  replace_attribute(id_.get(), file_, object, name, H5T_STD_I64LE, H5T_NATIVE_INT64, &value);
}

namespace {

struct Attribute {
  Hdf5Object id;
  Hdf5Object type;
  Hdf5Object space;
};

Attribute open_attribute(hid_t group, const std::string& file, const std::string& object,
                         const std::string& name) {
  const std::string path = object == "." ? "@" + name : object + "@" + name;
  Attribute attribute;
  attribute.id =
      checked(H5Aopen_by_name(group, object.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT),
              H5Aclose, file, path, "attribute cannot be opened");
  attribute.type = Hdf5Object(H5Aget_type(attribute.id.get()), H5Tclose);
  attribute.space = Hdf5Object(H5Aget_space(attribute.id.get()), H5Sclose);
  if (H5Sget_simple_extent_npoints(attribute.space.get()) != 1) {
    refuse(file, path, "the attribute is not a single value");
  }
  return attribute;
}

}  // namespace

std::string Hdf5Group::text_attribute(const std::string& name, const std::string& object) const {
  const QuietErrors quiet;
  const Attribute attribute = open_attribute(id_.get(), file_, object, name);
  if (H5Tget_class(attribute.type.get()) != H5T_STRING) {
    refuse(file_, name, "the attribute is not a text");
  }
  return read_texts(attribute.type.get(), attribute.space.get(), 1, [&](hid_t type, void* buffer) {
    check(H5Aread(attribute.id.get(), type, buffer), file_, name, "attribute cannot be read");
  })[0];
}

double Hdf5Group::number_attribute(const std::string& name, const std::string& object) const {
  const QuietErrors quiet;
  const Attribute attribute = open_attribute(id_.get(), file_, object, name);
  double value = std::numeric_limits<double>::quiet_NaN();
  check(H5Aread(attribute.id.get(), H5T_NATIVE_DOUBLE, &value), file_, name,
        "attribute cannot be read as a number");
  return value;
}

namespace {

/// Called through C frames: nothing may be thrown.
herr_t take_name(hid_t, const char* name, const H5A_info_t*, void* names) noexcept {
  static_cast<std::vector<std::string>*>(names)->emplace_back(name);
  return 0;
}

}  // namespace

std::map<std::string, std::string> Hdf5Group::attributes(const std::string& object) const {
  const QuietErrors quiet;
  const Hdf5Object owner = open_object(id_.get(), file_, object);
  std::vector<std::string> names;
  check(H5Aiterate2(owner.get(), H5_INDEX_NAME, H5_ITER_INC, nullptr, take_name, &names), file_,
        object, "attributes cannot be listed");
  std::map<std::string, std::string> values;
  for (const std::string& name : names) {
    const Attribute attribute = open_attribute(id_.get(), file_, object, name);
    const bool is_text = H5Tget_class(attribute.type.get()) == H5T_STRING;
    values[name] = is_text ? fmt::format("\"{}\"", text_attribute(name, object))
                           : fmt::format("{}", number_attribute(name, object));
  }
  return values;
}

}  // namespace carillon::core
