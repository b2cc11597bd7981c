#include "noiseloom/files/npz.h"

#include <fmt/format.h>

#include <array>
#include <bit>
#include <cerrno>
#include <fstream>
#include <system_error>

#include "noiseloom/core/error.h"
#include "noiseloom/files/npy.h"

namespace noiseloom {
namespace {

static_assert(std::endian::native == std::endian::little, "floats are written as they lie in memory");

// The checksum that zip archives have: the polynomial 0xEDB88320, bits reversed.
class Crc32 {
 public:
  Crc32() {
    for (std::uint32_t i = 0; i < 256; ++i) {
      std::uint32_t value = i;
      for (int bit = 0; bit < 8; ++bit) value = (value >> 1) ^ ((value & 1) != 0 ? 0xEDB88320U : 0U);
      table_[i] = value;
    }
  }
  void add(const char* bytes, std::size_t size) {
    for (std::size_t i = 0; i < size; ++i) {
      sum_ = table_[(sum_ ^ static_cast<unsigned char>(bytes[i])) & 0xFFU] ^ (sum_ >> 8);
    }
  }
  std::uint32_t value() const { return ~sum_; }

 private:
  std::array<std::uint32_t, 256> table_{};
  std::uint32_t sum_ = ~0U;
};

class ZipRecord {
 public:
  ZipRecord& u16(std::uint32_t value) { return bytes(value, 2); }
  ZipRecord& u32(std::uint64_t value) { return bytes(value, 4); }
  ZipRecord& text(const std::string& text) {
    text_ += text;
    return *this;
  }
  const std::string& str() const { return text_; }

 private:
  ZipRecord& bytes(std::uint64_t value, int count) {
    for (int i = 0; i < count; ++i) text_ += static_cast<char>(value >> (8 * i) & 0xFF);
    return *this;
  }
  std::string text_;
};

struct ZipEntry {
  std::string name;
  std::uint32_t crc = 0;
  std::uint64_t size = 0;
  std::uint64_t offset = 0;

  // What a local header and the central directory have in common: version 2.0, no flags, stored, the first day of 1980.
  void describe(ZipRecord& record) const {
    record.u16(20).u16(0).u16(0).u16(0).u16(0x21).u32(crc).u32(size).u32(size);
    record.u16(static_cast<std::uint32_t>(name.size())).u16(0);
  }
};

}  // namespace

void write_npz(const std::string& path, const std::vector<NpzArray>& arrays) {
  constexpr std::uint64_t most = 0xFFFFFFFF;
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  std::vector<ZipEntry> entries;
  std::uint64_t at = 0;
  const auto put = [&](const char* bytes, std::size_t size) {
    file.write(bytes, static_cast<std::streamsize>(size));
    at += size;
  };
  for (const NpzArray& array : arrays) {
    const std::string header = npy_float32_header(array.shape);
    const auto* const values = reinterpret_cast<const char*>(array.values.data());
    const std::size_t bytes = array.values.size() * sizeof(float);
    if (at + header.size() + bytes + 4096 > most) {
      throw UserError(
          path, fmt::format("{} would take {} bytes; an .npz of this kind holds less than 4 GiB", array.name, bytes));
    }
    Crc32 crc;
    crc.add(header.data(), header.size());
    crc.add(values, bytes);
    const ZipEntry entry{array.name + ".npy", crc.value(), header.size() + bytes, at};
    ZipRecord local;
    local.u32(0x04034B50);
    entry.describe(local);
    local.text(entry.name);
    put(local.str().data(), local.str().size());
    put(header.data(), header.size());
    put(values, bytes);
    entries.push_back(entry);
  }
  ZipRecord directory;
  for (const ZipEntry& entry : entries) {
    directory.u32(0x02014B50).u16(20);
    entry.describe(directory);
    directory.u16(0).u16(0).u16(0).u32(0).u32(entry.offset).text(entry.name);
  }
  const std::size_t directory_size = directory.str().size();
  const auto count = static_cast<std::uint32_t>(entries.size());
  directory.u32(0x06054B50).u16(0).u16(0).u16(count).u16(count).u32(directory_size).u32(at).u16(0);
  put(directory.str().data(), directory.str().size());
  file.close();
  if (!file) throw EnvironmentError(fmt::format("{}: cannot write: {}", path, std::system_category().message(errno)));
}

}  // namespace noiseloom
