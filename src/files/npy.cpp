#include "noiseloom/files/npy.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <fstream>
#include <limits>
#include <string_view>

#include "noiseloom/core/error.h"

namespace noiseloom {
namespace {

static_assert(std::endian::native == std::endian::little);

constexpr std::string_view magic("\x93NUMPY", 6);
constexpr std::string_view accepted_types = "float16, float32, float64 and integers of 8 to 64 bits";

struct Header {
  std::string type;
  bool fortran_order = false;
  std::vector<std::int64_t> shape;
};

// The text after `'key':` in a Python dict, blanks skipped.
std::string_view text_of(std::string_view dict, std::string_view key, const std::string& path) {
  for (std::size_t at = dict.find(key); at != std::string_view::npos; at = dict.find(key, at + 1)) {
    const std::size_t end = at + key.size();
    if (at == 0 || end + 1 >= dict.size() || (dict[end] != '\'' && dict[end] != '"')) continue;
    const std::size_t colon = dict.find_first_not_of(' ', end + 1);
    if (colon == std::string_view::npos || dict[colon] != ':') continue;
    const std::size_t value = dict.find_first_not_of(' ', colon + 1);
    if (value != std::string_view::npos) return dict.substr(value);
  }
  throw UserError(path, "damaged .npy header: it names no " + std::string(key));
}

std::vector<std::int64_t> parse_shape(std::string_view text, const std::string& path) {
  const std::size_t close = text.find(')');
  if (text.front() != '(' || close == std::string_view::npos) throw UserError(path, "damaged .npy header: shape");
  std::vector<std::int64_t> shape;
  for (const char* at = text.data() + 1; at != text.data() + close;) {
    if (*at == ' ' || *at == ',') {
      ++at;
      continue;
    }
    std::int64_t size = -1;
    const auto [next, error] = std::from_chars(at, text.data() + close, size);
    if (error != std::errc{} || size < 0) throw UserError(path, "damaged .npy header: shape");
    shape.push_back(size);
    at = next;
  }
  return shape;
}

Header parse_header(std::string_view dict, const std::string& path) {
  Header header;
  const std::string_view type = text_of(dict, "descr", path);
  const std::size_t end = type.find(type.front(), 1);
  if ((type.front() != '\'' && type.front() != '"') || end == std::string_view::npos) {
    throw UserError(path, "structured .npy type; accepted: " + std::string(accepted_types));
  }
  header.type = type.substr(1, end - 1);
  header.fortran_order = text_of(dict, "fortran_order", path).starts_with("True");
  header.shape = parse_shape(text_of(dict, "shape", path), path);
  return header;
}

Header read_header(std::ifstream& file, const std::string& path) {
  std::array<unsigned char, 8> start{};
  file.read(reinterpret_cast<char*>(start.data()), start.size());
  if (!file || std::memcmp(start.data(), magic.data(), magic.size()) != 0) throw UserError(path, "not a .npy file");
  if (start[6] < 1 || start[6] > 3) {
    throw UserError(path, ".npy format " + std::to_string(start[6]) + "; accepted: 1 to 3");
  }
  std::array<unsigned char, 4> size{};
  file.read(reinterpret_cast<char*>(size.data()), start[6] == 1 ? 2 : 4);
  const std::uint32_t length = std::bit_cast<std::uint32_t>(size);
  constexpr std::uint32_t longest = 1U << 20;  // a header of plain numbers has about 100 bytes
  if (!file || length > longest) throw UserError(path, "damaged .npy header: length");
  std::string dict(length, ' ');
  file.read(dict.data(), length);
  if (!file) throw UserError(path, "the file ends inside the .npy header");
  return parse_header(dict, path);
}

// The product of all sizes, which is within bounds without those that are 0 too: so is that of any of them.
std::int64_t count_of(std::span<const std::int64_t> shape, const std::string& path) {
  constexpr std::int64_t most = std::numeric_limits<std::int64_t>::max() / 8;
  constexpr std::size_t most_dimensions = 64;
  if (shape.size() > most_dimensions) {
    throw UserError(path, std::to_string(shape.size()) + " dimensions; accepted: at most 64");
  }
  std::int64_t count = 1;
  bool empty = false;
  for (const std::int64_t size : shape) {
    empty = empty || size == 0;
    if (size == 0) continue;
    if (count > most / size) throw UserError(path, "shape " + npy_shape_text(shape) + " is too large");
    count *= size;
  }
  return empty ? 0 : count;
}

std::int64_t bytes_left(std::ifstream& file) {
  const auto here = file.tellg();
  file.seekg(0, std::ios::end);
  const auto end = file.tellg();
  file.seekg(here);
  return static_cast<std::int64_t>(end - here);
}

// '<f4' is little-endian, a float, of 4 bytes.
NumberType parse_type(const std::string& type, const std::string& path) {
  static constexpr std::string_view known[] = {"f2", "f4", "f8", "i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8"};
  const bool one_byte = type.ends_with("1");
  const bool ordered = type.size() == 3 && (type[0] == '<' || type[0] == '>' || (type[0] == '|' && one_byte));
  if (!ordered || std::find(std::begin(known), std::end(known), type.substr(1)) == std::end(known)) {
    throw UserError(path, "type \"" + type + "\"; accepted: " + std::string(accepted_types));
  }
  const NumberType::Kind kind = type[1] == 'f'   ? NumberType::Kind::floating
                                : type[1] == 'i' ? NumberType::Kind::signed_integer
                                                 : NumberType::Kind::unsigned_integer;
  return {kind, type[2] - '0', type[0] == '>'};
}

// The number of values; the file must hold as many.
std::int64_t checked_count(std::ifstream& file, const Header& header, const NumberType& type, const std::string& path) {
  const std::int64_t count = count_of(header.shape, path);
  const std::int64_t wanted = count * type.bytes;
  const std::int64_t found = bytes_left(file);
  if (found != wanted) {
    throw UserError(path, "shape " + npy_shape_text(header.shape) + " needs " + std::to_string(wanted) +
                              " bytes of values; the file holds " + std::to_string(found));
  }
  return count;
}

std::vector<double> read_values(std::ifstream& file, const Header& header, const NumberType& type,
                                const std::string& path) {
  const std::int64_t count = checked_count(file, header, type, path);
  std::vector<double> values(static_cast<std::size_t>(count));
  const std::size_t bytes = static_cast<std::size_t>(type.bytes);
  constexpr std::size_t chunk_values = std::size_t{1} << 16;
  std::vector<char> chunk(chunk_values * bytes);
  for (std::size_t at = 0; at < values.size(); at += chunk_values) {
    const std::size_t n = std::min(chunk_values, values.size() - at);
    file.read(chunk.data(), static_cast<std::streamsize>(n * bytes));
    if (!file) throw UserError(path, "cannot be read: " + std::string(std::strerror(errno)));
    for (std::size_t i = 0; i < n; ++i) {
      const char* const number = chunk.data() + i * bytes;
      if (!is_exact(number, type)) {
        throw UserError(path, "value " + std::to_string(at + i) + " = " + integer_text(number, type) +
                                  ": integers must lie within +-2^53");
      }
      values[at + i] = number_at(number, type);
    }
  }
  return values;
}

// From the order in which the first dimension varies fastest to that in which the last does.
std::vector<double> from_fortran_order(const std::vector<double>& values, const std::vector<std::int64_t>& shape) {
  std::vector<std::size_t> stride(shape.size(), 1);
  for (std::size_t d = 1; d < shape.size(); ++d) stride[d] = stride[d - 1] * static_cast<std::size_t>(shape[d - 1]);
  std::vector<std::int64_t> index(shape.size(), 0);
  std::vector<double> ordered(values.size());
  std::size_t from = 0;
  for (double& value : ordered) {
    value = values[from];
    for (std::size_t d = shape.size(); d-- > 0;) {
      from += stride[d];
      if (++index[d] < shape[d]) break;
      from -= stride[d] * static_cast<std::size_t>(shape[d]);
      index[d] = 0;
    }
  }
  return ordered;
}

std::ifstream open_npy(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw UserError(path, "cannot be opened: " + std::string(std::strerror(errno)));
  return file;
}

}  // namespace

std::string npy_shape_text(std::span<const std::int64_t> shape) {
  std::string text = "(";
  for (const std::int64_t size : shape) text += std::to_string(size) + (shape.size() == 1 ? "," : ", ");
  if (shape.size() > 1) text.resize(text.size() - 2);
  return text + ")";
}

NpyArray read_npy(const std::string& path) {
  std::ifstream file = open_npy(path);
  Header header = read_header(file, path);
  const NumberType type = parse_type(header.type, path);
  NpyArray array{{}, read_values(file, header, type, path), type};
  if (header.fortran_order && header.shape.size() > 1) array.values = from_fortran_order(array.values, header.shape);
  array.shape = std::move(header.shape);
  return array;
}

std::vector<std::int64_t> read_npy_shape(const std::string& path) {
  std::ifstream file = open_npy(path);
  const Header header = read_header(file, path);
  checked_count(file, header, parse_type(header.type, path), path);
  return header.shape;
}

namespace {

std::string header_of(std::string_view type, std::span<const std::int64_t> shape) {
  std::string dict =
      "{'descr': '" + std::string(type) + "', 'fortran_order': False, 'shape': " + npy_shape_text(shape) + ", }";
  // Values begin at a multiple of 64 bytes; the header ends with a newline.
  constexpr std::size_t before = 10;
  dict.resize((before + dict.size() + 1 + 63) / 64 * 64 - before - 1, ' ');
  dict += '\n';
  std::string header(magic);
  header += {'\x01', '\x00', static_cast<char>(dict.size() & 0xff), static_cast<char>(dict.size() >> 8)};
  return header + dict;
}

}  // namespace

std::string npy_float32_header(std::span<const std::int64_t> shape) { return header_of("<f4", shape); }
std::string npy_int64_header(std::span<const std::int64_t> shape) { return header_of("<i8", shape); }

void write_npy(const std::string& path, std::span<const std::int64_t> shape, std::span<const float> values) {
  NOISELOOM_CHECK_EQ(count_of(shape, path), static_cast<std::int64_t>(values.size()));
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  const std::string header = npy_float32_header(shape);
  file.write(header.data(), static_cast<std::streamsize>(header.size()));
  file.write(reinterpret_cast<const char*>(values.data()), static_cast<std::streamsize>(values.size_bytes()));
  file.close();
  if (!file) throw EnvironmentError(path + ": cannot be written: " + std::strerror(errno));
}

}  // namespace noiseloom
