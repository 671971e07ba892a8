#pragma once

#include <cstdint>
#include <mutex>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "core/hdf5.hpp"

/// What the HDF5 sources share; no part of the door.
namespace carillon::core::hdf5 {

/// Who holds it may call HDF5, which has one state for all threads.
std::recursive_mutex& turn();

/// Keeps HDF5 from printing its errors while it lives, and other threads from calling it; errors
/// are thrown instead.
class QuietErrors {
 public:
  QuietErrors();
  ~QuietErrors();
  QuietErrors(const QuietErrors&) = delete;
  QuietErrors& operator=(const QuietErrors&) = delete;

 private:
  std::scoped_lock<std::recursive_mutex> turn_{turn()};
  H5E_auto2_t function_ = nullptr;
  void* data_ = nullptr;
};

/// Throws FileError "file: object: doing: HDF5's reason", from HDF5's error stack.
[[noreturn]] void fail(const std::string& file, std::string_view object, std::string_view doing);
/// The same with a reason of our own.
[[noreturn]] void refuse(const std::string& file, std::string_view object,
                         std::string_view message);

inline void check(herr_t outcome, const std::string& file, std::string_view object,
                  std::string_view doing) {
  if (outcome < 0) fail(file, object, doing);
}
inline Hdf5Object checked(hid_t id, herr_t (*close)(hid_t), const std::string& file,
                          std::string_view object, std::string_view doing) {
  if (id < 0) fail(file, object, doing);
  return Hdf5Object(id, close);
}

/// Variable-length UTF-8 text.
Hdf5Object text_type();

/// Creation properties without times. @param kind  H5P_DATASET_CREATE, H5P_GROUP_CREATE ...
Hdf5Object untimed_properties(hid_t kind);

/// Makes the groups that a path leads through. (HDF5 can do so by itself, but then they keep the
/// time.)
void make_groups_above(hid_t group, const std::string& file, const std::string& path);

/// Link creation with a UTF-8 name.
Hdf5Object link_properties();

/// Texts of an attribute or a dataset; `read(type, buffer)` reads all `count` into a buffer.
/// Variable and fixed length, as other writers leave them.
template <class Read>
std::vector<std::string> read_texts(hid_t stored_type, hid_t space, std::size_t count,
                                    const Read& read) {
  std::vector<std::string> texts(count);
  if (count == 0) return texts;
  if (H5Tis_variable_str(stored_type) > 0) {
    const Hdf5Object type(H5Tcopy(stored_type), H5Tclose);
    std::vector<char*> pointers(count, nullptr);
    read(type.get(), pointers.data());
    for (std::size_t i = 0; i < count; ++i) texts[i] = pointers[i] != nullptr ? pointers[i] : "";
    H5Dvlen_reclaim(type.get(), space, H5P_DEFAULT, pointers.data());
    return texts;
  }
  const std::size_t size = H5Tget_size(stored_type);
  std::vector<char> bytes(count * size);
  read(stored_type, bytes.data());
  for (std::size_t i = 0; i < count; ++i) {
    const std::string_view padded(bytes.data() + i * size, size);
    texts[i] = padded.substr(0, padded.find('\0'));
    if (H5Tget_strpad(stored_type) == H5T_STR_SPACEPAD) {
      texts[i].erase(texts[i].find_last_not_of(' ') + 1);
    }
  }
  return texts;
}

/// Extents as HDF5 takes them.
std::vector<hsize_t> sizes(const Extent& extent);

/// Elements of an array, counted from an axis on.
std::uint64_t product(const Extent& extent, std::size_t first_axis = 0);

/// "[3, 64, 25]".
std::string shape_text(const Extent& extent);

Hdf5Object dataspace(const Extent& extent);

/// Chooses rows [first, first + count) along the first axis.
void select_rows(hid_t space, const Extent& extent, std::uint64_t first, std::uint64_t count);

/// A dataset that is open, with what it holds.
struct OpenDataset {
  Hdf5Object id;
  Hdf5Object type;
  Extent extent;
};

/// @param access  properties of H5P_DATASET_ACCESS
OpenDataset open_dataset(hid_t group, const std::string& file, const std::string& name,
                         hid_t access = H5P_DEFAULT);

/// What a virtual dataset joins; empty for one that holds its values itself.
std::vector<VirtualSource> virtual_sources(hid_t dataset, const std::string& file,
                                           const std::string& name);

/// Type on disk, little-endian on every machine. Owned, as texts need a copy.
template <class T>
Hdf5Object stored_type() {
  if constexpr (std::is_same_v<T, std::string>) return text_type();
  if constexpr (std::is_same_v<T, float>) return Hdf5Object(H5Tcopy(H5T_IEEE_F32LE), H5Tclose);
  if constexpr (std::is_same_v<T, double>) return Hdf5Object(H5Tcopy(H5T_IEEE_F64LE), H5Tclose);
  if constexpr (std::is_same_v<T, std::int8_t>) return Hdf5Object(H5Tcopy(H5T_STD_I8LE), H5Tclose);
  if constexpr (std::is_same_v<T, std::int16_t>)
    return Hdf5Object(H5Tcopy(H5T_STD_I16LE), H5Tclose);
  if constexpr (std::is_same_v<T, std::int32_t>)
    return Hdf5Object(H5Tcopy(H5T_STD_I32LE), H5Tclose);
  if constexpr (std::is_same_v<T, std::int64_t>)
    return Hdf5Object(H5Tcopy(H5T_STD_I64LE), H5Tclose);
  if constexpr (std::is_same_v<T, std::uint8_t>) return Hdf5Object(H5Tcopy(H5T_STD_U8LE), H5Tclose);
  if constexpr (std::is_same_v<T, std::uint16_t>)
    return Hdf5Object(H5Tcopy(H5T_STD_U16LE), H5Tclose);
  if constexpr (std::is_same_v<T, std::uint32_t>)
    return Hdf5Object(H5Tcopy(H5T_STD_U32LE), H5Tclose);
  if constexpr (std::is_same_v<T, std::uint64_t>)
    return Hdf5Object(H5Tcopy(H5T_STD_U64LE), H5Tclose);
}

template <class T>
Hdf5Object memory_type() {
  Hdf5Object stored = stored_type<T>();
  if constexpr (std::is_same_v<T, std::string>) {
    return stored;
  } else {
    return Hdf5Object(H5Tget_native_type(stored.get(), H5T_DIR_ASCEND), H5Tclose);
  }
}

}  // namespace carillon::core::hdf5

/// Templates of what arrays may hold are instantiated for each of these.
#define CARILLON_FOR_EACH_ELEMENT(instantiate) \
  instantiate(float);                          \
  instantiate(double);                         \
  instantiate(std::int8_t);                    \
  instantiate(std::int16_t);                   \
  instantiate(std::int32_t);                   \
  instantiate(std::int64_t);                   \
  instantiate(std::uint8_t);                   \
  instantiate(std::uint16_t);                  \
  instantiate(std::uint32_t);                  \
  instantiate(std::uint64_t);                  \
  instantiate(std::string)
