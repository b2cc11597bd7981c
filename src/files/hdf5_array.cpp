#include "noiseloom/files/hdf5_array.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "files/hdf5_handle.h"
#include "noiseloom/core/error.h"

namespace noiseloom {
namespace {

namespace fs = std::filesystem;

// Deflate packs at most 1032 bytes into one; small arrays may claim what they like.
constexpr double most_bytes_per_stored_byte = 1100;
constexpr double bytes_of_any_array = 1 << 20;
constexpr std::size_t most_listed = 200;

std::string shape_text(const std::vector<std::int64_t>& shape) {
  std::string text;
  for (const std::int64_t n : shape) text += fmt::format("{}{}", text.empty() ? "" : " x ", n);
  return text;
}

class ForeignFile {
 public:
  explicit ForeignFile(const std::string& path) : path_(path) {
    if (!fs::is_regular_file(path)) throw UserError(path, "no such file, or a folder or device");
    file_ = hdf5::Handle(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose, path);
  }

  hid_t id() const { return file_.id(); }
  const std::string& path() const { return path_; }

  // Names of the datasets, from the root, without the slash in front.
  std::vector<std::string> datasets() const {
    std::vector<std::string> names;
    H5Lvisit(file_.id(), H5_INDEX_NAME, H5_ITER_INC, collect, &names);  // what could be listed before a fault will do
    std::vector<std::string> found;
    for (const std::string& name : names)
      if (is_dataset(name)) found.push_back(name);
    return found;
  }

  bool is_dataset(const std::string& name) const {
    const hid_t object = H5Oopen(file_.id(), name.c_str(), H5P_DEFAULT);
    if (object < 0) return false;
    const bool is = H5Iget_type(object) == H5I_DATASET;
    H5Oclose(object);
    return is;
  }

 private:
  static herr_t collect(hid_t, const char* name, const H5L_info_t*, void* data) {
    auto& names = *static_cast<std::vector<std::string>*>(data);
    if (names.size() >= most_listed) return 1;  // ends the visit
    names.emplace_back(name);
    return 0;
  }

  std::string path_;
  hdf5::Handle file_;
};

// A dataset whose type and size can be read.
class ForeignDataset {
 public:
  ForeignDataset(const ForeignFile& file, const std::string& name)
      : where_(file.path() + ":" + name), dataset_(H5Dopen2(file.id(), name.c_str(), H5P_DEFAULT), H5Dclose, where_) {
    read_type();
    read_shape();
    check_storage();
  }

  const std::vector<std::int64_t>& shape() const { return shape_; }
  const NumberType& type() const { return type_; }

  std::vector<double> values() const {
    std::size_t count = 1;
    for (const std::int64_t size : shape_) count *= static_cast<std::size_t>(size);
    std::vector<double> values(count);
    if (count > 0)
      hdf5::checked(H5Dread(dataset_.id(), H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()), where_);
    return values;
  }

 private:
  void read_type() {
    const hdf5::Handle type(H5Dget_type(dataset_.id()), H5Tclose, where_);
    const H5T_class_t kind = H5Tget_class(type.id());
    const std::size_t bytes = H5Tget_size(type.id());
    const bool is_float = kind == H5T_FLOAT && (bytes == 2 || bytes == 4 || bytes == 8);
    const bool is_integer = kind == H5T_INTEGER && (bytes == 1 || bytes == 2 || bytes == 4 || bytes == 8);
    if (!is_float && !is_integer)
      throw UserError(where_, "no array of plain numbers; accepted: floats of 16 to 64 bits and integers of 8 to 64");
    type_.bytes = static_cast<int>(bytes);
    type_.big_endian = H5Tget_order(type.id()) == H5T_ORDER_BE;
    type_.kind = is_float                              ? NumberType::Kind::floating
                 : H5Tget_sign(type.id()) == H5T_SGN_2 ? NumberType::Kind::signed_integer
                                                       : NumberType::Kind::unsigned_integer;
  }

  void read_shape() {
    const hdf5::Handle space(H5Dget_space(dataset_.id()), H5Sclose, where_);
    const int num_axes = hdf5::checked(H5Sget_simple_extent_ndims(space.id()), where_);
    std::vector<hsize_t> sizes(static_cast<std::size_t>(num_axes));
    hdf5::checked(H5Sget_simple_extent_dims(space.id(), sizes.data(), nullptr), where_);
    double count = 1;
    for (const hsize_t size : sizes) {
      count *= static_cast<double>(std::max<hsize_t>(size, 1));
      if (count > 0x1p60) throw UserError(where_, "the array claims more numbers than any file can hold");
      shape_.push_back(static_cast<std::int64_t>(size));
    }
    num_bytes_ = count * type_.bytes;
  }

  void check_storage() {
    const hdf5::Handle list(H5Dget_create_plist(dataset_.id()), H5Pclose, where_);
    const H5D_layout_t layout = H5Pget_layout(list.id());
    const bool outside = H5Pget_external_count(list.id()) > 0 ||
                         (layout != H5D_CONTIGUOUS && layout != H5D_COMPACT && layout != H5D_CHUNKED);
    if (outside) throw UserError(where_, "its values lie in other files; accepted: arrays stored in the file itself");
    const double stored = static_cast<double>(H5Dget_storage_size(dataset_.id()));
    if (stored == 0) throw UserError(where_, "the array has no values: none were ever written");
    if (num_bytes_ > most_bytes_per_stored_byte * stored + bytes_of_any_array)
      throw UserError(where_, fmt::format("{} claims {:.0f} bytes, but the file holds {:.0f} for them",
                                          shape_text(shape_), num_bytes_, stored));
  }

  std::string where_;
  hdf5::Handle dataset_;
  NumberType type_;
  std::vector<std::int64_t> shape_;
  double num_bytes_ = 0;
};

[[noreturn]] void ask_for_dataset(const ForeignFile& file, const std::string& found) {
  std::string list;
  for (const std::string& name : file.datasets()) {
    try {
      const ForeignDataset dataset(file, "/" + name);
      if (dataset.shape().size() >= 2)
        list += fmt::format("{}{}:/{} ({})", list.empty() ? "" : ", ", file.path(), name, shape_text(dataset.shape()));
    } catch (const std::runtime_error&) {  // no array of numbers
    }
  }
  throw UserError(file.path(),
                  list.empty() ? found + "; it holds no arrays of numbers" : found + "; accepted: " + list);
}

// The only array of two or more dimensions, else the user is asked.
std::string only_dataset(const ForeignFile& file) {
  std::string only;
  for (const std::string& name : file.datasets()) {
    try {
      if (ForeignDataset(file, "/" + name).shape().size() < 2) continue;
    } catch (const std::runtime_error&) {
      continue;
    }
    if (!only.empty()) ask_for_dataset(file, "an HDF5 file that is no run file; name one of its datasets");
    only = "/" + name;
  }
  if (only.empty()) ask_for_dataset(file, "an HDF5 file that is no run file");
  return only;
}

template <class Result, class Action>
Result with_dataset(const std::string& name, Action action) {
  const hdf5::Quiet quiet;
  const std::optional<DatasetName> parts = split_dataset_name(name);
  const std::string path = parts ? parts->file : name;
  if (!std::ifstream(path)) throw EnvironmentError(path + ": cannot be read: " + std::strerror(errno));
  try {
    const ForeignFile file(path);
    const std::string dataset = parts ? parts->dataset : only_dataset(file);
    if (!file.is_dataset(dataset)) ask_for_dataset(file, "no dataset " + dataset);
    return action(ForeignDataset(file, dataset));
  } catch (const EnvironmentError& error) {  // the library's: a file that it cannot read is the user's fault
    throw UserError(path,
                    std::string("not a run file of noiseloom, or one whose beginning is damaged, and cannot be read "
                                "as HDF5 either: ") +
                        error.what());
  }
}

}  // namespace

std::optional<DatasetName> split_dataset_name(const std::string& text) {
  std::error_code error;
  for (std::size_t at = text.find(":/"); at != std::string::npos; at = text.find(":/", at + 1))
    if (fs::is_regular_file(text.substr(0, at), error)) return DatasetName{text.substr(0, at), text.substr(at + 1)};
  return std::nullopt;
}

bool is_hdf5(const std::string& path) {
  constexpr std::array<char, 8> signature = {'\x89', 'H', 'D', 'F', '\r', '\n', '\x1a', '\n'};
  std::ifstream file(path, std::ios::binary);
  for (std::int64_t at = 0; file && at < std::int64_t{1} << 20; at = at == 0 ? 512 : 2 * at) {
    std::array<char, 8> found{};
    file.seekg(at);
    file.read(found.data(), found.size());
    if (file && found == signature) return true;
  }
  return false;
}

std::vector<std::int64_t> hdf5_array_shape(const std::string& name) {
  return with_dataset<std::vector<std::int64_t>>(name, [](const ForeignDataset& dataset) { return dataset.shape(); });
}

Hdf5Array read_hdf5_array(const std::string& name) {
  return with_dataset<Hdf5Array>(name, [](const ForeignDataset& dataset) {
    return Hdf5Array{dataset.shape(), dataset.values(), dataset.type()};
  });
}

}  // namespace noiseloom
