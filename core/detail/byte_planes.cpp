#include "core/detail/byte_planes.hpp"

#include <zlib.h>

#include <array>
#include <cmath>
#include <stdexcept>

namespace carillon::core {
namespace {

/// Bytes of more information than this [bit] (Shannon's entropy of their values) shrink by less
/// than a fortieth.
constexpr double random_bits = 7.8;

double entropy(std::span<const unsigned char> bytes) {
  std::array<std::size_t, 256> counts{};
  for (const unsigned char byte : bytes) ++counts[byte];
  const auto total = static_cast<double>(bytes.size());
  double bits = 0;
  for (const std::size_t count : counts) {
    if (count == 0) continue;
    const double share = static_cast<double>(count) / total;
    bits -= share * std::log2(share);
  }
  return bits;
}

/// Memory that zlib asked for, of which there is enough, and parameters that it takes.
void require(int outcome) {
  if (outcome != Z_OK && outcome != Z_STREAM_END)
    throw std::runtime_error("zlib could not compress an array");
}

class Deflate {
 public:
  explicit Deflate(int level) { require(deflateInit(&stream_, level)); }
  ~Deflate() { deflateEnd(&stream_); }
  Deflate(const Deflate&) = delete;
  Deflate& operator=(const Deflate&) = delete;

  z_stream& stream() { return stream_; }

 private:
  z_stream stream_{};
};

}  // namespace

std::vector<unsigned char> byte_planes(std::span<const unsigned char> values,
                                       std::size_t element_size) {
  std::vector<unsigned char> planes(values.size());
  const std::size_t count = values.size() / element_size;
  for (std::size_t plane = 0; plane < element_size; ++plane)
    for (std::size_t i = 0; i < count; ++i)
      planes[plane * count + i] = values[i * element_size + plane];
  return planes;
}

void from_byte_planes(std::span<const unsigned char> planes, std::size_t element_size,
                      std::span<unsigned char> values) {
  const std::size_t count = values.size() / element_size;
  const unsigned char* from = planes.data();
  unsigned char* to = values.data();
  if (element_size == sizeof(float)) {  // most of what is stored
    for (std::size_t i = 0; i < count; ++i, to += sizeof(float)) {
      to[0] = from[i];
      to[1] = from[count + i];
      to[2] = from[2 * count + i];
      to[3] = from[3 * count + i];
    }
    return;
  }
  for (std::size_t plane = 0; plane < element_size; ++plane)
    for (std::size_t i = 0; i < count; ++i) to[i * element_size + plane] = from[plane * count + i];
}

std::vector<unsigned char> deflate_planes(std::span<const unsigned char> planes,
                                          std::size_t element_size, int level) {
  Deflate deflating(level);
  z_stream& stream = deflating.stream();
  // What zlib may take, and a block's head where the level changes.
  std::vector<unsigned char> out(deflateBound(&stream, planes.size()) + 64 * element_size);
  stream.next_out = out.data();
  stream.avail_out = static_cast<uInt>(out.size());
  const std::size_t size = planes.size() / element_size;
  for (std::size_t plane = 0; plane < element_size; ++plane) {
    const auto bytes = planes.subspan(plane * size, size);
    // A change of level ends the block before.
    const bool random = element_size > 1 && entropy(bytes) > random_bits;
    require(deflateParams(&stream, random ? 0 : level, Z_DEFAULT_STRATEGY));
    stream.next_in = const_cast<unsigned char*>(bytes.data());  // zlib does not write to it
    stream.avail_in = static_cast<uInt>(bytes.size());
    require(deflate(&stream, plane + 1 == element_size ? Z_FINISH : Z_NO_FLUSH));
  }
  out.resize(stream.total_out);
  return out;
}

bool inflate_planes(std::span<const unsigned char> deflated, std::span<unsigned char> planes) {
  uLongf size = planes.size();
  return uncompress(planes.data(), &size, deflated.data(), deflated.size()) == Z_OK &&
         size == planes.size();
}

}  // namespace carillon::core
