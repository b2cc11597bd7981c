#include "noiseloom/files/pack.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <limits>
#include <map>
#include <optional>

#include "files/hdf5_objects.h"
#include "files/run_file_slices.h"
#include "noiseloom/core/error.h"
#include "noiseloom/files/run_file.h"

namespace noiseloom {
namespace {

constexpr const char* packed_datasets[] = {"/samples", "/pdf"};

class Packer {
 public:
  Packer(const std::string& path, std::size_t num_members)
      : file_(H5Fcreate(path.c_str(), H5F_ACC_EXCL, H5P_DEFAULT, H5P_DEFAULT), H5Fclose, path + ": cannot create"),
        at_{file_.id(), path},
        num_members_(num_members) {}

  void add(const RunFileReader& member, std::size_t number);
  void write_texts(const std::string& name, const std::vector<std::string>& texts) const;
  void write_setting(const std::string& key, const std::vector<std::string>& values) const;
  void write_numbers(const std::string& name, const std::vector<double>& values) const {
    hdf5::write_numbers(at_, name, values);
  }
  void close() {
    for (auto& [name, packed] : packed_) packed.data.close(at_.name + ": cannot close " + name);
    file_.close(at_.name + ": cannot close");
  }

 private:
  struct Packed {
    SliceDataset spec;
    hdf5::Handle data;
    std::vector<hsize_t> shape;  // of one member
  };
  void begin(const RunFileReader& first);
  void copy(const RunFileReader& member, int dataset, const Packed& to, std::size_t number) const;

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
    std::vector<hsize_t> all = dimensions_of(spec, first.content().extents);
    std::vector<std::string> labels = labels_of(spec, first.content().extents);
    Packed packed{.spec = spec, .data = {}, .shape = all};
    all.insert(all.begin(), num_members_);
    labels.insert(labels.begin(), "member");
    packed.data = hdf5::create_dataset(at_, name, H5T_IEEE_F32LE, all);
    hdf5::write_dimension_labels(at_, packed.data.id(), labels);
    packed_.emplace(name, std::move(packed));
  }
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
    copy(member, dataset, packed, number);
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
  for (SliceIndex slice = 0; slice < extents.num_slices(); ++slice) {
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
                    const std::vector<std::string>& settings) {
  const hdf5::Quiet quiet;
  Packer packer(path, members.size());
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
