#include "noiseloom/files/pack.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <limits>
#include <map>
#include <optional>

#include "files/hdf5_objects.h"
#include "files/run_file_slices.h"
#include "noiseloom/core/error.h"
#include "noiseloom/files/file_ops.h"
#include "noiseloom/files/run_file.h"

namespace noiseloom {
namespace {

constexpr const char* packed_datasets[] = {"/samples", "/pdf"};

class Packer {
 public:
  Packer(const std::string& path, std::size_t num_members, PackKind kind)
      : kind_(kind),
        file_(H5Fcreate(path.c_str(), H5F_ACC_EXCL, H5P_DEFAULT, H5P_DEFAULT), H5Fclose, path + ": cannot create"),
        at_{file_.id(), path},
        num_members_(num_members) {}

  void add(const RunFileReader& member, std::size_t number);
  void write_texts(const std::string& name, const std::vector<std::string>& texts) const;
  void write_setting(const std::string& key, const std::vector<std::string>& values) const;
  void write_numbers(const std::string& name, const std::vector<double>& values) const {
    hdf5::write_numbers(at_, name, values);
  }
  // After the last member.
  void close();

 private:
  struct Packed {
    SliceDataset spec;
    hdf5::Handle data;           // copied
    hdf5::Handle sources;        // virtual: a list for making the dataset
    std::vector<hsize_t> shape;  // of one member
    std::vector<std::string> labels = {};
  };
  void begin(const RunFileReader& first);
  void copy(const RunFileReader& member, int dataset, const Packed& to, std::size_t number) const;
  void refer(const RunFileReader& member, const Packed& to, std::size_t number) const;
  std::vector<hsize_t> dimensions_of_all(const Packed& packed) const;

  PackKind kind_;
  hdf5::Handle file_;
  hdf5::Location at_;
  std::size_t num_members_;
  std::map<std::string, Packed> packed_;
};

void Packer::begin(const RunFileReader& first) {
  for (const char* name : packed_datasets) {
    const int dataset = first.dataset(name);
    if (dataset < 0) continue;
    const SliceDataset& spec = first.content().datasets[static_cast<std::size_t>(dataset)];
    Packed packed{.spec = spec, .data = {}, .sources = {}, .shape = dimensions_of(spec, first.content().extents)};
    packed.labels = labels_of(spec, first.content().extents);
    packed.labels.insert(packed.labels.begin(), "member");
    if (kind_ == PackKind::copied) {
      packed.data = hdf5::create_dataset(at_, name, H5T_IEEE_F32LE, dimensions_of_all(packed));
    } else {
      const std::string what = at_.name + ": cannot prepare " + name;
      packed.sources = hdf5::Handle(H5Pcreate(H5P_DATASET_CREATE), H5Pclose, what);
      hdf5::checked(H5Pset_obj_track_times(packed.sources.id(), false), what);
      const float nothing = std::numeric_limits<float>::quiet_NaN();  // of a member whose file is gone
      hdf5::checked(H5Pset_fill_value(packed.sources.id(), H5T_NATIVE_FLOAT, &nothing), what);
    }
    packed_.emplace(name, std::move(packed));
  }
}

std::vector<hsize_t> Packer::dimensions_of_all(const Packed& packed) const {
  std::vector<hsize_t> all = packed.shape;
  all.insert(all.begin(), num_members_);
  return all;
}

void Packer::close() {
  for (auto& [name, packed] : packed_) {
    if (kind_ == PackKind::links) {
      const std::string what = at_.name + ": cannot create " + name;
      const std::vector<hsize_t> all = dimensions_of_all(packed);
      const hdf5::Handle space(H5Screate_simple(static_cast<int>(all.size()), all.data(), nullptr), H5Sclose, what);
      packed.data = hdf5::Handle(H5Dcreate2(file_.id(), name.c_str(), H5T_IEEE_F32LE, space.id(), H5P_DEFAULT,
                                            packed.sources.id(), H5P_DEFAULT),
                                 H5Dclose, what);
    }
    hdf5::write_dimension_labels(at_, packed.data.id(), packed.labels);
    packed.data.close(at_.name + ": cannot close " + name);
  }
  file_.close(at_.name + ": cannot close");
}

// By the path from this file's folder to the member's, so that both may be moved together. HDF5 reads "%b" in it as a
// number of a block, and "%%" as one sign.
void Packer::refer(const RunFileReader& member, const Packed& to, std::size_t number) const {
  const std::string what = at_.name + ": cannot refer to " + member.path();
  const auto place = [](const std::string& path) {
    return std::filesystem::weakly_canonical(std::filesystem::absolute(path));
  };
  const std::string path = place(member.path()).lexically_relative(place(parent_directory(at_.name))).string();
  std::string escaped;
  for (const char c : path) escaped += c == '%' ? std::string("%%") : std::string(1, c);
  const std::vector<hsize_t> all = dimensions_of_all(to);
  const hdf5::Handle space(H5Screate_simple(static_cast<int>(all.size()), all.data(), nullptr), H5Sclose, what);
  const hdf5::Handle source(H5Screate_simple(static_cast<int>(to.shape.size()), to.shape.data(), nullptr), H5Sclose,
                            what);
  std::vector<hsize_t> start(all.size(), 0);
  start[0] = number;
  std::vector<hsize_t> count = all;
  count[0] = 1;
  hdf5::checked(H5Sselect_hyperslab(space.id(), H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr), what);
  hdf5::checked(H5Pset_virtual(to.sources.id(), space.id(), escaped.c_str(), to.spec.name.c_str(), source.id()), what);
}

void Packer::add(const RunFileReader& member, std::size_t number) {
  if (number == 0) begin(member);
  for (const auto& [name, packed] : packed_) {
    const int dataset = member.dataset(name);
    const bool fits = dataset >= 0 && member.content().datasets[static_cast<std::size_t>(dataset)] == packed.spec &&
                      dimensions_of(packed.spec, member.content().extents) == packed.shape;
    if (!fits) {
      throw UserError(member.path(), fmt::format("{} is not of the shape and kind of the first member's: such banks "
                                                 "are not packed into one array",
                                                 name));
    }
    if (kind_ == PackKind::copied) {
      copy(member, dataset, packed, number);
    } else {
      refer(member, packed, number);
    }
  }
}

// Slice by slice, in the order of the file.
void Packer::copy(const RunFileReader& member, int dataset, const Packed& to, std::size_t number) const {
  const std::string what = at_.name + ": cannot write " + to.spec.name;
  const Extents& extents = member.content().extents;
  std::vector<std::byte> bytes(bytes_per_slice(to.spec, extents));
  const hsize_t cells = bytes.size() / sizeof(float);
  const hdf5::Handle memory(H5Screate_simple(1, &cells, nullptr), H5Sclose, what);
  const hdf5::Handle space(H5Dget_space(to.data.id()), H5Sclose, what);
  const std::size_t num_slice_axes = static_cast<std::size_t>(extents.num_axes()) - 2;
  for (const SliceIndex slice : extents.slices()) {
    std::vector<hsize_t> start(to.shape.size() + 1, 0);
    std::vector<hsize_t> count = to.shape;
    count.insert(count.begin(), 1);
    start[0] = number;
    auto rest = static_cast<hsize_t>(slice);
    for (std::size_t axis = num_slice_axes; axis > 0; --axis) {  // the last one before y varies fastest in the file
      start[axis] = rest % to.shape[axis - 1];
      rest /= to.shape[axis - 1];
      count[axis] = 1;
    }
    member.read_slice(dataset, slice, bytes);
    hdf5::checked(H5Sselect_hyperslab(space.id(), H5S_SELECT_SET, start.data(), nullptr, count.data(), nullptr), what);
    hdf5::checked(H5Dwrite(to.data.id(), H5T_IEEE_F32LE, memory.id(), space.id(), H5P_DEFAULT, bytes.data()), what);
  }
}

void Packer::write_texts(const std::string& name, const std::vector<std::string>& texts) const {
  const std::string what = at_.name + ": cannot write " + name;
  std::size_t longest = 1;
  for (const std::string& text : texts) longest = std::max(longest, text.size());
  std::string padded;
  for (std::string text : texts) {
    text.resize(longest, '\0');
    padded += text;
  }
  const hdf5::Handle type(H5Tcopy(H5T_C_S1), H5Tclose, what);
  hdf5::checked(H5Tset_size(type.id(), longest), what);
  hdf5::checked(H5Tset_cset(type.id(), H5T_CSET_UTF8), what);
  hdf5::checked(H5Tset_strpad(type.id(), H5T_STR_NULLPAD), what);
  hdf5::Handle data = hdf5::create_dataset(at_, name, type.id(), {texts.size()});
  hdf5::checked(H5Dwrite(data.id(), type.id(), H5S_ALL, H5S_ALL, H5P_DEFAULT, padded.data()), what);
}

// Numbers where all values are.
void Packer::write_setting(const std::string& key, const std::vector<std::string>& values) const {
  if (!hdf5::exists(at_, "/settings")) hdf5::create_group(at_, "/settings", true);
  std::vector<double> numbers;
  for (const std::string& value : values) {
    double number = 0;
    const auto read = std::from_chars(value.data(), value.data() + value.size(), number);
    if (read.ec != std::errc() || read.ptr != value.data() + value.size()) {
      return write_texts("/settings/" + key, values);
    }
    numbers.push_back(number);
  }
  hdf5::write_numbers(at_, "/settings/" + key, numbers);
}

}  // namespace

bool looks_like_pack(const std::string& path) {
  const hdf5::Quiet quiet;
  if (H5Fis_hdf5(path.c_str()) <= 0) return false;
  const hdf5::Handle file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose, path + ": cannot open");
  const hdf5::Location at{file.id(), path};
  return hdf5::exists(at, "/samples") && hdf5::exists(at, "/name") && hdf5::exists(at, "/checksum");
}

void pack_run_files(const std::string& path, const std::vector<PackMember>& members,
                    const std::vector<std::string>& settings, PackKind kind) {
  const hdf5::Quiet quiet;
  Packer packer(path, members.size(), kind);
  std::vector<std::string> names;
  std::vector<std::string> checksums;
  std::vector<double> errors;
  for (const PackMember& member : members) {
    const RunFileReader reader(member.path);
    packer.add(reader, names.size());
    names.push_back(member.name);
    checksums.push_back(reader.content().checksums.at("/samples"));
    const auto error = reader.content().state.find("relative_error");
    const auto* value = error == reader.content().state.end() ? nullptr : std::get_if<double>(&error->second);
    errors.push_back(value != nullptr ? *value : std::numeric_limits<double>::quiet_NaN());
  }
  packer.write_texts("/name", names);
  packer.write_texts("/checksum", checksums);
  packer.write_numbers("/relative_error", errors);
  for (std::size_t k = 0; k < settings.size(); ++k) {
    std::vector<std::string> values;
    for (const PackMember& member : members) values.push_back(member.values.at(k));
    packer.write_setting(settings[k], values);
  }
  packer.close();
}

}  // namespace noiseloom
