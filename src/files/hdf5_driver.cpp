#include "files/hdf5_driver.h"

#if H5_VERSION_GE(1, 13, 0)
#include <H5FDdevelop.h>  // what a driver is made of; in hdf5.h itself before
#endif

#include <algorithm>
#include <limits>

namespace noiseloom::hdf5 {
namespace {

// What HDF5 holds: its own part comes first, as it asks of every driver.
struct OpenFile {
  H5FD_t base;
  std::shared_ptr<DriverFile> file;
  haddr_t eoa;  // end of the addresses that HDF5 has given out
  haddr_t eof;  // end of what is in the file
  bool writing;
};

OpenFile& open_file_of(H5FD_t* base) { return *reinterpret_cast<OpenFile*>(base); }
const OpenFile& open_file_of(const H5FD_t* base) { return *reinterpret_cast<const OpenFile*>(base); }

herr_t report(const char* function, const char* text) {
  H5Epush2(H5E_DEFAULT, __FILE__, function, __LINE__, H5E_ERR_CLS, H5E_IO, H5E_READERROR, "%s", text);
  return -1;
}

// No exception may pass through HDF5.
template <class Body>
herr_t guarded(const char* function, Body body) {
  try {
    body();
    return 0;
  } catch (const std::exception& error) {
    return report(function, error.what());
  }
}

// The driver information on the access list is a pointer to the caller's shared pointer; it is only followed here,
// during H5Fcreate and H5Fopen.
using DriverInfo = const std::shared_ptr<DriverFile>*;

H5FD_t* open_callback(const char*, unsigned flags, hid_t fapl, haddr_t) {
  OpenFile* opened = nullptr;
  const herr_t status = guarded("noiseloom driver: open", [&] {
    const void* info = H5Pget_driver_info(fapl);
    if (!info) throw std::invalid_argument("no file was given");
    const std::shared_ptr<DriverFile>& file = **static_cast<const DriverInfo*>(info);
    const bool writing = (flags & H5F_ACC_RDWR) != 0;
    opened = new OpenFile{{}, file, 0, writing ? 0 : file->size(), writing};
  });
  return status < 0 ? nullptr : &opened->base;
}

herr_t close_callback(H5FD_t* base) {
  delete &open_file_of(base);
  return 0;
}

herr_t query_callback(const H5FD_t*, unsigned long* flags) {
  *flags = H5FD_FEAT_AGGREGATE_METADATA | H5FD_FEAT_ACCUMULATE_METADATA | H5FD_FEAT_DATA_SIEVE |
           H5FD_FEAT_AGGREGATE_SMALLDATA | H5FD_FEAT_DEFAULT_VFD_COMPATIBLE;
  return 0;
}

haddr_t get_eoa_callback(const H5FD_t* base, H5FD_mem_t) { return open_file_of(base).eoa; }

herr_t set_eoa_callback(H5FD_t* base, H5FD_mem_t, haddr_t address) {
  open_file_of(base).eoa = address;
  return 0;
}

haddr_t get_eof_callback(const H5FD_t* base, H5FD_mem_t) { return open_file_of(base).eof; }

herr_t read_callback(H5FD_t* base, H5FD_mem_t, hid_t, haddr_t address, size_t size, void* buffer) {
  return guarded("noiseloom driver: read", [&] {
    OpenFile& opened = open_file_of(base);
    // What was allocated and not yet written reads as zeros.
    const auto there = address >= opened.eof ? 0 : std::min<std::size_t>(size, opened.eof - address);
    const std::span<std::byte> bytes(static_cast<std::byte*>(buffer), size);
    opened.file->read(address, bytes.first(there));
    std::ranges::fill(bytes.subspan(there), std::byte{0});
  });
}

herr_t write_callback(H5FD_t* base, H5FD_mem_t, hid_t, haddr_t address, size_t size, const void* buffer) {
  OpenFile& opened = open_file_of(base);
  opened.file->write(address, {static_cast<const std::byte*>(buffer), size});
  opened.eof = std::max<haddr_t>(opened.eof, address + size);
  return 0;
}

herr_t truncate_callback(H5FD_t* base, hid_t, hbool_t) {
  OpenFile& opened = open_file_of(base);
  if (opened.writing && opened.eof != opened.eoa) {
    opened.file->truncate(opened.eoa);
    opened.eof = opened.eoa;
  }
  return 0;
}

#if H5_VERSION_GE(1, 13, 0)
// Drivers have had numbers since 1.13: from 256 for those that are not registered with the HDF Group, up to 511.
constexpr int driver_number = 378;
#endif

hid_t driver_id() {
  static const H5FD_class_t driver = [] {
    H5FD_class_t c{};
#if H5_VERSION_GE(1, 13, 0)
    c.version = H5FD_CLASS_VERSION;
    c.value = static_cast<H5FD_class_value_t>(driver_number);
#endif
    c.name = "noiseloom";
    c.maxaddr = static_cast<haddr_t>(std::numeric_limits<std::int64_t>::max());
    c.fc_degree = H5F_CLOSE_STRONG;
    c.fapl_size = sizeof(DriverInfo);
    c.open = open_callback;
    c.close = close_callback;
    c.query = query_callback;
    c.get_eoa = get_eoa_callback;
    c.set_eoa = set_eoa_callback;
    c.get_eof = get_eof_callback;
    c.read = read_callback;
    c.write = write_callback;
    c.truncate = truncate_callback;
    const H5FD_mem_t one_list[] = H5FD_FLMAP_DICHOTOMY;
    std::copy(std::begin(one_list), std::end(one_list), c.fl_map);
    return c;
  }();
  static const hid_t id = checked(H5FDregister(&driver), "registering the file driver");
  return id;
}

void set_driver(const std::shared_ptr<DriverFile>& file, const std::string& name, hid_t fapl) {
  const DriverInfo info = &file;
  checked(H5Pset_driver(fapl, driver_id(), &info), name + ": cannot choose the file driver");
}

}  // namespace

void DriverFile::write(std::uint64_t offset, std::span<const std::byte> bytes) noexcept {
  if (dead_) return;
  try {
    ops_.write(fd_, offset, bytes);
  } catch (...) {
    error_ = std::current_exception();
    dead_ = true;
  }
}

void DriverFile::truncate(std::uint64_t size) noexcept {
  if (dead_) return;
  try {
    ops_.truncate(fd_, size);
  } catch (...) {
    error_ = std::current_exception();
    dead_ = true;
  }
}

Handle create_file(const std::shared_ptr<DriverFile>& file, const std::string& name, hid_t fcpl, hid_t fapl) {
  set_driver(file, name, fapl);
  return Handle(H5Fcreate(name.c_str(), H5F_ACC_TRUNC, fcpl, fapl), H5Fclose, name + ": cannot create");
}

Handle open_file(const std::shared_ptr<DriverFile>& file, const std::string& name, hid_t fapl) {
  set_driver(file, name, fapl);
  return Handle(H5Fopen(name.c_str(), H5F_ACC_RDONLY, fapl), H5Fclose, name + ": cannot open");
}

}  // namespace noiseloom::hdf5
