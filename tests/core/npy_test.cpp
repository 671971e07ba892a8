// NumPy files: headers of every format, rows read where they lie, and what is refused.
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cstring>
#include <fstream>

#include "core/error.hpp"
#include "core/npy.hpp"
#include "core/temporary_folder.hpp"

namespace carillon::core {
namespace {

std::string message_of(const auto& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.what();
  }
  return "nothing was thrown";
}

/// A file of format 1 to 3 with a header of one's own, as the format's description has it.
std::string raw_header(int version, const std::string& text) {
  std::string bytes = "\x93NUMPY";
  bytes += static_cast<char>(version);
  bytes += '\0';
  for (int i = 0; i < (version == 1 ? 2 : 4); ++i) {
    bytes += static_cast<char>(text.size() >> (8 * i) & 0xff);
  }
  return bytes + text;
}

std::filesystem::path write(const TemporaryFolder& folder, const std::string& bytes) {
  const auto path = folder / "array.npy";
  std::ofstream(path, std::ios::binary) << bytes;
  return path;
}

NpyHeader parse(const std::string& bytes) {
  std::uint64_t offset = 0;
  return parse_npy_header(bytes, offset);
}

constexpr const char* floats = "{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3), }";

TEST(NpyHeaders, OfEveryFormatAreRead) {
  for (const int version : {1, 2, 3}) {
    std::uint64_t offset = 0;
    const std::string bytes = raw_header(version, floats);
    const NpyHeader header = parse_npy_header(bytes, offset);
    EXPECT_EQ(header.type, "float32");
    EXPECT_EQ(header.extent, (std::vector<std::uint64_t>{2, 3}));
    EXPECT_EQ(offset, bytes.size());
  }
  EXPECT_TRUE(
      parse(raw_header(1, "{'shape': (), 'fortran_order': True, 'descr': '<i8'}")).extent.empty());
  EXPECT_EQ(parse(raw_header(2, "{\"descr\":'=u1','fortran_order':True,'shape':(7L,)}")).type,
            "uint8");
}

TEST(NpyHeaders, ThatCannotBeReadSayWhy) {
  const auto why = [](const std::string& bytes) { return message_of([&] { parse(bytes); }); };
  const auto with = [&](const std::string& text) { return why(raw_header(1, text)); };
  EXPECT_NE(why("RIFF....").find("not a NumPy file"), std::string::npos);
  EXPECT_NE(why(raw_header(1, floats).substr(0, 40)).find("cut off"), std::string::npos);
  EXPECT_NE(why(raw_header(9, floats)).find("format 9"), std::string::npos);
  EXPECT_NE(with("{'descr': '>f8', 'fortran_order': False, 'shape': (2,)}").find("astype('<f8')"),
            std::string::npos);
  EXPECT_NE(with("{'descr': '<c8', 'fortran_order': False, 'shape': (2,)}").find("\"<c8\""),
            std::string::npos);
  EXPECT_NE(
      with("{'descr': '<f4', 'fortran_order': True, 'shape': (2, 2)}").find("ascontiguousarray"),
      std::string::npos);
  EXPECT_NE(
      with("{'descr': [('x', '<f4')], 'fortran_order': False, 'shape': (2,)}").find("records"),
      std::string::npos);
  EXPECT_NE(with("{'descr': '<f4', 'shape': (2,)}").find("fortran_order"), std::string::npos);
  EXPECT_NE(with("{'descr': '<f4', 'fortran_order': False, 'shape': (99999999999999999999,)}")
                .find("malformed"),
            std::string::npos);
}

TEST(NpyFiles, GiveTheirRows) {
  const TemporaryFolder folder;
  std::string bytes = raw_header(1, floats);
  for (const float value : {0.5F, -1.5F, 2.F, 3.F, 4.F, 1e-30F}) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  const NpyFile file(write(folder, bytes));
  EXPECT_EQ(file.rows(), 2U);
  EXPECT_EQ(file.row_size(), 3U);
  EXPECT_EQ(file.read_rows(0, 1), (std::vector<double>{0.5, -1.5, 2}));
  EXPECT_EQ(file.read_rows(1, 1), (std::vector<double>{3, 4, static_cast<double>(1e-30F)}));
  EXPECT_TRUE(file.read_rows(2, 0).empty());
  EXPECT_THROW(file.read_rows(1, 2), InputError);
  EXPECT_THROW(file.read_rows(3, 0), InputError);
}

TEST(NpyFiles, ThatAreNotWholeAreNamed) {
  const TemporaryFolder folder;
  const auto path = write(folder, raw_header(1, floats) + std::string(23, '\0'));
  const std::string message = message_of([&] { NpyFile file(path); });
  EXPECT_NE(message.find("array.npy: 23 bytes of elements, where 2 x 3 of type float32 take 24"),
            std::string::npos)
      << message;
  const auto vast = write(folder, raw_header(1,
                                             "{'descr': '<f8', 'fortran_order': False, "
                                             "'shape': (4294967296, 4294967296, 2)}"));
  EXPECT_NE(message_of([&] { NpyFile file(vast); }).find("beyond any file"), std::string::npos);
  EXPECT_THROW(NpyFile(folder / "none.npy"), FileError);
  EXPECT_THROW(NpyFile(folder.path()), FileError);
}

RC_GTEST_PROP(NpyHeaders, ComeBack, ()) {
  const NpyHeader header{
      *rc::gen::element<std::string>("float32", "float64", "int8", "uint8", "int16", "uint16",
                                     "int32", "uint32", "int64", "uint64"),
      *rc::gen::container<std::vector<std::uint64_t>>(rc::gen::arbitrary<std::uint64_t>())};
  std::uint64_t offset = 0;
  const std::string bytes = npy_header(header);
  const NpyHeader back = parse_npy_header(bytes, offset);
  RC_ASSERT(back.type == header.type);
  RC_ASSERT(back.extent == header.extent);
  RC_ASSERT(offset == bytes.size());
  RC_ASSERT(offset % 64 == 0);
}

/// Any damage to a file is answered with one of the project's errors, or leaves an array.
RC_GTEST_PROP(NpyFiles, ThatAreDamagedAreRefusedOrRead, ()) {
  const TemporaryFolder folder;
  std::string bytes = raw_header(*rc::gen::inRange(1, 4), floats) + std::string(24, '\0');
  const auto damages = *rc::gen::inRange(1, 6);
  for (int i = 0; i < damages; ++i) {
    const auto place = *rc::gen::inRange<std::size_t>(0, bytes.size());
    switch (*rc::gen::inRange(0, 3)) {
      case 0:
        bytes[place] = *rc::gen::arbitrary<char>();
        break;
      case 1:
        bytes.erase(place, *rc::gen::inRange<std::size_t>(1, 20));
        break;
      default:
        bytes.insert(place, *rc::gen::element<std::string>("(", ")", "{", "}", "'", ",", "9", "-1",
                                                           "True", "'shape': (1,), "));
    }
    if (bytes.empty()) break;
  }
  try {
    const NpyFile file(write(folder, bytes));
    if (file.rows() <= 100 && file.row_size() <= 100) {
      RC_ASSERT(file.read_rows(0, file.rows()).size() == file.rows() * file.row_size());
    }
  } catch (const Error& error) {
    RC_ASSERT(!error.message().empty());
  }
}

}  // namespace
}  // namespace carillon::core
