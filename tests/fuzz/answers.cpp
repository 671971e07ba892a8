#include "eval/scoring/answers.hpp"

#include "core/hdf5.hpp"
#include "tests/fuzz/fuzz.hpp"

namespace {

using namespace carillon;

/// Bytes of the input, one after the other; 0 after its end.
struct Bytes {
  const std::uint8_t* data;
  std::size_t size;
  std::uint8_t next() { return size == 0 ? 0 : (--size, *data++); }
};

/// An array whose name, type, extent and values the input says.
template <class T>
void write_array(const core::Hdf5Group& group, const std::string& name, Bytes& input) {
  const core::Extent extent = input.next() % 4 == 0
                                  ? core::Extent{input.next() % 4u, input.next() % 4u}
                                  : core::Extent{input.next() % 8u};
  std::uint64_t count = 1;
  for (const std::uint64_t n : extent) count *= n;
  std::vector<T> values;
  for (std::uint64_t i = 0; i < count; ++i) {
    if constexpr (std::is_same_v<T, std::string>) {
      values.emplace_back(1, static_cast<char>(1 + input.next() % 127));
    } else {
      values.push_back(static_cast<T>(static_cast<std::int8_t>(input.next())));
    }
  }
  group.write<T>(name, values, extent);
}

void write_any(const core::Hdf5Group& group, const std::string& name, Bytes& input) {
  switch (input.next() % 8) {
    case 0:
      return;  // missing
    case 1:
      return write_array<std::string>(group, name, input);
    case 2:
      return write_array<float>(group, name, input);
    case 3:
      return write_array<std::int8_t>(group, name, input);
    case 4:
      group.create_group(name);
      return;
    default:
      return name == "key"      ? write_array<std::string>(group, name, input)
             : name == "scores" ? write_array<float>(group, name, input)
             : name == "label"  ? write_array<std::int32_t>(group, name, input)
                                : write_array<std::uint32_t>(group, name, input);
  }
}

}  // namespace

// HDF5's own reader is not on trial: the file is a whole one, what it holds is the input's.
int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const fuzz::InputFile file({});
  Bytes input{data, size};
  fuzz::expect_value_or_error([&] {
    {
      const core::Hdf5Group root = core::Hdf5Group::create_file(file.path());
      if (input.next() % 16 != 0) write_array<std::string>(root, "classes", input);
      for (const char* part : {"validation", "test"}) {
        if (input.next() % 16 == 0) continue;
        const core::Hdf5Group group = root.create_group(part);
        for (const char* name : {"key", "label", "object", "strike", "scores"}) {
          write_any(group, name, input);
        }
      }
    }
    const eval::scoring::Answers answers = eval::scoring::read_answers(file.path());
    for (const eval::scoring::PartAnswers* part : {&answers.validation, &answers.test}) {
      eval::scoring::true_classes(*part);
      eval::scoring::likely_classes(*part, answers.classes.size());
      eval::scoring::groups_of(*part, "split_shape");
      eval::scoring::confusion_of(*part, answers.classes.size());
    }
  });
  return 0;
}
